//! What counts as a screen-space entry point, and what a driver has to have to run it: rules that a program applies, no hand-made list.
//!
//! The rule is that of a survey of 874 compute entry points of 75 public repositories, from which the goal of 93 % comes. An entry point
//! counts if it
//!
//! - stores to a 2-D storage texture, arrayed or not, wherever that may be; or
//! - has a store to a storage buffer, other than an atomic, whose address depends on both axes of the invocation grid
//!   ([`axes`](super::axes) says what depends on what).
//!
//! What the rewriter makes of it is not asked: the rule is the same for what is rewritten, refused and left as it is.
//!
//! What stores to 3-D textures alone does not, nor what counts, sorts or scatters by atomics alone. Structure cannot tell a picture from
//! a grid of a fluid, or from agents that live in a texture: they count.

use std::collections::HashSet;

use naga::{
    ArraySize, Expression, Function, Handle, ImageClass, ImageDimension, Module, Statement, Type,
    TypeInner, valid::ModuleInfo,
};
use vrcs_passes::ir::visit;

use super::axes;

/// Whether an entry point counts.
pub fn counts(module: &Module, info: &ModuleInfo, entry: usize) -> bool {
    let function = &module.entry_points[entry].function;
    let both = |axes: &axes::Axes| *axes == axes::X | axes::Y;
    stores_to_picture(module, function, &mut HashSet::new())
        || axes::of_buffer_stores(module, info, entry).iter().any(both)
}

/// Whether a function, or one that it calls, stores to a 2-D storage texture.
fn stores_to_picture(
    module: &Module,
    function: &Function,
    seen: &mut HashSet<Handle<Function>>,
) -> bool {
    let mut found = false;
    visit::statements(&function.body, &mut |statement| match *statement {
        Statement::Call {
            function: callee, ..
        } if seen.insert(callee) => {
            found |= stores_to_picture(module, &module.functions[callee], seen);
        }
        Statement::ImageStore { image, .. } => {
            let ty = root_type(module, function, image);
            found |= ty.is_some_and(|ty| is_picture(module, ty));
        }
        _ => {}
    });
    found
}

fn root_type(
    module: &Module,
    function: &Function,
    mut expression: Handle<Expression>,
) -> Option<Handle<Type>> {
    loop {
        match function.expressions[expression] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                expression = base;
            }
            Expression::GlobalVariable(global) => return Some(module.global_variables[global].ty),
            Expression::FunctionArgument(index) => {
                return Some(function.arguments[index as usize].ty);
            }
            _ => return None,
        }
    }
}

/// What is in a binding, or in each element of an array of bindings.
fn inner(module: &Module, ty: Handle<Type>) -> &TypeInner {
    match &module.types[ty].inner {
        TypeInner::BindingArray { base, .. } => &module.types[*base].inner,
        inner => inner,
    }
}

fn is_picture(module: &Module, ty: Handle<Type>) -> bool {
    matches!(
        inner(module, ty),
        TypeInner::Image {
            dim: ImageDimension::D2,
            class: ImageClass::Storage { .. },
            ..
        }
    )
}

/// A feature that an entry point needs and that neither lavapipe nor SwiftShader has.
pub fn lacking(module: &Module, info: &ModuleInfo, entry: usize) -> Option<&'static str> {
    let uses = info.get_entry_point(entry);
    let used = module
        .global_variables
        .iter()
        .filter(|&(handle, _)| !uses[handle].is_empty());
    let of = |global: &naga::GlobalVariable| {
        let ty = &module.types[global.ty].inner;
        match (inner(module, global.ty), ty) {
            (TypeInner::AccelerationStructure { .. }, _) => Some("EXPERIMENTAL_RAY_QUERY"),
            (
                TypeInner::Image {
                    class:
                        ImageClass::Storage {
                            format: naga::StorageFormat::R64Uint,
                            ..
                        },
                    ..
                },
                _,
            ) => Some("TEXTURE_INT64_ATOMIC"),
            (
                _,
                TypeInner::BindingArray {
                    size: ArraySize::Dynamic,
                    ..
                },
            ) => Some("PARTIALLY_BOUND_BINDING_ARRAY"),
            _ => None,
        }
    };
    // the gravest first
    let mut features: Vec<_> = used.filter_map(|(_, global)| of(global)).collect();
    features.sort_unstable();
    features.first().copied()
}

/// The rules, one case for each clause: of `grid`, a workgroup of 8 x 8, and of `line`, one of 64.
#[test]
fn the_rules_tell_them_apart() {
    let shader = |size: &str, body: &str| {
        format!(
            "struct Ids {{ @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32> }}
            struct Pixel {{ at: vec2<u32>, number: u32, count: u32 }}
            @group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
            @group(0) @binding(1) var volume: texture_storage_3d<rgba8unorm, write>;
            @group(0) @binding(2) var<storage, read_write> cells: array<u32>;
            @group(0) @binding(3) var<storage, read_write> bins: array<atomic<u32>>;
            @group(0) @binding(4) var<storage> data: array<u32>;
            @group(0) @binding(5) var<storage, read_write> pixels: array<Pixel>;
            @group(0) @binding(6) var<uniform> width: u32;
            var<private> place: u32;
            var<private> other: u32;
            var<workgroup> shared_place: array<u32, 64>;
            fn row_by_row(at: vec2<u32>) -> u32 {{ return at.y * width + at.x; }}
            fn first(a: u32, b: u32) -> u32 {{ return a + 0u * width; }}
            fn chosen(at: vec2<u32>) -> u32 {{ if at.y > 3u {{ return at.x; }} return at.x + 64u; }}
            fn set_place(row: u32) {{ place = row * width; }}
            fn add_to(p: ptr<function, u32>, value: u32) {{ *p += value; }}
            fn put(index: u32) {{ cells[index] = 1u; }}
            fn put_all() {{ for (var i = 0u; i < width; i++) {{ cells[i] = 1u; }} }}
            @compute @workgroup_size({size}) fn main(
                @builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>,
                @builtin(local_invocation_index) lane: u32, ids: Ids,
            ) {{ {body} }}"
        )
    };
    let (grid, line) = ("8, 8", "64");
    for (expected, size, body) in [
        (true, grid, "textureStore(picture, id.xy, vec4(0.0));"),
        // a line of texels for each invocation is still a picture
        (true, grid, "textureStore(picture, id.xx, vec4(0.0));"),
        // its size alone is asked for
        (false, grid, "cells[id.x] = textureDimensions(picture).x;"),
        (false, grid, "textureStore(volume, id, vec4(0.0));"),
        // both axes in one address; in two stores, one each, there is none
        (true, grid, "cells[id.y * width + id.x] = 1u;"),
        (true, grid, "cells[id.y * width + id.x] = cells[0];"),
        (true, line, "cells[id.y * width + id.x] = 1u;"),
        (false, grid, "cells[id.x] = 1u; cells[id.y] = 1u;"),
        (false, grid, "cells[id.x] = 1u;"),
        (false, grid, "cells[id.x + id.z * width] = 1u;"),
        // what is stored, and under what condition, is no address
        (false, grid, "cells[id.x] = id.y;"),
        (false, grid, "if id.y == 0u { cells[id.x] = 1u; }"),
        (
            false,
            grid,
            "if id.y >= width { return; } cells[id.x] = 1u;",
        ),
        // each builtin, in a grid and in a line
        (true, grid, "cells[local.y * 8u + local.x] = 1u;"),
        (false, line, "cells[local.y * 8u + local.x] = 1u;"),
        (true, grid, "cells[lane] = 1u;"),
        (false, line, "cells[lane] = 1u;"),
        (false, line, "cells[ids.group.x * 64u + lane] = 1u;"),
        (true, line, "cells[ids.group.y * 64u + lane] = 1u;"),
        (
            true,
            grid,
            "cells[ids.group.x + ids.group.y * ids.groups.x] = 1u;",
        ),
        (false, grid, "cells[id.x + ids.groups.y] = 1u;"),
        // components of vectors and structs
        (
            false,
            grid,
            "let at = vec2(id.x, width); cells[at.y * 8u + at.x] = 1u;",
        ),
        (true, grid, "let at = id.yx; cells[at.x * 8u + at.y] = 1u;"),
        (
            false,
            grid,
            "let at = id.xyx; cells[at.x * 8u + at.z] = 1u;",
        ),
        (true, grid, "cells[dot(id.xy, vec2(1u, width))] = 1u;"),
        (
            false,
            grid,
            "let p = Pixel(id.xy, id.x, width); cells[p.number + p.count] = 1u;",
        ),
        (
            true,
            grid,
            "let p = Pixel(id.xy, id.x, width); cells[p.at.y + p.count * p.number] = 1u;",
        ),
        (true, grid, "pixels[id.y * width + id.x].count = 1u;"),
        (
            true,
            grid,
            "let p = &pixels[id.y * width + id.x]; (*p).at.y = 1u;",
        ),
        // variables, loops, conditions
        (
            true,
            grid,
            "var i = id.y; i = i * width; i += id.x; cells[i] = 1u;",
        ),
        (false, grid, "var i = id.x; i = i * width; cells[i] = id.y;"),
        (
            true,
            grid,
            "var i = id.x; if id.y > 3u { i = 0u; } cells[i] = 1u;",
        ),
        (
            true,
            grid,
            "var i = id.x; if width > 3u && id.y > 3u { i = 0u; } cells[i] = 1u;",
        ),
        (true, grid, "cells[select(id.x, 0u, id.y > 3u)] = 1u;"),
        (
            true,
            grid,
            "var i = id.x; switch id.y { case 0u: { i = 1u; } default: {} } cells[i] = 1u;",
        ),
        (
            true,
            grid,
            "var i = id.x; for (var k = 0u; k < id.y; k++) { i += 2u; } cells[i] = 1u;",
        ),
        (
            true,
            grid,
            "var i = id.x; loop { if i > id.y { break; } i += 2u; } cells[i] = 1u;",
        ),
        (
            true,
            grid,
            "var i = id.x; loop { i += 2u; continuing { break if i > id.y; } } cells[i] = 1u;",
        ),
        (
            false,
            grid,
            "for (var k = id.x; k < width; k += 8u) { cells[k] = 1u; }",
        ),
        (
            true,
            grid,
            "var a = id.x; var b = id.y; for (var k = 0u; k < 4u; k++) { a = b; b = a * 2u + id.x; } cells[a] = 1u;",
        ),
        (
            true,
            grid,
            "for (var k = 0u; k < 4u; k++) { cells[place] = 1u; place = other; other = id.x + id.y; }",
        ),
        // private variables, helpers
        (true, grid, "set_place(id.y); cells[place + id.x] = 1u;"),
        (false, grid, "set_place(id.x); cells[place + id.x] = id.y;"),
        (true, grid, "cells[row_by_row(id.xy)] = 1u;"),
        (false, grid, "cells[row_by_row(id.xx)] = row_by_row(id.xy);"),
        (false, grid, "cells[first(id.x, id.y)] = 1u;"),
        (true, grid, "cells[chosen(id.xy)] = 1u;"),
        (true, grid, "var i = id.x; add_to(&i, id.y); cells[i] = 1u;"),
        (true, grid, "put(id.y * width + id.x);"),
        (false, grid, "put(id.x); put(id.y);"),
        (
            true,
            grid,
            "if id.y > 3u { set_place(id.x); } cells[place] = 1u;",
        ),
        (false, grid, "if all(id.xy == vec2(0u)) { put_all(); }"),
        // what is read from memory is data, which lists, sorts and queues find their place by
        (false, grid, "cells[data[id.y * width + id.x]] = 1u;"),
        (
            false,
            grid,
            "cells[textureLoad(picture_in, id.xy, 0).x] = 1u;",
        ),
        (true, grid, "cells[data[0] + id.y * width + id.x] = 1u;"),
        (
            false,
            grid,
            "shared_place[id.x] = id.y; workgroupBarrier(); cells[shared_place[id.x]] = 1u;",
        ),
        (
            false,
            grid,
            "if id.y > id.x { cells[atomicAdd(&bins[0], 1u)] = id.x; }",
        ),
        (
            false,
            grid,
            "cells[atomicSub(&bins[data[id.y * width + id.x]], 1u)] = id.x;",
        ),
        // atomics are no stores, wherever they go, but for those that do nothing but store
        (
            false,
            grid,
            "atomicAdd(&bins[data[id.y * 64u + id.x]], 1u);",
        ),
        (true, grid, "atomicStore(&bins[id.y * 64u + id.x], 1u);"),
        (false, line, "cells[atomicAdd(&bins[0], 1u)] = id.x;"),
    ] {
        let text = shader(size, body).replace(
            "var<private> place",
            "@group(0) @binding(7) var picture_in: texture_2d<u32>; var<private> place",
        );
        let source = vrcs_passes::Source::new("rule.wgsl", text);
        let (module, info) = vrcs_passes::input::wgsl(&source)
            .unwrap_or_else(|invalid| panic!("{}", invalid.rendered));
        assert_eq!(counts(&module, &info, 0), expected, "{size}: {body}");
        assert_eq!(lacking(&module, &info, 0), None);
    }
}
