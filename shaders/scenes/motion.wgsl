// Motion vectors of what each pixel shows: for scenes that declare them.

// Pixels that a place has moved since it was seen `before`.
fn note_motion(pixel: vec2<u32>, before: vec2<f32>) {
    textureStore(motion_out, vec2<i32>(pixel), vec4<f32>(vec2<f32>(pixel) + 0.5 - before, 0.0, 0.0));
}

fn note_motion_of(pixel: vec2<u32>, point: vec3<f32>, surface: u32) {
    note_motion(pixel, seen_at(frame.camera_before, moved(point, surface)));
}

// The sky is infinitely far: only turning moves it.
fn note_motion_of_sky(pixel: vec2<u32>, direction: vec3<f32>) {
    note_motion(pixel, seen_at(frame.camera_before, frame.camera_before.position + direction * 1e4));
}
