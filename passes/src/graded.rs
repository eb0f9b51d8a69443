//! The intrinsics, and graded mode.
//!
//! A shader may declare two functions, which without the rewriter say that nothing is shared:
//!
//! ```wgsl
//! fn vrcs_copies() -> u32 { return 0u; }
//! fn vrcs_rate() -> vec2<u32> { return vec2<u32>(1u); }
//! fn vrcs_user() -> u32 { return 0u; }
//! ```
//!
//! | mode | `vrcs_copies()` | `vrcs_rate()` | `vrcs_user()` |
//! |---|---|---|---|
//! | tiled, list, classified | 0: a primary does the work of its whole group | the block that it stands for | the four bits of its tile |
//! | graded | how many other pixels share this one's work | the block that they fill | the four bits of its tile |
//!
//! A tile's bits are the renderer's own, such as that fog covers it (the slides' tile flags). A group lies in one tile, so `if
//! (vrcs_user() & FOG) != 0u { return; }` decides for a primary and its duplicates alike, and for whole waves where the tile is the workgroup.
//! With variable-rate shading off nothing is built that could tell: they are 0, as the stub says.
//! In a shader with barriers a whole workgroup may leave by them, too; drivers take that, but a browser's uniformity analysis does not see that
//! all of a workgroup are told the same, and rejects it before a barrier.
//!
//! A fourth, `fn vrcs_depth() -> f32 { return -1.0; }`, is told the linear depth of the pixel at hand, 0 at the near plane and 1 at the far one,
//! where the view's entries [carry it](crate::options::Options::linear_depth) and one was loaded: not in tiles of one rate throughout, not for a
//! group that was re-homed, not in graded mode, not with shading rates off. Below 0 the shader looks itself:
//!
//! ```wgsl
//! var depth = vrcs_depth();
//! if depth < 0.0 { depth = linear(textureLoad(depths, id.xy, 0)); }
//! ```
//!
//! So `n / (1 + vrcs_copies())` rays (slides, "Non-binary use of VRCS!") are all n at a primary whose result is copied, and a
//! share of them where every pixel fires its own. Whole numbers would lose rays, and one ray among four pixels would be none:
//! [`RAYS`] is text for the shader that rounds by chance, so that no pixel fires none and the mean over frames is right. [`share`]
//! is the same on the CPU.
//!
//! *Does* (graded mode): nothing is remapped, confined or copied; the entry point finds its pixel's byte first, and the stubs
//! give what it says. *Guarantees*: the workgroup, every id and store are the author's. *Refuses*: a shader that calls neither of the
//! first two, and one with barriers or workgroup memory.

use naga::{
    Binding, BuiltIn, Expression, Function, FunctionArgument, Handle, Module, Range, Scalar, Span,
    Statement, TypeInner,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use crate::{
    Rewritten, auto,
    finding::{Code, Finding, Refusal},
    ir::{build, import::Imports, verify, visit},
    manifest::{self, Manifest},
    options::{Mode, Options},
    prelude::prelude,
    transform::{bindings, prologue},
};

/// Helpers for a shader's own text, which calls `vrcs_copies()`:
///
/// - `vrcs_noise(pixel, frame)`: 0 to 1, without 1; another value for each pixel and frame. Any other noise will do.
/// - `vrcs_share(rays, noise)`: how many of `rays` this pixel fires: `rays / (1 + copies)` rounded by chance, never 0. Where a
///   share is one ray or more, the pixels of a group fire `rays` between them on average over frames.
/// - `vrcs_share_weight(rays)`: what each of them counts: 1, but less where a share is less than one ray, since none is not
///   allowed. Rays fired times their weight are `rays` for a group, on average, whatever its size.
///
/// Whole and broken parts are told apart by integers: a sum of a share and noise as floats rounds up to one ray too many.
pub const RAYS: &str = "\
fn vrcs_noise(pixel: vec2<u32>, frame: u32) -> f32 {
    // PCG (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 2020), once for each number
    var state = 0u;
    for (var i = 0u; i < 3u; i++) {
        let number = select(select(frame, pixel.y, i == 1u), pixel.x, i == 0u);
        state = (state ^ number) * 747796405u + 2891336453u;
        let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        state = (word >> 22u) ^ word;
    }
    return f32(state >> 8u) / 16777216.0;
}

fn vrcs_share(rays: u32, noise: f32) -> u32 {
    let pixels = 1u + vrcs_copies();
    let more = noise * f32(pixels) < f32(rays % pixels);
    return max(1u, rays / pixels + select(0u, 1u, more));
}

fn vrcs_share_weight(rays: u32) -> f32 {
    return min(1.0, f32(rays) / f32(1u + vrcs_copies()));
}
";

/// How many of `rays` a pixel fires that shares with `copies` others, and the weight of each: see [`RAYS`].
pub fn share(rays: u32, copies: u32, noise: f32) -> (u32, f32) {
    let pixels = 1 + copies;
    let more = noise * (pixels as f32) < (rays % pixels) as f32;
    let fired = (rays / pixels + u32::from(more)).max(1);
    (fired, (rays as f32 / pixels as f32).min(1.0))
}

/// What a pixel shares, as the intrinsics tell it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Given {
    /// How many other pixels share its work.
    pub copies: u32,
    /// The block that they fill.
    pub rate: [u32; 2],
    /// The user's own bits of its tile.
    pub user: u32,
}

impl Given {
    /// What the stubs say without the rewriter: nothing is shared.
    pub const NOTHING: Given = Given {
        copies: 0,
        rate: [1, 1],
        user: 0,
    };

    /// Nothing is shared, in a tile with these bits.
    pub const fn of_user(user: u32) -> Given {
        Given {
            user,
            ..Given::NOTHING
        }
    }
}

/// Whether an entry point asks for what its pixel shares, or for its tile's bits.
pub fn asks(module: &Module, entry: usize) -> bool {
    let stubs = [
        find(module, "vrcs_copies", Kind::Word),
        find(module, "vrcs_rate", Kind::Pair),
        find(module, "vrcs_user", Kind::Word),
    ];
    let stubs: Vec<_> = stubs.into_iter().flatten().collect();
    calls(module, &module.entry_points[entry].function, &stubs)
}

/// Whether an entry point asks for its primary's linear depth, so that the view's entries have to carry it.
pub fn asks_depth(module: &Module, entry: usize) -> bool {
    let stub = find(module, "vrcs_depth", Kind::Float);
    stub.is_some_and(|stub| calls(module, &module.entry_points[entry].function, &[stub]))
}

/// Whether a module declares `vrcs_user()`.
pub(crate) fn has_user(module: &Module) -> bool {
    find(module, "vrcs_user", Kind::Word).is_some()
}

/// Whether an entry point asks for its tile's bits, so that the build has to have them.
pub fn asks_user(module: &Module, entry: usize) -> bool {
    let stub = find(module, "vrcs_user", Kind::Word);
    stub.is_some_and(|stub| calls(module, &module.entry_points[entry].function, &[stub]))
}

/// The original as it would be if every pixel shared this: its stubs give these numbers. Nothing else is changed, so it is what
/// a check holds a rewritten shader against.
pub fn with_given(original: &Module, given: Given) -> Module {
    let mut module = original.clone();
    let stubs = [
        (
            find(original, "vrcs_copies", Kind::Word),
            vec![given.copies],
        ),
        (find(original, "vrcs_rate", Kind::Pair), given.rate.to_vec()),
        (find(original, "vrcs_user", Kind::Word), vec![given.user]),
    ];
    for (stub, values) in stubs {
        if let Some(stub) = stub {
            give(&mut module.functions[stub], &values);
        }
    }
    module
}

/// Lets a stub give constants.
fn give(stub: &mut Function, values: &[u32]) {
    let Some(result) = &stub.result else { return };
    let ty = result.ty;
    let mut expressions = naga::Arena::new();
    let literals: Vec<_> = values
        .iter()
        .map(|&value| {
            let literal = Expression::Literal(naga::Literal::U32(value));
            expressions.append(literal, Span::UNDEFINED)
        })
        .collect();
    let mut body = naga::Block::new();
    let value = match literals.as_slice() {
        [only] => *only,
        _ => {
            let start = expressions.len() as u32;
            let components = literals.clone();
            let pair = expressions.append(Expression::Compose { ty, components }, Span::UNDEFINED);
            let emitted = Range::from_index_range(start..start + 1, &expressions);
            body.push(Statement::Emit(emitted), Span::UNDEFINED);
            pair
        }
    };
    body.push(Statement::Return { value: Some(value) }, Span::UNDEFINED);
    *stub = Function {
        name: stub.name.clone(),
        result: stub.result.clone(),
        expressions,
        body,
        ..Function::default()
    };
}

/// Whether a function is a stub whose answer is all of its group's, and no number of the author's: `vrcs_rate()`, `vrcs_user()` or
/// `vrcs_depth()`.
pub fn is_of_group(module: &Module, function: Handle<Function>) -> bool {
    let function = &module.functions[function];
    match function.name.as_deref() {
        Some("vrcs_rate") => is_stub(module, function, Kind::Pair),
        Some("vrcs_user") => is_stub(module, function, Kind::Word),
        Some("vrcs_depth") => is_stub(module, function, Kind::Float),
        _ => false,
    }
}

/// The stub of `vrcs_rate()`, if the module has one.
pub(crate) fn rate_stub(module: &Module) -> Option<Handle<Function>> {
    find(module, "vrcs_rate", Kind::Pair)
}

/// The stub of `vrcs_rate()`, for a module that has none.
pub(crate) fn new_rate_stub(types: &mut naga::UniqueArena<naga::Type>) -> Function {
    let pair = build::numeric(types, build::vector_size(2), Scalar::U32);
    let (mut stub, _) = build::function("vrcs_rate", &[], Some(pair));
    give(&mut stub, &Given::NOTHING.rate);
    stub
}

/// Whether a function calls a stub whose answer is its [group's](is_of_group), itself or through others.
pub(crate) fn calls_of_group(module: &Module, function: Handle<Function>) -> bool {
    let stubs = [
        rate_stub(module),
        find(module, "vrcs_user", Kind::Word),
        find(module, "vrcs_depth", Kind::Float),
    ];
    let stubs: Vec<_> = stubs.into_iter().flatten().collect();
    !stubs.is_empty() && calls(module, &module.functions[function], &stubs)
}

/// What a stub gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// `u32`.
    Word,
    /// `vec2<u32>`.
    Pair,
    /// `f32`.
    Float,
}

fn is_stub(module: &Module, function: &Function, kind: Kind) -> bool {
    let result = function
        .result
        .as_ref()
        .map(|result| &module.types[result.ty].inner);
    function.arguments.is_empty()
        && match result {
            Some(TypeInner::Scalar(scalar)) => match kind {
                Kind::Word => *scalar == Scalar::U32,
                Kind::Float => *scalar == Scalar::F32,
                Kind::Pair => false,
            },
            Some(TypeInner::Vector { size, scalar }) => {
                kind == Kind::Pair && *size == naga::VectorSize::Bi && *scalar == Scalar::U32
            }
            _ => false,
        }
}

fn find(module: &Module, name: &str, kind: Kind) -> Option<Handle<Function>> {
    let mut functions = module.functions.iter();
    let found = functions.find(|(_, function)| {
        function.name.as_deref() == Some(name) && is_stub(module, function, kind)
    });
    found.map(|(handle, _)| handle)
}

/// Puts the body of an imported function into a stub.
fn replace(module: &mut Module, stub: Handle<Function>, by: Handle<Function>) {
    let mut function = module.functions[by].clone();
    function.name = module.functions[stub].name.clone();
    module.functions[stub] = function;
}

/// Lets `vrcs_rate()` give the block of the group at hand, and `vrcs_user()` the bits of its tile, in the modes that copy.
pub(crate) fn give_their_meaning(module: &mut Module, imports: &mut Imports, options: &Options) {
    let meanings = [
        (find(module, "vrcs_rate", Kind::Pair), "vrcs_group_rate"),
        (find(module, "vrcs_user", Kind::Word), "vrcs_user_bits"),
        (
            find(module, "vrcs_depth", Kind::Float).filter(|_| options.linear_depth),
            "vrcs_linear_depth",
        ),
    ];
    for (stub, name) in meanings {
        if let Some(stub) = stub {
            let own = imports.function(&prelude(options), module, name);
            replace(module, stub, own);
        }
    }
}

/// Rewrites entry points for graded mode.
///
/// # Errors
/// If an entry point calls neither intrinsic, or the added bindings have no place.
pub(crate) fn rewrite(
    original: &Module,
    info: &ModuleInfo,
    entries: &[usize],
    options: &Options,
) -> Result<Rewritten, Refusal> {
    let mut module = original.clone();
    let placement = bindings::place(original, info, entries, options)?;
    let mut imports = prologue::imports(placement);
    let prelude = prelude(options);
    let copies = find(original, "vrcs_copies", Kind::Word);
    let rate = find(original, "vrcs_rate", Kind::Pair);
    let user = find(original, "vrcs_user", Kind::Word);
    let begins = match user {
        Some(_) => "vrcs_grade_in_tile",
        None => "vrcs_grade",
    };
    let grade = imports.function(&prelude, &mut module, begins);
    for (stub, name) in [
        (copies, "vrcs_graded_copies"),
        (rate, "vrcs_graded_rate"),
        (user, "vrcs_user_bits"),
    ] {
        if let Some(stub) = stub {
            let own = imports.function(&prelude, &mut module, name);
            replace(&mut module, stub, own);
        }
    }
    let mut manifest = Manifest::new();
    let (mut left_alone, mut warnings) = (Vec::new(), Vec::new());
    for &index in entries {
        let name = original.entry_points[index].name.clone();
        let stubs: Vec<_> = copies.into_iter().chain(rate).collect();
        if !calls(original, &original.entry_points[index].function, &stubs) {
            let finding = Finding::new(
                Code::NothingGraded,
                format!(
                    "`{name}` calls neither `vrcs_copies()` nor `vrcs_rate()`: graded mode would change nothing"
                ),
            );
            left_alone.push((
                name,
                finding.help("declare `fn vrcs_copies() -> u32 { return 0u; }` and divide the work by 1 + vrcs_copies()"),
            ));
            continue;
        }
        if auto::works_together(original, info, index) {
            return Err(auto::needs_tiles(&name, options.mode).into());
        }
        // what a pixel shares is asked for by the ids of the dispatch, which have to be the pixel's
        if options.linear.is_some() {
            return Err(Finding::new(
                Code::UnfitOption,
                format!("`{name}` numbers its pixels in one dimension, and graded mode knows them by two"),
            )
            .help("dispatch it in two dimensions, or choose mode `tiled`")
            .into());
        }
        let beyond = bindings::check_limits(original, info, index, options)?;
        warnings.extend(beyond.into_iter().map(|finding| (name.clone(), finding)));
        begin(&mut module, index, grade);
        let targets = Vec::new();
        let mut entry = manifest::entry(original, info, index, options, placement, &targets);
        entry.workgroup_size = original.entry_points[index].workgroup_size;
        entry.dispatch.divide = original.entry_points[index].workgroup_size;
        manifest.entries.push(entry);
    }
    if manifest.entries.is_empty() {
        let findings = left_alone.into_iter().map(|(_, finding)| finding).collect();
        return Err(Refusal { findings });
    }
    debug_assert!(options.mode == Mode::Graded);
    let defect = |what: String| {
        Refusal::from(Finding::new(
            Code::Defect,
            format!("the rewriter made a mistake: {what}"),
        ))
    };
    verify::check(&module).map_err(|broken| defect(broken.to_string()))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|error| defect(format!("{:?}", error.into_inner())))?;
    Ok(Rewritten {
        module,
        info,
        manifest,
        warnings,
        left_alone,
    })
}

/// Whether a function calls one of these, itself or through others.
fn calls(module: &Module, function: &Function, wanted: &[Handle<Function>]) -> bool {
    let mut found = false;
    visit::statements(&function.body, &mut |statement| {
        if let Statement::Call { function, .. } = *statement {
            found |=
                wanted.contains(&function) || calls(module, &module.functions[function], wanted);
        }
    });
    found
}

/// Lets an entry point find its pixel's byte before anything else.
fn begin(module: &mut Module, entry: usize, grade: Handle<Function>) {
    let id = Some(Binding::BuiltIn(BuiltIn::GlobalInvocationId));
    let vector = build::numeric(&mut module.types, build::vector_size(3), Scalar::U32);
    let Module {
        types,
        entry_points,
        ..
    } = module;
    let function = &mut entry_points[entry].function;
    let mut place = None;
    for (index, argument) in function.arguments.iter().enumerate() {
        if argument.binding == id {
            place = Some((index, None));
        }
        if let TypeInner::Struct { members, .. } = &types[argument.ty].inner {
            let member = members.iter().position(|member| member.binding == id);
            place = place.or(member.map(|member| (index, Some(member))));
        }
    }
    let (argument, member) = place.unwrap_or_else(|| {
        function.arguments.push(FunctionArgument {
            name: Some("vrcs_id".to_owned()),
            ty: vector,
            binding: id,
        });
        (function.arguments.len() - 1, None)
    });
    let expressions = &mut function.expressions;
    let mut pixel = expressions.append(
        Expression::FunctionArgument(argument as u32),
        Span::UNDEFINED,
    );
    let mut body = naga::Block::new();
    if let Some(member) = member {
        let start = expressions.len() as u32;
        pixel = expressions.append(
            Expression::AccessIndex {
                base: pixel,
                index: member as u32,
            },
            Span::UNDEFINED,
        );
        let emitted = Range::from_index_range(start..start + 1, expressions);
        body.push(Statement::Emit(emitted), Span::UNDEFINED);
    }
    body.push(
        Statement::Call {
            function: grade,
            arguments: vec![pixel],
            result: None,
        },
        Span::UNDEFINED,
    );
    // the author's own statements follow
    body.append(&mut function.body);
    function.body = body;
}
