//! How a shader learns which pixel is its own: every id builtin, in every form that people write.

use vrcs_passes::options::Linear;

use super::{grammar::Generator, values::Ty};

/// The entry point's first lines.
pub struct EntryHead {
    /// Structs, overrides and private variables.
    pub declarations: String,
    /// `@compute @workgroup_size(…)`.
    pub attributes: String,
    /// `fn main(…)`.
    pub signature: String,
    /// Lines that end in a variable `pixel: vec2<u32>` and a variable `layer: u32`.
    pub pixel: Vec<String>,
    /// Pixels of a workgroup.
    pub group: [u32; 2],
    /// Whether the pixel is the global id, recognisably.
    pub affine: bool,
    /// Whether many more invocations may run than the picture has pixels, so that the shader cannot do without a guard.
    pub needs_guard: bool,
    /// The width, where the pixels are numbered row by row in one dimension.
    pub linear: Option<Linear>,
    /// Whether a workgroup works together, with barriers.
    pub is_cooperative: bool,
    /// What the lines besides the pixel's name.
    pub names: Vec<(&'static str, Ty)>,
    pub shapes: Vec<&'static str>,
}

const GROUPS: [[u32; 2]; 8] = [
    [8, 8],
    [16, 16],
    [8, 4],
    [16, 4],
    [4, 16],
    [5, 7],
    [32, 1],
    [1, 1],
];

/// Chooses a form.
pub fn choose(generator: &mut Generator) -> EntryHead {
    let group = generator.pick(&GROUPS);
    let [w, h] = group;
    let is_override = generator.one_in(6);
    let (side, half, overrides) = match is_override {
        true => (
            "SIDE_X".to_owned(),
            "SIDE_Y".to_owned(),
            format!("override SIDE_X: u32 = {w}u;\noverride SIDE_Y: u32 = {h}u;\n"),
        ),
        false => (format!("{w}u"), format!("{h}u"), String::new()),
    };
    let mut head = EntryHead {
        declarations: overrides,
        attributes: format!("@compute @workgroup_size({side}, {half})"),
        signature: String::new(),
        pixel: Vec::new(),
        group,
        affine: true,
        needs_guard: false,
        linear: None,
        is_cooperative: false,
        names: Vec::new(),
        shapes: Vec::new(),
    };
    if is_override {
        head.shapes.push("override workgroup size");
    }
    if group == [1, 1] {
        head.shapes.push("workgroups of one");
    }
    let layer = |of: &str| format!("let layer = {of}.z;");
    let gid = "@builtin(global_invocation_id) id: vec3<u32>";
    let wid = "@builtin(workgroup_id) group: vec3<u32>";
    let lid = "@builtin(local_invocation_id) local: vec3<u32>";
    match generator.below(13) {
        10 if !generator.geometry.layered => one_dimension(generator, &mut head),
        11 => together(generator, &mut head),
        0 => {
            head.shapes.push("ids in a struct");
            head.declarations.push_str(
                "struct Ids {\n    @builtin(global_invocation_id) id: vec3<u32>,\n    \
                 @builtin(local_invocation_index) index: u32,\n}\n",
            );
            head.signature = "fn main(in: Ids)".to_owned();
            head.pixel = vec!["let pixel = in.id.xy;".to_owned(), layer("in.id")];
        }
        1 => {
            head.shapes.push("workgroup id and local id");
            head.signature = format!("fn main({wid}, {lid})");
            head.pixel = vec![
                format!("let pixel = group.xy * vec2<u32>({side}, {half}) + local.xy;"),
                layer("group"),
            ];
        }
        2 => {
            head.shapes.push("local index decoded");
            head.affine = false;
            head.signature = format!("fn main({wid}, @builtin(local_invocation_index) index: u32)");
            head.pixel = vec![
                format!(
                    "let pixel = vec2<u32>(group.x * {side} + index % {side}, group.y * {half} + index / {side});"
                ),
                layer("group"),
            ];
        }
        3 => {
            head.shapes.push("tile order from the local index");
            head.affine = false;
            head.needs_guard = true;
            head.group = [8, 8];
            head.declarations.clear();
            head.shapes.retain(|shape| !shape.contains("workgroup"));
            head.attributes = "@compute @workgroup_size(64)".to_owned();
            head.signature = format!("fn main({wid}, @builtin(local_invocation_index) index: u32)");
            head.pixel = vec![
                "let tile_x = (index & 1u) | ((index >> 1u) & 2u) | ((index >> 2u) & 4u);"
                    .to_owned(),
                "let tile_y = ((index >> 1u) & 1u) | ((index >> 2u) & 2u) | ((index >> 3u) & 4u);"
                    .to_owned(),
                "let pixel = vec2<u32>(group.x * 8u + tile_x, group.y * 8u + tile_y);".to_owned(),
                layer("group"),
            ];
        }
        4 => {
            head.shapes.push("pixel in a private variable");
            head.declarations
                .push_str("var<private> place: vec2<u32>;\n");
            head.signature = format!("fn main({gid})");
            head.pixel = vec![
                "place = id.xy;".to_owned(),
                "let pixel = place;".to_owned(),
                layer("id"),
            ];
        }
        5 => {
            head.shapes.push("pixel in a variable");
            head.signature = format!("fn main({gid})");
            head.pixel = vec![
                "var pixel: vec2<u32>;".to_owned(),
                "pixel.x = id.x;".to_owned(),
                "pixel.y = id.y;".to_owned(),
                layer("id"),
            ];
        }
        6 => {
            head.shapes.push("pixel by a helper");
            head.signature = format!("fn main({gid})");
            generator.function("fn pixel_of(id: vec3<u32>) -> vec2<u32>", |g| {
                g.line("return vec2<u32>(id.x, id.y);");
            });
            head.pixel = vec!["let pixel = pixel_of(id);".to_owned(), layer("id")];
        }
        _ => {
            head.shapes.push("global id");
            head.signature = format!("fn main({gid})");
            head.pixel = vec!["let pixel = id.xy;".to_owned(), layer("id")];
        }
    }
    head
}

/// A dispatch of one dimension over the pixels' numbers.
fn one_dimension(generator: &mut Generator, head: &mut EntryHead) {
    head.affine = false;
    head.needs_guard = true;
    head.declarations.clear();
    head.shapes = vec!["one dimension"];
    let width = generator.geometry.size[0];
    head.linear = Some(match generator.one_in(2) {
        true => Linear::Pixels(width),
        false => Linear::Named("frame.width".to_owned()),
    });
    let lanes = generator.pick(&[64, 32, 100, 256]);
    head.group = [lanes, 1];
    head.attributes = format!("@compute @workgroup_size({lanes})");
    let (argument, number) = match generator.below(3) {
        0 => (
            "@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32",
            format!("group.x * {lanes}u + index"),
        ),
        _ => (
            "@builtin(global_invocation_id) id: vec3<u32>",
            "id.x".to_owned(),
        ),
    };
    head.signature = format!("fn main({argument})");
    head.pixel = vec![
        format!("let number = {number};"),
        "let pixel = vec2<u32>(number % frame.width, number / frame.width);".to_owned(),
        "let layer = 0u;".to_owned(),
    ];
}

/// A workgroup that reads its texels once, into memory that it shares, and looks at its neighbours' there.
fn together(generator: &mut Generator, head: &mut EntryHead) {
    let group = generator.pick(&[[8, 8], [16, 16], [8, 4], [16, 8]]);
    let [w, h] = group;
    let lanes = w * h;
    head.group = group;
    head.is_cooperative = true;
    head.shapes = vec!["barriers"];
    head.declarations = format!("var<workgroup> shared_texels: array<vec4<f32>, {lanes}>;\n");
    head.attributes = format!("@compute @workgroup_size({w}, {h})");
    head.signature = "fn main(@builtin(global_invocation_id) id: vec3<u32>, \
                      @builtin(local_invocation_index) index: u32)"
        .to_owned();
    let step = generator.pick(&[1, w, w + 1]);
    head.pixel = vec![
        "let pixel = id.xy;".to_owned(),
        "let layer = id.z;".to_owned(),
        "shared_texels[index] = textureLoad(input, min(pixel, frame.size - 1u), 0);".to_owned(),
        "workgroupBarrier();".to_owned(),
        format!("let near = shared_texels[(index + {step}u) % {lanes}u];"),
    ];
    head.names = vec![("near", Ty::V4)];
    match generator.below(3) {
        0 => {
            head.shapes.push("barriers, twice");
            head.pixel.extend([
                "workgroupBarrier();".to_owned(),
                "shared_texels[index] = near * 0.5 + frame.tint;".to_owned(),
                "workgroupBarrier();".to_owned(),
                format!("let far = shared_texels[(index + 5u) % {lanes}u];"),
            ]);
            head.names.push(("far", Ty::V4));
        }
        1 => {
            head.shapes.push("barriers in a loop");
            head.pixel.extend([
                "var far = near;".to_owned(),
                "for (var batch = 0u; batch < frame.step_count; batch++) {".to_owned(),
                "    workgroupBarrier();".to_owned(),
                "    shared_texels[index] = textureLoad(input, (pixel + batch) % frame.size, 0);"
                    .to_owned(),
                "    workgroupBarrier();".to_owned(),
                "    for (var other = 0u; other < 4u; other++) {".to_owned(),
                format!("        far += shared_texels[(index + other) % {lanes}u] * near.x;"),
                "    }".to_owned(),
                "}".to_owned(),
            ]);
            head.names.push(("far", Ty::V4));
        }
        _ => {}
    }
}
