//! VRCSPrefix: the new entry point, and what it imports from the [prelude](crate::prelude).
//!
//! ```wgsl
//! // before                                   // after
//! @compute @workgroup_size(8, 8)              @compute @workgroup_size(16, 16)
//! fn main(                                    fn main(
//!     @builtin(global_invocation_id)              @builtin(workgroup_id) vrcs_group: vec3<u32>,
//!     gid: vec3<u32>                              @builtin(local_invocation_index) vrcs_lane: u32
//! ) {                                         ) {
//!     ..                                          if !vrcs_prefix(vrcs_group, vrcs_lane) { return; }
//! }                                               main_inner(vrcs_pixel);
//!                                             }
//! ```
//!
//! *Does*: gives the entry point's name to a function that finds the invocation's pixel, leaves if there is none, and calls
//! the original with the ids that the pixel's own invocation would have had: all of them, as one consistent set.
//! *Guarantees*: nothing of the author's is renumbered; a `return` of theirs returns here.

use std::sync::Arc;

use naga::{
    BinaryOperator, Binding, BuiltIn, Expression, Function, FunctionArgument, GlobalVariable,
    Handle, Module, Scalar, Span, TypeInner, UnaryOperator,
};

use super::{
    bindings::Placement,
    recompute::{Ids, Recompute},
};
use crate::{
    analysis::{
        corner::{self, Corner},
        guard::{self, Formula},
        term::{TermId, Terms},
    },
    graded,
    ir::{
        build::{self, Code},
        import::Imports,
    },
    options::Options,
    prelude::prelude,
};

/// What a rewritten entry point uses of the prelude.
#[derive(Clone, Copy, Debug)]
pub struct Prologue {
    /// The parameters.
    pub params: Handle<GlobalVariable>,
    /// The pixel at hand.
    pub pixel: Handle<GlobalVariable>,
    /// Its duplicates.
    pub copies: Handle<GlobalVariable>,
    /// `fn(tile, lane) -> bool`: finds the pixel.
    pub prefix: Handle<Function>,
    /// `fn(number) -> vec3<u32>`: a duplicate's pixel.
    pub duplicate: Handle<Function>,
    /// `fn(number) -> vec2<i32>`: a duplicate's distance.
    pub delta: Handle<Function>,
}

/// A shader's domain, and what asking it is for.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'d> {
    /// What every pixel of the domain fulfils.
    pub formulas: &'d [Formula],
    /// Whether the author's guards are gone, so that it is asked of a pixel that is alone in its group, too.
    pub stands_for_guards: bool,
}

/// The imports for a module, its resources placed.
pub fn imports(placement: Placement) -> Imports {
    let mut imports = Imports::default();
    imports.placements.insert("vrcs_params", placement.params);
    imports.placements.insert("vrcs_coords", placement.coords);
    imports
}

/// Imports what an entry point needs, with its own domain.
pub fn import(
    module: &mut Module,
    imports: &mut Imports,
    options: &Options,
    terms: &mut Terms,
    group_size: [TermId; 3],
    entry: usize,
    domain: Asked,
) -> Prologue {
    let (prelude, params) =
        import_domain(module, imports, options, terms, group_size, entry, domain);
    Prologue {
        params,
        pixel: imports.global(&prelude, module, "vrcs_pixel"),
        copies: imports.global(&prelude, module, "vrcs_copies"),
        prefix: imports.function(&prelude, module, "vrcs_prefix"),
        duplicate: imports.function(&prelude, module, "vrcs_duplicate"),
        delta: imports.function(&prelude, module, "vrcs_delta"),
    }
}

/// Readies the imports of an entry point: its parameters, and its own domain in the place of the prelude's.
pub(super) fn import_domain(
    module: &mut Module,
    imports: &mut Imports,
    options: &Options,
    terms: &mut Terms,
    group_size: [TermId; 3],
    entry: usize,
    domain: Asked,
) -> (Arc<Module>, Handle<GlobalVariable>) {
    let prelude = prelude(options);
    let params = imports.global(&prelude, module, "vrcs_params");
    imports.unhook();
    let Asked {
        formulas: domain,
        stands_for_guards,
    } = domain;
    if !domain.is_empty() {
        let width = terms.width;
        let ids_of = |pixel| Ids {
            pixel,
            group_size,
            params,
            width,
        };
        let function = domain_function(module, terms, entry, domain, ids_of);
        imports.hook("vrcs_in_domain", function);
        let members = match stands_for_guards {
            true => "vrcs_each_in_domain",
            false => "vrcs_members_in_domain",
        };
        let members = imports.function(&prelude, module, members);
        imports.hook("vrcs_members", members);
        if stands_for_guards {
            let alone = imports.function(&prelude, module, "vrcs_is_inside_and_in_domain");
            imports.hook("vrcs_is_shaded", alone);
        }
        let throughout = throughout_function(module, terms, entry, domain, ids_of);
        imports.hook("vrcs_holds_throughout", throughout);
    }
    (prelude, params)
}

/// The shader's domain as a function of a pixel.
fn domain_function(
    module: &mut Module,
    terms: &mut Terms,
    entry: usize,
    domain: &[Formula],
    ids_of: impl Fn(Handle<Expression>) -> Ids,
) -> Handle<Function> {
    let holds = guard::all(domain, terms);
    predicate(module, "vrcs_in_domain", ["pixel"], |code, [pixel]| {
        Recompute::new(terms, entry, ids_of(pixel), []).emit(code, holds)
    })
}

/// Whether a block lies in the shader's domain as a whole, as a function of its least and greatest ids: false where that is not known.
fn throughout_function(
    module: &mut Module,
    terms: &Terms,
    entry: usize,
    domain: &[Formula],
    ids_of: impl Fn(Handle<Expression>) -> Ids,
) -> Handle<Function> {
    let name = "vrcs_in_domain_throughout";
    predicate(module, name, ["near", "far"], |code, corners| {
        let [near, far] = corners.map(|pixel| Recompute::new(terms, entry, ids_of(pixel), []));
        match corner::of_all(domain, terms) {
            Some(asked) => Corners { near, far }.emit(code, &asked),
            None => code.bool(false),
        }
    })
}

/// A function of pixels that says yes or no.
fn predicate<const N: usize>(
    module: &mut Module,
    name: &str,
    of: [&str; N],
    write: impl FnOnce(&mut Code, [Handle<Expression>; N]) -> Handle<Expression>,
) -> Handle<Function> {
    let pixel = build::numeric(&mut module.types, build::vector_size(3), Scalar::U32);
    let boolean = build::numeric(&mut module.types, None, Scalar::BOOL);
    let arguments = of.map(|name| (name, pixel));
    let (mut function, arguments) = build::function(name, &arguments, Some(boolean));
    let mut code = Code::new(&mut module.types, &mut function, Span::UNDEFINED);
    let value = write(&mut code, std::array::from_fn(|index| arguments[index]));
    code.push(naga::Statement::Return { value: Some(value) });
    function.body = code.finish();
    module.functions.append(function, Span::UNDEFINED)
}

/// What is computed for the corners of a block.
struct Corners<'t, 'm> {
    near: Recompute<'t, 'm>,
    far: Recompute<'t, 'm>,
}

impl Corners<'_, '_> {
    fn emit(&mut self, code: &mut Code, asked: &corner::Asked) -> Handle<Expression> {
        match asked {
            corner::Asked::At(corner, condition, holds) => {
                let at = match corner {
                    Corner::Near => &mut self.near,
                    Corner::Far => &mut self.far,
                };
                let value = at.emit(code, *condition);
                match holds {
                    true => value,
                    false => code.add(Expression::Unary {
                        op: UnaryOperator::LogicalNot,
                        expr: value,
                    }),
                }
            }
            corner::Asked::All(parts) => self.joined(code, parts, BinaryOperator::LogicalAnd, true),
            corner::Asked::Any(parts) => self.joined(code, parts, BinaryOperator::LogicalOr, false),
        }
    }

    /// `none` is what no parts at all come to.
    fn joined(
        &mut self,
        code: &mut Code,
        parts: &[corner::Asked],
        op: BinaryOperator,
        none: bool,
    ) -> Handle<Expression> {
        let mut parts = parts.iter();
        let Some(first) = parts.next() else {
            return code.bool(none);
        };
        let mut value = self.emit(code, first);
        for part in parts {
            let part = self.emit(code, part);
            value = code.binary(op, value, part);
        }
        value
    }
}

/// What runs for every pixel before the rest finds its own.
#[derive(Clone, Copy, Debug)]
pub struct EveryPixel {
    /// The author's part, with the entry point's arguments.
    pub function: Handle<Function>,
    /// `fn(tile, lane) -> vec3<u32>`: the invocation's own pixel.
    pub place: Handle<Function>,
    /// `fn(pixel) -> bool`: whether it lies in the extent.
    pub is_inside: Handle<Function>,
}

impl EveryPixel {
    /// Imports what it takes to run a function for every pixel.
    pub fn import(
        module: &mut Module,
        imports: &mut Imports,
        options: &Options,
        function: Handle<Function>,
    ) -> EveryPixel {
        let prelude = prelude(options);
        let place = match graded::has_user(module) {
            true => "vrcs_place_in_tile",
            false => "vrcs_place",
        };
        EveryPixel {
            function,
            place: imports.function(&prelude, module, place),
            is_inside: imports.function(&prelude, module, "vrcs_is_inside"),
        }
    }
}

/// The original's arguments, for the ids of a pixel.
fn arguments_for(
    code: &mut Code,
    terms: &Terms,
    entry: usize,
    ids: Ids,
) -> Vec<Handle<Expression>> {
    let mut recompute = Recompute::new(terms, entry, ids, []);
    let original = &terms.module().entry_points[entry].function;
    let mut arguments = Vec::with_capacity(original.arguments.len());
    for argument in &original.arguments {
        let builtin = |code: &mut Code, binding: &Option<Binding>, ty| {
            binding
                .as_ref()
                .and_then(Binding::to_built_in)
                .and_then(|builtin| recompute.builtin(code, builtin))
                // the plan has seen to it that nothing uses the others
                .unwrap_or_else(|| code.add(Expression::ZeroValue(ty)))
        };
        arguments.push(compose_argument(code, terms.module(), argument, builtin));
    }
    arguments
}

/// Makes the new entry point function, which calls `inner` with impersonated ids; before it, with the invocation's own, what runs
/// for every pixel.
pub fn entry_function(
    module: &mut Module,
    terms: &Terms,
    group_size: [TermId; 3],
    entry: usize,
    prologue: &Prologue,
    every: Option<EveryPixel>,
    inner: Handle<Function>,
) -> Function {
    let ids_type = build::numeric(&mut module.types, build::vector_size(3), Scalar::U32);
    let lane_type = build::numeric(&mut module.types, None, Scalar::U32);
    let mut function = Function::default();
    let arguments = [
        ("vrcs_group", ids_type, BuiltIn::WorkGroupId),
        ("vrcs_lane", lane_type, BuiltIn::LocalInvocationIndex),
    ]
    .map(|(name, ty, builtin)| add_builtin(&mut function, name, ty, builtin));
    let mut code = Code::new(&mut module.types, &mut function, Span::UNDEFINED);
    let ids_of = |pixel| Ids {
        pixel,
        group_size,
        params: prologue.params,
        width: terms.width,
    };
    if let Some(every) = every {
        let own = code.value_of(every.place, arguments.to_vec());
        let is_inside = code.value_of(every.is_inside, vec![own]);
        code.when(is_inside, |code| {
            let arguments = arguments_for(code, terms, entry, ids_of(own));
            code.call(every.function, arguments, false);
        });
    }
    let found = code.value_of(prologue.prefix, arguments.to_vec());
    code.return_unless(found);
    let pixel = code.global(prologue.pixel);
    let arguments = arguments_for(&mut code, terms, entry, ids_of(pixel));
    code.call(inner, arguments, false);
    let body = code.finish();
    build::set_body(&mut function, body);
    function
}

/// Has a new entry point take a builtin.
pub(super) fn add_builtin(
    function: &mut Function,
    name: &str,
    ty: Handle<naga::Type>,
    builtin: BuiltIn,
) -> Handle<Expression> {
    let index = function.arguments.len() as u32;
    function.arguments.push(FunctionArgument {
        name: Some(name.to_owned()),
        ty,
        binding: Some(Binding::BuiltIn(builtin)),
    });
    function
        .expressions
        .append(Expression::FunctionArgument(index), Span::UNDEFINED)
}

/// An argument of the original, from its builtins.
pub(super) fn compose_argument(
    code: &mut Code,
    module: &Module,
    argument: &FunctionArgument,
    mut builtin: impl FnMut(&mut Code, &Option<Binding>, Handle<naga::Type>) -> Handle<Expression>,
) -> Handle<Expression> {
    match &module.types[argument.ty].inner {
        TypeInner::Struct { members, .. } if argument.binding.is_none() => {
            let components = members
                .iter()
                .map(|member| builtin(code, &member.binding, member.ty))
                .collect();
            code.add(Expression::Compose {
                ty: argument.ty,
                components,
            })
        }
        _ => builtin(code, &argument.binding, argument.ty),
    }
}
