// What is seen through: plumes of steam, laid over the finished picture at full rate, as a renderer draws particles after all else. The
// next frame's analysis is shown the picture before and after. Only in a scene that declares transparents.

@group(0) @binding(20) var shown_out: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(21) var opaque: texture_2d<f32>;

const PLUMES: u32 = 5u;

@compute @workgroup_size(8, 8)
fn transparents(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let origin = frame.camera.position;
    let direction = ray(frame.camera, vec2<f32>(id.xy) + 0.5);
    let seen = frame.camera.near / max(textureLoad(depth, at, 0).x, 1e-6);
    var clear = 1.0;
    for (var i = 0u; i < PLUMES; i++) {
        let foot = vec2<f32>(2.4 * sin(f32(i) * 2.4), 5.0 + 3.1 * f32(i));
        // where the ray passes the plume's axis
        let flat = direction.xz;
        let along = dot(foot - origin.xz, flat) / max(dot(flat, flat), 1e-6);
        let p = origin + direction * along;
        let across = distance(p.xz, foot);
        let wide = 0.25 + 0.22 * p.y;
        let billow = rough_noise(vec2<f32>(dot(p.xz - foot, vec2<f32>(flat.y, -flat.x)) * 1.7 + 9.0 * f32(i), p.y * 1.3 - 1.1 * frame.time), 3u);
        let dense = smoothstep(wide, 0.0, across) * smoothstep(0.25, 0.75, billow) * smoothstep(-0.1, 0.5, p.y);
        if along > 0.3 && along < seen {
            clear *= 1.0 - 0.85 * dense;
        }
    }
    let behind = textureLoad(opaque, at, 0).rgb;
    textureStore(shown_out, at, vec4<f32>(mix(vec3<f32>(0.78, 0.79, 0.8), behind, clear), 1.0));
}
