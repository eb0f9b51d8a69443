//! The new entry point of a shader with barriers: nobody leaves, but for a whole workgroup without a primary.
//!
//! ```wgsl
//! @compute @workgroup_size(8, 8)
//! fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, ..) {
//!     if vrcs_tile_is_empty(vrcs_group) { return; }      // the same for the whole workgroup
//!     vrcs_group_begin(vrcs_group, vrcs_id, vrcs_lane, vec2(8u, 8u));
//!     main_inner(vrcs_id, vrcs_pixel);                   // the real ids, then the primary's
//! }
//! ```
//!
//! *Guarantees*: the workgroup size stays as it was; the primary's workgroup is the invocation's own.

use naga::{Binding, BuiltIn, Expression, Function, GlobalVariable, Handle, Module, Scalar, Span};

use crate::{
    analysis::{
        guard::Formula,
        term::{TermId, Terms},
    },
    ir::{
        build::{self, Code},
        import::Imports,
    },
    options::Options,
    transform::{
        prologue::{Asked, Prologue, add_builtin, compose_argument, import_domain},
        recompute::{Ids, Recompute},
    },
};

/// What a shader with barriers uses of the prelude besides.
#[derive(Clone, Copy, Debug)]
pub struct GroupPrelude {
    /// Whether the invocation has a primary.
    pub on: Handle<GlobalVariable>,
    /// The invocation's place in the workgroup.
    pub lane: Handle<GlobalVariable>,
    /// Its primary's place in the workgroup.
    pub slot: Handle<GlobalVariable>,
    /// `fn(tile, pixel, lane, size)`: finds the primary.
    pub begin: Handle<Function>,
    /// `fn(tile) -> bool`: whether the workgroup has no primary.
    pub is_empty: Handle<Function>,
    /// What masked regions need.
    pub masks: Option<Masks>,
}

/// What masked regions use of the prelude.
#[derive(Clone, Copy, Debug)]
pub struct Masks {
    /// `fn(pixel)`: tells each primary's own invocation of its duplicates.
    pub find: Handle<Function>,
    /// Whether the invocation's own pixel is a primary.
    pub is_primary: Handle<GlobalVariable>,
    /// Changes between the primary of the lane and the invocation's own pixel.
    pub change_pixel: Handle<Function>,
}

impl GroupPrelude {
    /// What masked regions need.
    pub fn masks(&self) -> &Masks {
        match &self.masks {
            Some(masks) => masks,
            None => unreachable!("imported where a region is masked"),
        }
    }
}

/// What the imports of an entry point depend on.
pub struct Wanted<'w> {
    /// How it is rewritten.
    pub options: &'w Options,
    /// The original workgroup size.
    pub group_size: [TermId; 3],
    /// The entry point's number.
    pub entry: usize,
    /// Its domain.
    pub domain: &'w [Formula],
    /// Whether a region is masked.
    pub is_masked: bool,
}

/// Imports what an entry point with barriers needs, with its own domain.
pub fn import(
    module: &mut Module,
    imports: &mut Imports,
    terms: &mut Terms,
    wanted: &Wanted,
) -> (Prologue, GroupPrelude) {
    let &Wanted {
        options,
        group_size,
        entry,
        domain,
        is_masked,
    } = wanted;
    let domain = Asked {
        formulas: domain,
        stands_for_guards: false,
    };
    let (prelude, params) =
        import_domain(module, imports, options, terms, group_size, entry, domain);
    let begin = imports.function(&prelude, module, "vrcs_group_begin");
    let group = GroupPrelude {
        on: imports.global(&prelude, module, "vrcs_on"),
        lane: imports.global(&prelude, module, "vrcs_lane"),
        slot: imports.global(&prelude, module, "vrcs_slot"),
        begin,
        is_empty: imports.function(&prelude, module, "vrcs_tile_is_empty"),
        masks: is_masked.then(|| Masks {
            find: imports.function(&prelude, module, "vrcs_group_masks"),
            is_primary: imports.global(&prelude, module, "vrcs_is_primary"),
            change_pixel: imports.function(&prelude, module, "vrcs_change_pixel"),
        }),
    };
    let prologue = Prologue {
        params,
        pixel: imports.global(&prelude, module, "vrcs_pixel"),
        copies: imports.global(&prelude, module, "vrcs_copies"),
        prefix: begin,
        duplicate: imports.function(&prelude, module, "vrcs_duplicate"),
        delta: imports.function(&prelude, module, "vrcs_delta"),
    };
    (prologue, group)
}

/// The builtins of the new entry point.
struct Real {
    group: Handle<Expression>,
    lane: Handle<Expression>,
    id: Handle<Expression>,
    local: Handle<Expression>,
}

/// Makes the new entry point function, which calls `inner` with the real ids and with the primary's.
pub fn entry_function(
    module: &mut Module,
    terms: &Terms,
    group_size: [TermId; 3],
    entry: usize,
    prologue: &Prologue,
    group: &GroupPrelude,
    inner: Handle<Function>,
) -> Function {
    let vector = build::numeric(&mut module.types, build::vector_size(3), Scalar::U32);
    let scalar = build::numeric(&mut module.types, None, Scalar::U32);
    let mut function = Function::default();
    let [tile, lane, id, local] = [
        ("vrcs_group", vector, BuiltIn::WorkGroupId),
        ("vrcs_lane_index", scalar, BuiltIn::LocalInvocationIndex),
        ("vrcs_id", vector, BuiltIn::GlobalInvocationId),
        ("vrcs_local", vector, BuiltIn::LocalInvocationId),
    ]
    .map(|(name, ty, builtin)| add_builtin(&mut function, name, ty, builtin));
    let real = Real {
        group: tile,
        lane,
        id,
        local,
    };
    let original = &terms.module().entry_points[entry].function;
    let mut code = Code::new(&mut module.types, &mut function, Span::UNDEFINED);
    let is_empty = code.value_of(group.is_empty, vec![tile]);
    code.when(is_empty, |code| {
        code.push(naga::Statement::Return { value: None });
    });
    let ids = |pixel| Ids {
        pixel,
        group_size,
        params: prologue.params,
        // a dispatch of one dimension is refused where invocations work together
        width: None,
    };
    let mut recompute = Recompute::new(terms, entry, ids(id), []);
    let sizes = [0, 1].map(|axis| recompute.emit(&mut code, group_size[axis]));
    let size = code.vector(Scalar::U32, sizes.to_vec());
    code.call(group.begin, vec![tile, id, lane, size], false);
    if let Some(masks) = group.masks {
        code.call(masks.find, vec![id], false);
    }
    let mut arguments = Vec::with_capacity(2 * original.arguments.len());
    for argument in &original.arguments {
        let value = |code: &mut Code, binding: &Option<Binding>, ty| {
            let builtin = binding.as_ref().and_then(Binding::to_built_in);
            let known = match builtin {
                Some(BuiltIn::GlobalInvocationId) => Some(real.id),
                Some(BuiltIn::LocalInvocationId) => Some(real.local),
                Some(BuiltIn::LocalInvocationIndex) => Some(real.lane),
                Some(BuiltIn::WorkGroupId) => Some(real.group),
                Some(other) => recompute.builtin(code, other),
                None => None,
            };
            known.unwrap_or_else(|| code.add(Expression::ZeroValue(ty)))
        };
        arguments.push(compose_argument(&mut code, terms.module(), argument, value));
    }
    let pixel = code.global(prologue.pixel);
    let mut recompute = Recompute::new(terms, entry, ids(pixel), []);
    for argument in &original.arguments {
        let value = |code: &mut Code, binding: &Option<Binding>, ty| {
            let builtin = binding.as_ref().and_then(Binding::to_built_in);
            let known = match builtin {
                Some(BuiltIn::WorkGroupId) => Some(real.group),
                Some(other) => recompute.builtin(code, other),
                None => None,
            };
            known.unwrap_or_else(|| code.add(Expression::ZeroValue(ty)))
        };
        arguments.push(compose_argument(&mut code, terms.module(), argument, value));
    }
    code.call(inner, arguments, false);
    let body = code.finish();
    build::set_body(&mut function, body);
    function
}
