// Which pixels may take each other's results: what coverage is told by, over the tile and a pixel around it, and the rule.
//
// Its CPU twin is src/coverage/cpu.rs.

#ifdef COVERAGE
const HALO: vec2<u32> = TILE + 2u;
#ifdef TRIANGLES
var<workgroup> triangles: array<u32, HALO.x * HALO.y>;
#endif
#ifdef SURFACES
var<workgroup> surfaces: array<u32, AREA>;
#endif
#ifdef DEPTH
var<workgroup> inverse: array<f32, HALO.x * HALO.y>;
#endif
#ifdef NORMALS
// Three signed bytes, each plus 128.
var<workgroup> normals: array<u32, AREA>;
#endif
#ifdef SKY
var<workgroup> is_sky: array<u32, AREA>;
#endif

// The size of the textures that samples are in.
fn samples_size() -> vec2<u32> {
    var size = vec2<u32>(1u);
#ifdef TRIANGLES
    size = textureDimensions(triangle_texture);
#endif
#ifdef SURFACES
    size = textureDimensions(surface_texture);
#endif
#ifdef DEPTH
    size = textureDimensions(depth_texture);
#endif
    return size;
}

// The texel that stands for a pixel. At half the size the last row or column may have one texel only.
fn texel_of(pixel: vec2<i32>) -> vec2<i32> {
    let inside = clamp(pixel, vec2<i32>(0), vec2<i32>(params.extent) - 1);
    let texel = inside * (i32(params.sample_scale) + 1) + vec2<i32>(params.sample_at);
    return min(texel, vec2<i32>(samples_size()) - 1);
}

fn in_halo(pixel: vec2<i32>) -> u32 {
    return u32(pixel.y + 1) * HALO.x + u32(pixel.x + 1);
}

#ifdef DEPTH
// Cuts to 16 significant bits; what is not finite, or negative, becomes -1, which is close to nothing.
fn quantise(value: f32) -> f32 {
    let bits = bitcast<u32>(value);
    if (bits & 0x7f800000u) == 0x7f800000u || ((bits & 0x80000000u) != 0u && value != 0.0) {
        return -1.0;
    }
    return bitcast<f32>(bits & 0x7fffff00u);
}
#endif

fn load_samples(origin: vec2<u32>, index: u32) {
    for (var i = index; i < HALO.x * HALO.y; i += QUAD_COUNT) {
        let at = vec2<i32>(i32(i % HALO.x), i32(i / HALO.x)) - 1;
        let texel = texel_of(vec2<i32>(origin) + at);
#ifdef TRIANGLES
        let triangle = textureLoad(triangle_texture, texel, 0).x;
        triangles[i] = triangle;
#endif
#ifdef DEPTH
        let depth = textureLoad(depth_texture, texel, 0).x;
#ifdef LINEAR
        inverse[i] = quantise(1.0 / depth);
#else
        inverse[i] = quantise(depth * params.depth_scale + params.depth_bias);
#endif
#endif
        if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(TILE)) {
            continue;
        }
        let own = u32(at.y) * TILE.x + u32(at.x);
#ifdef SURFACES
        let surface = textureLoad(surface_texture, texel, 0).x;
        surfaces[own] = surface;
#endif
#ifdef OCTAHEDRAL
        normals[own] = octahedral(textureLoad(normal_texture, texel, 0).xy);
#endif
#ifdef SKY_TRIANGLE
        is_sky[own] = select(0u, 1u, triangle == params.sky);
#endif
#ifdef SKY_SURFACE
        is_sky[own] = select(0u, 1u, surface == params.sky);
#endif
#ifdef SKY_DEPTH
#ifdef STANDARD
        is_sky[own] = select(0u, 1u, depth >= 1.0);
#else
#ifdef LINEAR
        // what is not finite fails every comparison of its bits
        let positive = bitcast<i32>(depth) > 0 && bitcast<i32>(depth) < 0x7f800000;
        is_sky[own] = select(1u, 0u, positive);
#else
        is_sky[own] = select(0u, 1u, depth <= 0.0);
#endif
#endif
#endif
    }
}

#ifdef NORMALS
fn pack_normal(normal: vec3<i32>) -> u32 {
    let bytes = vec3<u32>(normal + 128);
    return bytes.x | (bytes.y << 8u) | (bytes.z << 16u);
}

fn normal_of(at: u32) -> vec3<i32> {
    let packed = normals[at];
    return vec3<i32>(vec3<u32>(packed, packed >> 8u, packed >> 16u) & vec3<u32>(255u)) - 128;
}

fn is_normal_close(a: u32, b: u32) -> bool {
    let n = normal_of(a);
    let m = normal_of(b);
    let along = dot(n, m);
    let lengths = dot(n, n) * dot(m, m);
    return along > 0 && along * along >= lengths - (lengths >> params.normal_tolerance);
}
#endif

#ifdef OCTAHEDRAL
// An octahedral normal on a grid where the components' absolute values sum up to 127.
fn octahedral(encoded: vec2<f32>) -> u32 {
    let xy = clamp(vec2<i32>(floor(encoded * 254.0 + 0.5)) - 127, vec2<i32>(-127), vec2<i32>(127));
    let z = 127 - abs(xy.x) - abs(xy.y);
    if z < 0 {
        let signs = select(vec2<i32>(1), vec2<i32>(-1), xy < vec2<i32>(0));
        return pack_normal(vec3<i32>((127 - abs(xy.yx)) * signs, z));
    }
    return pack_normal(vec3<i32>(xy, z));
}
#endif

#ifdef REBUILT
// The neighbours of a pixel, in the order in which three pixels of one plane are sought.
fn around(i: u32) -> vec2<i32> {
    switch i {
        case 0u { return vec2<i32>(1, 0); }
        case 1u { return vec2<i32>(0, 1); }
        case 2u { return vec2<i32>(-1, 0); }
        case 3u { return vec2<i32>(0, -1); }
        case 4u { return vec2<i32>(1, 1); }
        case 5u { return vec2<i32>(-1, 1); }
        case 6u { return vec2<i32>(-1, -1); }
        default { return vec2<i32>(1, -1); }
    }
}

// The normal of the plane through three pixels of one triangle; none if there are no three.
fn rebuild(origin: vec2<u32>, at: vec2<u32>) -> u32 {
    let none = pack_normal(vec3<i32>(0));
    let place = vec2<i32>(at);
    let here = inverse[in_halo(place)];
    let id = triangles[in_halo(place)];
    if here < 0.0 {
        return none;
    }
    var usable = 0u;
    for (var i = 0u; i < 8u; i++) {
        let there = place + around(i);
        let pixel = vec2<i32>(origin) + there;
        let inside = all(pixel >= vec2<i32>(0)) && all(pixel < vec2<i32>(params.extent));
        if inside && triangles[in_halo(there)] == id && inverse[in_halo(there)] >= 0.0 {
            usable |= 1u << i;
        }
    }
    for (var i = 0u; i < 8u; i++) {
        for (var j = i + 1u; j < 8u; j++) {
            let a = around(i);
            let b = around(j);
            let area = a.x * b.y - a.y * b.x;
            if area == 0 || ((usable >> i) & (usable >> j) & 1u) == 0u {
                continue;
            }
            let along_a = inverse[in_halo(place + a)] - here;
            let along_b = inverse[in_halo(place + b)] - here;
            let slope = vec2<f32>(
                along_a * f32(b.y) - along_b * f32(a.y),
                along_b * f32(a.x) - along_a * f32(b.x),
            ) / f32(area);
            return plane_normal(vec2<f32>(origin + at), here, slope);
        }
    }
    return none;
}

// A plane n.P = d seen through P = z (u, v, 1) is 1/z = (n/d).(u, v, 1).
fn plane_normal(at: vec2<f32>, here: f32, slope: vec2<f32>) -> u32 {
    let seen = (at + 0.5 - vec2<f32>(params.extent) * 0.5) / params.plane;
    let xy = slope * params.plane;
    var z = here;
    z -= seen.x * xy.x;
    z -= seen.y * xy.y;
    let normal = vec3<f32>(xy, z);
    let sum = abs(normal.x) + abs(normal.y) + abs(normal.z);
    if !(sum > 0.0) {
        return pack_normal(vec3<i32>(0));
    }
    return pack_normal(vec3<i32>(floor(normal * 127.0 / sum + 0.5)));
}
#endif

#ifdef DEPTH
// The slope of inverse depth along an axis: the smaller difference to either side.
fn slope_at(at: vec2<i32>, axis: vec2<i32>) -> f32 {
    let here = inverse[in_halo(at)];
    let back = here - inverse[in_halo(at - axis)];
    let ahead = inverse[in_halo(at + axis)] - here;
    return select(ahead, back, abs(back) < abs(ahead));
}

// Whether a pixel lies in the plane through another.
fn is_in_plane(origin: vec2<i32>, goal: vec2<i32>) -> bool {
    let here = inverse[in_halo(origin)];
    let there = inverse[in_halo(goal)];
    if here < 0.0 || there < 0.0 {
        return false;
    }
    let delta = vec2<f32>(goal - origin);
    let expected = slope_at(origin, vec2<i32>(1, 0)) * delta.x + slope_at(origin, vec2<i32>(0, 1)) * delta.y;
    return abs((there - here) - expected) <= here * params.depth_tolerance;
}
#endif

// Whether a pixel may take another's result.
fn share(a: vec2<u32>, b: vec2<u32>) -> bool {
    let at_a = a.y * TILE.x + a.x;
    let at_b = b.y * TILE.x + b.x;
#ifdef SKY
    if (is_sky[at_a] | is_sky[at_b]) != 0u {
        return (is_sky[at_a] & is_sky[at_b]) != 0u;
    }
#endif
#ifdef SURFACES
    if surfaces[at_a] != surfaces[at_b] {
        return false;
    }
#endif
#ifdef TRIANGLES
    if triangles[in_halo(vec2<i32>(a))] == triangles[in_halo(vec2<i32>(b))] {
        return true;
    }
    // other triangles share only where they are one surface, or where normals and depth say that they lie in one plane
#ifndef ONE_PLANE
#ifndef SURFACES
    return false;
#endif
#endif
#endif
    var close = true;
#ifdef NORMALS
    close = is_normal_close(at_a, at_b);
#endif
#ifdef DEPTH
    close = close && is_in_plane(vec2<i32>(a), vec2<i32>(b)) && is_in_plane(vec2<i32>(b), vec2<i32>(a));
#endif
    return close;
}
#endif
