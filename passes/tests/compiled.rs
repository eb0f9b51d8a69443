//! SPIR-V as glslang makes it of engines' GLSL: with lines, with specialisation constants, for several versions of Vulkan.
//!
//! Without `glslangValidator` on the machine the tests pass over it; `tests/run.sh` installs it and sets `VRCS_REQUIRE_TOOLS`.

#![cfg(all(feature = "spirv", feature = "glsl"))]

use std::{path::PathBuf, process::Command};

use vrcs_passes::{
    Color, Entries, Options, emit,
    input::{Language, Reader, Shader},
    rewrite,
};

/// The SPIR-V of a GLSL compute shader; `None` without a compiler.
fn compile(name: &str, text: &str, flags: &[&str]) -> Option<Vec<u8>> {
    let there = Command::new("glslangValidator").arg("--version").output();
    if there.is_err() {
        assert!(
            std::env::var_os("VRCS_REQUIRE_TOOLS").is_none(),
            "glslangValidator is not installed: it comes with the package glslang-tools"
        );
        eprintln!("skipped: glslangValidator is not installed (package glslang-tools)");
        return None;
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!(
        "compiled-{name}{}",
        flags.join("").replace(['.', ' '], "_")
    ));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("pass.comp");
    std::fs::write(&path, text).expect("the shader is written");
    let output = Command::new("glslangValidator")
        .current_dir(&folder)
        .arg("-V")
        .args(flags)
        .args(["pass.comp", "-o", "pass.spv"])
        .output()
        .expect("glslangValidator runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    Some(std::fs::read(folder.join("pass.spv")).expect("SPIR-V"))
}

fn read(bytes: Vec<u8>) -> Shader {
    Reader::new()
        .read(Language::SpirV, [("pass.spv", bytes)])
        .unwrap_or_else(|invalid| panic!("{invalid}"))
}

fn rewritten(shader: &Shader) -> String {
    let Shader { module, info, .. } = shader;
    let rewritten = rewrite(module, info, Entries::PerPixel, &Options::default())
        .unwrap_or_else(|refusal| panic!("{}", refusal.render(&shader.source, Color::Never)));
    let text = emit::wgsl(&rewritten.module, &rewritten.info).expect("WGSL");
    // naga numbers values and what it makes of `OpPhi` as the module does, constants that nobody uses included
    let words: Vec<&str> = (text.split_inclusive(|c: char| !c.is_alphanumeric() && c != '_'))
        .map(
            |word| match word.strip_prefix("phi_").or(word.strip_prefix("_e")) {
                Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()),
                None => word,
            },
        )
        .collect();
    words.concat()
}

/// State per pixel in blocks without a name, a buffer that is only written, early returns, a condition that glslang lowers to a phi.
const STATE: &str = "#version 450
layout(local_size_x = 8, local_size_y = 4) in;
layout(std430, binding = 0) buffer Rng { uint state[]; };
layout(std430, binding = 1) writeonly buffer Packed { uvec2 texels[]; } packed;
layout(binding = 2, rgba8) uniform writeonly image2D picture;
layout(binding = 3) uniform Params { uint width; uint height; float gain; } params;
float next(inout uint s) { s = s * 747796405u + 2891336453u; return float(s >> 8) / 16777216.0; }
void main() {
    uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= params.width || p.y >= params.height) return;
    uint index = p.y * params.width + p.x;
    uint s = state[index];
    vec2 v = vec2(next(s), next(s)) * params.gain;
    state[index] = s;
    packed.texels[index] = uvec2(packHalf2x16(v), p.x);
    imageStore(picture, ivec2(p), vec4(v, 0.0, 1.0));
}
";

#[test]
fn lines_and_instructions_without_meaning_change_nothing() {
    let Some(plain) = compile("state", STATE, &[]) else {
        return;
    };
    let plain = rewritten(&read(plain));
    assert!(plain.contains("vrcs_copy_Rng"), "{plain}");
    // glslang calls it `next(u1;`
    assert!(plain.contains("fn next(s: ptr<function, u32>)"), "{plain}");
    for flags in [
        &["-g"][..],
        &["-gVS"],
        &["--target-env", "vulkan1.3"],
        &["-g", "--target-env", "vulkan1.2"],
    ] {
        let bytes = compile("state", STATE, flags).expect("just there");
        let shader = read(bytes);
        assert_eq!(shader.module.entry_points[0].workgroup_size, [8, 4, 1]);
        assert!(
            rewritten(&shader) == plain,
            "{flags:?}: {}",
            rewritten(&shader)
        );
    }
}

#[test]
fn messages_point_into_the_glsl_that_was_compiled() {
    let text = "#version 450
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform image2D heights;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    float left = imageLoad(heights, p - ivec2(1, 0)).x;
    imageStore(heights, p, vec4(left * 0.5));
}
";
    for flag in ["-g", "-gVS"] {
        let Some(bytes) = compile("neighbour", text, &[flag]) else {
            return;
        };
        let shader = read(bytes);
        let Shader { module, info, .. } = &shader;
        let refused = rewrite(module, info, Entries::PerPixel, &Options::default())
            .expect_err("it reads its neighbour");
        let told = refused.render(&shader.source, Color::Never);
        assert!(told.contains("pass.comp:6:5"), "{flag}: {told}");
        assert!(told.contains("float left = imageLoad"), "{flag}: {told}");
    }
}

#[test]
fn workgroup_sizes_may_be_specialisation_constants() {
    let text = "#version 450
layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 0) const uint WIDTH = 16;
layout(constant_id = 1) const uint HEIGHT = 4;
layout(binding = 0, rgba8) uniform writeonly image2D picture;
vec4 shade(uvec2 p) { return vec4(vec2(p % gl_WorkGroupSize.xy), gl_WorkGroupSize.x, 1.0) / 16.0; }
void main() {
    uvec2 p = gl_WorkGroupID.xy * gl_WorkGroupSize.xy + gl_LocalInvocationID.xy;
    imageStore(picture, ivec2(p), shade(p));
}
";
    for flags in [&[][..], &["-g"], &["--target-env", "vulkan1.3"]] {
        let Some(bytes) = compile("sizes", text, flags) else {
            return;
        };
        let shader = read(bytes);
        let entry = &shader.module.entry_points[0];
        let sizes = entry.workgroup_size_overrides.expect("overrides");
        assert!(sizes[0].is_some() && sizes[1].is_some() && sizes[2].is_none());
        assert_eq!(entry.workgroup_size[2], 1);
        let text = rewritten(&shader);
        // the pixel is `workgroup * size + local`, whatever the size
        assert!(
            text.contains("fn vrcs_copy_picture(at: vec2<i32>, value: vec4<f32>)"),
            "{text}"
        );
    }
}

#[test]
fn combined_image_samplers_are_named() {
    let text = "#version 450
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D hdr;
layout(binding = 1) uniform sampler2D blooms[2];
layout(binding = 2, rgba8) uniform writeonly image2D ldr;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    imageStore(ldr, p, texelFetch(hdr, p, 0) + texelFetch(blooms[1], p, 0));
}
";
    let glsl = Reader::new()
        .read(Language::Glsl, [("pass.comp", text.as_bytes().to_vec())])
        .expect_err("naga has none");
    assert!(glsl.rendered.contains("pass.comp:3:"), "{glsl}");
    let help = glsl.help.expect("a way out");
    assert!(help.contains("texture2D"), "{help}");
    let Some(bytes) = compile("combined", text, &[]) else {
        return;
    };
    let spirv = Reader::new()
        .read(Language::SpirV, [("pass.spv", bytes)])
        .expect_err("naga has none");
    assert!(spirv.message.contains("`hdr`, `blooms` are"), "{spirv}");
    assert!(spirv.help.expect("a way out").contains("texture2D"));
}

#[test]
fn modules_without_names_have_names_for_their_targets() {
    let Some(bytes) = compile("stripped", STATE, &[]) else {
        return;
    };
    // what `spirv-opt --strip-debug` leaves: no OpName (5), no OpMemberName (6)
    let words: Vec<u32> = (bytes.chunks_exact(4))
        .map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]))
        .collect();
    let mut stripped = words[..5].to_vec();
    let mut at = 5;
    while at < words.len() {
        let length = (words[at] >> 16) as usize;
        if !matches!(words[at] & 0xffff, 5 | 6) {
            stripped.extend_from_slice(&words[at..at + length]);
        }
        at += length;
    }
    let bytes: Vec<u8> = stripped.iter().flat_map(|w| w.to_le_bytes()).collect();
    let text = rewritten(&read(bytes.clone()));
    assert!(text.contains("vrcs_copy_binding_0_2("), "{text}");
    // cut anywhere, it may be an error, and no panic
    for end in (0..bytes.len()).step_by(13) {
        let cut = bytes[..end].to_vec();
        if let Err(invalid) = Reader::new().read(Language::SpirV, [("pass.spv", cut)]) {
            assert!(invalid.rendered.contains("pass.spv"), "{invalid}");
        }
    }
}
