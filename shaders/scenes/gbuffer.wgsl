// The rest of the G-buffer, each part for scenes that declare it: what a renderer writes beside `geometry`, at full rate.

// Surface ids without the triangles' in the same word.
@compute @workgroup_size(8, 8)
fn surface_ids(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    textureStore(surfaces_out, at, vec4<u32>(textureLoad(ids, at, 0).x & 0xffffu, 0u, 0u, 0u));
}

// Smoothness and Rf0, for the analysis, before anything is shaded.
@compute @workgroup_size(8, 8)
fn material_ids(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let seen = textureLoad(ids, at, 0).x & 0xffffu;
    if seen == SKY {
        textureStore(materials_out, at, vec4<f32>(0.0));
        return;
    }
    let point = point_of(id.xy, textureLoad(depth, at, 0).x);
    let made = scene_material(point, textureLoad(normals, at, 0).xyz, seen);
    let rf0 = dot(mix(vec3<f32>(0.04), made.colour, made.metal), vec3<f32>(0.299, 0.587, 0.114));
    textureStore(materials_out, at, vec4<f32>(1.0 - made.roughness, rf0, 0.0, 0.0));
}

// Where noise is, and how much of it, before anything is shaded.
@compute @workgroup_size(8, 8)
fn noise_mask(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    textureStore(noise_out, at, vec4<f32>(grain_at(textureLoad(depth, at, 0).x), 0.0, 0.0, 0.0));
}

// Motion that follows from depth and where the camera was: what a renderer without motion vectors makes of what it has.
@compute @workgroup_size(8, 8)
fn camera_motion(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let inverse = textureLoad(depth, at, 0).x;
    var point = point_of(id.xy, inverse);
    if inverse == 0.0 {
        // the sky is infinitely far: only turning moves it
        point = frame.camera_before.position + ray(frame.camera, vec2<f32>(id.xy) + 0.5) * 1e4;
    }
    let before = seen_at(frame.camera_before, point);
    textureStore(motion_out, at, vec4<f32>(vec2<f32>(id.xy) + 0.5 - before, 0.0, 0.0));
}
