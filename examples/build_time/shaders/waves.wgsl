#define_import_path lib::waves

// Imported by light.wgsl; on its own it is no shader.
fn height(at: vec2<f32>, time: f32) -> f32 {
    var sum = 0.0;
    for (var i = 1; i <= #{WAVES}; i++) {
        let k = f32(i);
        sum += sin(dot(at, vec2(cos(k), sin(k))) * k * 3.0 + time * k) / k;
    }
    return sum;
}
