//! WGSL text means what the module means: what naga's writer leaves out is put back, and what cannot be said is an error.

use naga::Module;
use vrcs_passes::{Options, Source, emit, input, rewrite};

fn parse(text: &str) -> (Module, naga::valid::ModuleInfo) {
    input::wgsl(&Source::new("test", text)).unwrap_or_else(|invalid| panic!("{}", invalid.rendered))
}

fn written(text: &str) -> String {
    let (module, info) = parse(text);
    emit::wgsl(&module, &info).expect("text")
}

#[test]
fn sizes_and_alignments_are_put_back() {
    let text = written(
        "
        struct Inner { @size(32) a: f32, @align(64) b: f32, c: vec3<f32>, d: f32 }
        struct Outer { x: f32, inner: Inner, @size(24) y: vec2<f32>, z: f32 }
        @group(0) @binding(0) var<uniform> u: Outer;
        @compute @workgroup_size(1) fn main() { _ = u.z; }
        ",
    );
    assert!(text.contains("@size(64) a: f32"), "{text}");
    assert!(text.contains("@size(24) y: vec2<f32>"), "{text}");
}

#[test]
fn workgroup_sizes_of_overrides_are_put_back() {
    let text = written(
        "
        override WIDTH: u32 = 8u;
        @id(7) override HEIGHT: i32;
        @compute @workgroup_size(WIDTH * 2u, HEIGHT) fn main() {}
        ",
    );
    assert!(
        text.contains("@compute @workgroup_size((WIDTH * 2u), HEIGHT, 1)"),
        "{text}"
    );
    assert!(text.contains("@id(7) override HEIGHT: i32;"), "{text}");
}

#[test]
fn lengths_of_overrides_are_put_back() {
    let text = written(
        "
        override WIDTH: u32 = 8u;
        alias Tile = array<vec4<f32>, WIDTH * 2u>;
        struct Pair { a: f32, b: vec2<f32> }
        var<workgroup> first: Tile;
        var<workgroup> second: Tile;
        var<workgroup> pairs: array<Pair, WIDTH>;
        override SCALE: f32 = 0.5;
        @compute @workgroup_size(WIDTH) fn main(@builtin(local_invocation_index) lane: u32) {
            first[lane] = vec4(SCALE);
            second[lane] = first[lane];
            pairs[lane].a = second[lane].x;
        }
        ",
    );
    for line in [
        "var<workgroup> first: array<vec4<f32>, (WIDTH * 2u)>;",
        "var<workgroup> second: array<vec4<f32>, (WIDTH * 2u)>;",
        "var<workgroup> pairs: array<Pair, WIDTH>;",
        "override SCALE: f32 = 0.5f;",
    ] {
        assert!(text.contains(line), "{text}");
    }
    assert_eq!(text.matches("override ").count(), 2, "{text}");
}

#[test]
fn initialisers_that_are_computed_from_overrides_are_put_back() {
    let text = written(
        "
        override A: f32 = 2.0;
        override B: f32 = A * 3.0 - 1.0;
        var<private> p: f32 = B + 0.5;
        @compute @workgroup_size(1) fn main() { _ = p; }
        ",
    );
    assert!(
        text.contains("override B: f32 = ((A * 3.0f) - 1.0f);"),
        "{text}"
    );
    assert!(text.contains("var<private> p: f32 = (B + 0.5f);"), "{text}");
}

#[test]
fn names_that_end_in_digits_stay_what_they_are() {
    let text = written(
        "
        override N1: u32 = 3u;
        struct S2 { m3: f32 }
        @group(0) @binding(0) var<storage, read_write> out4: array<S2>;
        fn f5(a6: f32) -> f32 { let b7 = a6 * 2.0; return b7 + b7; }
        @compute @workgroup_size(1) fn main8() { out4[N1].m3 = f5(1.0); }
        ",
    );
    for name in [
        "override N1:",
        "struct S2 ",
        " m3:",
        "var<storage, read_write> out4:",
        "fn f5(a6:",
        "let b7 =",
        "fn main8(",
    ] {
        assert!(text.contains(name), "no `{name}` in\n{text}");
    }
}

#[test]
fn an_entry_point_may_have_the_name_of_a_built_in_function() {
    let shader = |body: &str| {
        format!(
            "@group(0) @binding(0) var<storage, read_write> out: array<f32>; @compute @workgroup_size(1) fn step() {{ {body} }}"
        )
    };
    let text = written(&shader("out[0] = floor(1.5);"));
    assert!(text.contains("fn step()"), "{text}");
    // a module's own function hides the built-in one, so the text could not call it; neither can the author's
    let mut module = parse(&shader("out[0] = floor(out[1]);")).0;
    module.entry_points[0].name = "floor".to_owned();
    let info = naga::valid::Validator::new(Default::default(), Default::default())
        .validate(&module)
        .expect("a valid module");
    let error = emit::wgsl(&module, &info).expect_err("no such text");
    assert!(
        matches!(&error, emit::EmitError::Name(name) if name == "floor"),
        "{error}"
    );
}

#[test]
fn resources_keep_names_that_functions_use() {
    let text = "
        struct Frame { size: vec2<u32> }
        @group(0) @binding(0) var<uniform> frame: Frame;
        @group(0) @binding(1) var<storage, read_write> pixel: array<u32>;
        @group(0) @binding(2) var<storage, read> mask: array<u32>;
        @group(0) @binding(3) var value: texture_2d<f32>;
        @id(3) override number: u32 = 2u;

        fn doubled(at: vec2<u32>) -> u32 {
            var value = at.x;
            value += at.y;
            return value * number;
        }

        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            if any(id.xy >= frame.size) { return; }
            let seen = textureLoad(value, id.xy, 0).x;
            pixel[id.y * frame.size.x + id.x] = mask[id.x] + doubled(id.xy) + u32(seen);
        }";
    let (module, info) = parse(text);
    let rewritten = rewrite(&module, &info, "main", &Options::default()).expect("a rewrite");
    let text = emit::wgsl(&rewritten.module, &rewritten.info).expect("text");
    for name in [
        "var<storage, read_write> pixel: ",
        "var<storage> mask: ",
        "var value: ",
        "override number: ",
        "var<private> vrcs_pixel: ",
    ] {
        assert!(text.contains(name), "{name}\n{text}");
    }
    parse(&text);
}

#[test]
fn a_name_is_not_restored_if_another_thing_is_called_so() {
    // naga writes `a1` as `a1_`; were `a1_` of the author's own, the two must stay apart
    let text = written(
        "
        @group(0) @binding(0) var<storage, read_write> a1: array<f32>;
        @group(0) @binding(1) var<storage, read_write> a1_: array<f32>;
        @compute @workgroup_size(1) fn main() { a1[0] = a1_[1]; }
        ",
    );
    assert!(!text.contains("a1[0] = a1[1]"), "{text}");
}

#[test]
fn subgroups_are_enabled() {
    let (module, info) = parse(
        "
        @group(0) @binding(0) var<storage, read_write> out: array<u32>;
        @compute @workgroup_size(32) fn main(@builtin(subgroup_invocation_id) lane: u32) {
            out[lane] = subgroupAdd(lane);
        }
        ",
    );
    let text = emit::wgsl(&module, &info).expect("text");
    assert!(text.starts_with("enable subgroups;\n"), "{text}");
    assert_eq!(emit::audit::audit(&module, &text), Ok(()));
    let without = text.replace("enable subgroups;", "");
    assert!(emit::audit::audit(&module, &without).is_err());
}

#[test]
fn ray_queries_have_no_text() {
    let (module, info) = parse(
        "
        enable wgpu_ray_query;
        @group(0) @binding(0) var scene: acceleration_structure;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        @compute @workgroup_size(1) fn main() {
            var query: ray_query;
            rayQueryInitialize(&query, scene, RayDesc(0u, 0xffu, 0.1, 9.0, vec3(0.0), vec3(0.0, 0.0, 1.0)));
            rayQueryProceed(&query);
            out[0] = rayQueryGetCommittedIntersection(&query).t;
        }
        ",
    );
    let error = emit::wgsl(&module, &info).expect_err("no text");
    assert!(error.to_string().contains("ray queries"), "{error}");
}

#[cfg(feature = "spirv")]
#[test]
fn a_binding_array_without_a_length_is_no_spirv() {
    let (module, info) = parse(
        "
        enable wgpu_binding_array;
        @group(0) @binding(0) var pictures: binding_array<texture_2d<f32>>;
        @group(0) @binding(1) var<storage, read_write> out: array<vec4<f32>>;
        @compute @workgroup_size(1) fn main() { out[0] = textureLoad(pictures[1], vec2(0u), 0); }
        ",
    );
    let error = emit::spirv(&module, &info, &emit::Form::default()).expect_err("no SPIR-V");
    let told = error.to_string();
    assert!(
        told.contains("`pictures`") && told.contains("give it one"),
        "{told}"
    );
    let (module, info) = parse(
        "
        enable wgpu_binding_array;
        struct Vertices { all: array<vec4<f32>> }
        @group(0) @binding(0) var<storage> buffers: binding_array<Vertices, 4>;
        @group(0) @binding(1) var<storage, read_write> out: array<vec4<f32>>;
        @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            out[0] = buffers[1].all[id.x];
        }
        ",
    );
    assert!(emit::spirv(&module, &info, &emit::Form::default()).is_ok());
}

#[test]
fn the_audit_finds_what_differs() {
    let (module, _) = parse(
        "
        struct S { a: f32, b: vec2<f32> }
        @group(0) @binding(0) var<uniform> s: S;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        override N: u32 = 1u;
        @compute @workgroup_size(8, 2) fn main() { out[N] = s.b.x; }
        ",
    );
    let text = "
        struct S { a: f32, b: vec2<f32> }
        @group(0) @binding(0) var<uniform> s: S;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        override N: u32 = 1u;
        @compute @workgroup_size(8, 2) fn main() { out[N] = s.b.x; }
        ";
    assert_eq!(emit::audit::audit(&module, text), Ok(()));
    for (from, to) in [
        ("a: f32, b", "@size(16) a: f32, b"),
        ("@binding(1)", "@binding(2)"),
        ("read_write> out", "read> out"),
        ("(8, 2)", "(8, 1)"),
        ("override N", "override M"),
        ("fn main", "fn other"),
        ("vec2<f32> }", "vec2<i32> }"),
        ("N: u32 = 1u", "N: u32"),
        ("= 1u;", "= 1u"),
    ] {
        let changed = text.replacen(from, to, 1).replace("out[M]", "out[0]");
        assert!(
            emit::audit::audit(&module, &changed).is_err(),
            "{from} became {to}"
        );
    }
}

#[test]
fn sums_of_many_terms_are_written_so_that_they_can_be_read() {
    let terms: String = (0..600).map(|i| format!(" + f32(id.x * {i}u)")).collect();
    let text = written(&format!(
        "@group(0) @binding(0) var<storage, read_write> out: array<f32>;
         @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
             out[id.x] = 1.0{terms};
         }}"
    ));
    // Tint stops at 512
    let deepest = text
        .bytes()
        .scan(0i32, |open, byte| {
            *open += i32::from(byte == b'(') - i32::from(byte == b')');
            Some(*open)
        })
        .max();
    assert!(deepest < Some(120), "{deepest:?}");
}

#[test]
fn what_an_entry_point_gives_back_is_compared() {
    let text = "@fragment fn main() -> @location(0) vec4<f32> { return vec4(1.0); }";
    let (module, _) = parse(text);
    assert_eq!(emit::audit::audit(&module, text), Ok(()));
    let changed = text.replace("@location(0)", "@location(1)");
    assert!(emit::audit::audit(&module, &changed).is_err());
}

/// Which pixels a shader stores for may be a question of all iterations of its loops: the domain asks each of them, and a group
/// whose primary lies outside moves to a member inside.
#[test]
fn guards_in_loops_are_part_of_the_domain() {
    let text = |last: &str| {
        let shader = format!(
            "
            @group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
            override STEPS: u32 = 2u;
            @compute @workgroup_size(8, 8)
            fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
                let size = textureDimensions(picture);
                for (var y = 0u; y < {last}; y++) {{
                    for (var x = 0u; x < 2u; x++) {{
                        let at = id.xy * 2u + vec2(x, y);
                        if all(at < size) {{
                            textureStore(picture, at, vec4(1.0));
                        }}
                    }}
                }}
            }}
            "
        );
        let source = Source::new("loops.wgsl", shader);
        let (module, info) = input::wgsl(&source).expect("a valid shader");
        let rewritten = rewrite(&module, &info, "main", &Options::default()).expect("a rewrite");
        emit::wgsl(&rewritten.module, &rewritten.info).expect("text")
    };
    let known = text("3u");
    assert!(known.contains("fn vrcs_in_domain"), "{known}");
    // an end that is no number: no invocation is kept from storing
    let unknown = text("STEPS");
    assert!(!unknown.contains("fn vrcs_in_domain"), "{unknown}");
}
