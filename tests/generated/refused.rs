//! Shapes that copies cannot serve, planted at the end of a shader that is fine otherwise: refused, or stored for every pixel.

use vrcs_passes::Code;

use super::grammar::{Expect, Generator};

/// Plants one.
pub fn plant(g: &mut Generator) -> Expect {
    let (shape, code) = match g.below(8) {
        0 => {
            g.resource("var<storage, read_write> counter: array<u32, 4>;");
            g.line("if all(pixel == vec2<u32>(0u)) {");
            g.line("    counter[0] = 1u;");
            g.line("}");
            ("a lone invocation's store", Code::AddressNotOneToOne)
        }
        1 => {
            g.resource("var<storage, read_write> halves: array<vec4<f32>, 4096>;");
            g.line("if (pixel.x & 1u) == 0u && (pixel.y & 1u) == 0u {");
            g.line("    halves[(pixel.y / 2u) * 64u + pixel.x / 2u] = texel;");
            g.line("}");
            ("a quarter of the pixels store", Code::ConditionalOnIds)
        }
        2 => {
            g.resource("var<storage, read_write> heights: array<f32, 16384>;");
            g.line("let neighbour = heights[pixel.y * 96u + pixel.x + 1u];");
            g.line("heights[pixel.y * 96u + pixel.x] = neighbour * 0.5;");
            ("a neighbour's output is read", Code::ReadsOthersOutput)
        }
        3 => {
            g.resource("var<storage, read_write> slots: atomic<u32>;");
            g.resource("var<storage, read_write> taken: array<u32, 16384>;");
            g.line("taken[pixel.y * 96u + pixel.x] = atomicAdd(&slots, 1u);");
            ("an atomic's result is used", Code::Atomic)
        }
        4 => {
            g.globals.push(
                "struct Cursors {\n    at: array<u32, 16384>,\n    values: array<f32, 16384>,\n}"
                    .to_owned(),
            );
            g.resource("var<storage, read_write> cursors: Cursors;");
            g.line("let cursor = pixel.y * 96u + pixel.x;");
            g.line("let found = cursors.at[cursor];");
            g.line("cursors.values[found + cursor] = texel.x;");
            g.line("cursors.at[cursor] = found + 1u;");
            (
                "an address from written memory",
                Code::AddressNotRecomputable,
            )
        }
        5 => {
            g.resource("var<storage, read_write> quarters: array<vec4<f32>, 4096>;");
            let address = g.pick(&[
                "(pixel.y / 2u) * 64u + pixel.x / 2u",
                "((pixel.y >> 1u) << 6u) + (pixel.x >> 1u)",
                "u32(f32(pixel.y) * 0.5) * 64u + u32(floor(f32(pixel.x) / 4.0))",
                "(pixel.y & 62u) * 32u + (pixel.x & 63u)",
            ]);
            g.line(format!("quarters[{address}] = texel;"));
            ("several pixels have one place", Code::AddressNotOneToOne)
        }
        6 => {
            g.resource("var<storage, read_write> pairs: array<f32, 16384>;");
            g.line("let pair = pixel.y * 96u + pixel.x;");
            g.line("let half_of = pairs[pair] * 0.5;");
            g.line("pairs[pair] = half_of + texel.x;");
            g.line("pairs[pair + 1u] = half_of;");
            (
                "a neighbour stores to the own place, too",
                Code::ReadsOthersOutput,
            )
        }
        _ => {
            g.resource("var<storage, read_write> sums: array<f32, 16384>;");
            g.line("sums[pixel.y * 96u + pixel.x] = subgroupAdd(texel.x);");
            ("a subgroup operation", Code::SubgroupOperation)
        }
    };
    g.shape(shape);
    match shape {
        // whether two of them come to it may be for uniforms to say
        "several pixels have one place" => Expect::Either(code),
        // where nothing is said of the target, every pixel may store there for itself
        "a lone invocation's store"
        | "a quarter of the pixels store"
        | "an address from written memory" => Expect::Either(code),
        _ => Expect::Refused(code),
    }
}
