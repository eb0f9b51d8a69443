// A relaxation in place: the cells of one colour are made anew from those of the other, which nobody stores in this dispatch.
@group(0) @binding(0) var field: texture_storage_2d<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x + id.y) % 2u == 1u {
        return;
    }
    let place = vec2<i32>(id.xy);
    let steps = array(vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1));
    var sum = 0.0;
    for (var k = 0; k < 4; k++) {
        let beside = clamp(place + steps[k], vec2(0), vec2<i32>(textureDimensions(field)) - 1);
        if all(beside == place + steps[k]) {
            sum += textureLoad(field, place + steps[k]).x;
        }
    }
    let old = textureLoad(field, place).x;
    textureStore(field, place, vec4(mix(old, sum / 4.0, 0.75) + f32(id.x * 3u + id.y), 0.0, 0.0, 1.0));
}
