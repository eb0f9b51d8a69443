//! The intrinsics, and graded mode.
//!
//! A shader may declare two functions, which without the rewriter say that nothing is shared:
//!
//! ```wgsl
//! fn vrcs_copies() -> u32 { return 0u; }
//! fn vrcs_rate() -> vec2<u32> { return vec2<u32>(1u); }
//! ```
//!
//! | mode | `vrcs_copies()` | `vrcs_rate()` |
//! |---|---|---|
//! | tiled, list, classified | 0: a primary does the work of its whole group | the block that it stands for |
//! | graded | how many other pixels share this one's work | the block that they fill |
//!
//! So `n / (1 + vrcs_copies())` rays (slides, "Non-binary use of VRCS!") are all n at a primary whose result is copied, and a
//! share of them where every pixel fires its own. Whole numbers would lose rays: round by chance, so that no pixel fires none
//! and the mean over frames is right:
//!
//! ```wgsl
//! // `noise` is 0 to 1 (without 1), another value for each pixel and frame
//! fn vrcs_share(rays: u32, noise: f32) -> u32 {
//!     let sharing = 1u + vrcs_copies();
//!     let one_more = noise * f32(sharing) < f32(rays % sharing);
//!     return max(1u, rays / sharing + u32(one_more));
//! }
//! ```
//!
//! That is [`RAYS`]; [`share`] is the same on the CPU, with what is left to weigh where even one ray is more than the share.
//!
//! *Does* (graded mode): nothing is remapped, confined or copied; the entry point finds its pixel's byte first, and the stubs
//! give what it says. *Guarantees*: the workgroup, every id and store are the author's. *Refuses*: a shader that calls neither,
//! and one with barriers or workgroup memory.

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

/// The helper for a shader's own text: the number of rays, never 0, right on average.
pub const RAYS: &str = "\
// `noise` is 0 to 1 (without 1), another value for each pixel and frame
fn vrcs_share(rays: u32, noise: f32) -> u32 {
    let sharing = 1u + vrcs_copies();
    let one_more = noise * f32(sharing) < f32(rays % sharing);
    return max(1u, rays / sharing + u32(one_more));
}
";

/// How many of `rays` a pixel fires that shares with `copies` others, and the weight that keeps their sum right on average: 1,
/// but less where the share is below one ray, since none is not allowed.
pub fn share(rays: u32, copies: u32, noise: f32) -> (u32, f32) {
    let sharing = 1 + copies;
    if rays < sharing {
        return (1, rays as f32 / sharing as f32);
    }
    // in whole numbers: a sum `rays / sharing + noise` rounds up to the next one where noise is nearly 1
    let one_more = noise * (sharing as f32) < (rays % sharing) as f32;
    (rays / sharing + u32::from(one_more), 1.0)
}

/// Whether a function is the stub of `vrcs_rate()`.
pub fn is_rate(module: &Module, function: Handle<Function>) -> bool {
    let function = &module.functions[function];
    function.name.as_deref() == Some("vrcs_rate") && is_stub(module, function, true)
}

fn is_stub(module: &Module, function: &Function, is_pair: bool) -> bool {
    let result = function
        .result
        .as_ref()
        .map(|result| &module.types[result.ty].inner);
    function.arguments.is_empty()
        && match result {
            Some(TypeInner::Scalar(scalar)) => !is_pair && *scalar == Scalar::U32,
            Some(TypeInner::Vector { size, scalar }) => {
                is_pair && *size == naga::VectorSize::Bi && *scalar == Scalar::U32
            }
            _ => false,
        }
}

fn find(module: &Module, name: &str, is_pair: bool) -> Option<Handle<Function>> {
    let mut functions = module.functions.iter();
    let found = functions.find(|(_, function)| {
        function.name.as_deref() == Some(name) && is_stub(module, function, is_pair)
    });
    found.map(|(handle, _)| handle)
}

/// Puts the body of an imported function into a stub.
fn replace(module: &mut Module, stub: Handle<Function>, by: Handle<Function>) {
    let mut function = module.functions[by].clone();
    function.name = module.functions[stub].name.clone();
    module.functions[stub] = function;
}

/// Lets `vrcs_rate()` give the block of the group at hand, in the modes that copy.
pub(crate) fn give_rate_its_meaning(module: &mut Module, imports: &mut Imports, options: &Options) {
    if let Some(stub) = find(module, "vrcs_rate", true) {
        let own = imports.function(&prelude(options), module, "vrcs_group_rate");
        replace(module, stub, own);
    }
}

/// Rewrites entry points for graded mode.
///
/// # Errors
/// If an entry point calls neither intrinsic, or no bind group is free.
pub(crate) fn rewrite(
    original: &Module,
    info: &ModuleInfo,
    entries: &[usize],
    options: &Options,
) -> Result<Rewritten, Refusal> {
    let mut module = original.clone();
    let placement = bindings::place(original, options)?;
    let mut imports = prologue::imports(placement);
    let prelude = prelude(options);
    let copies = find(original, "vrcs_copies", false);
    let rate = find(original, "vrcs_rate", true);
    let grade = imports.function(&prelude, &mut module, "vrcs_grade");
    for (stub, name) in [(copies, "vrcs_graded_copies"), (rate, "vrcs_graded_rate")] {
        if let Some(stub) = stub {
            let own = imports.function(&prelude, &mut module, name);
            replace(&mut module, stub, own);
        }
    }
    let mut manifest = Manifest::new();
    let mut left_alone = Vec::new();
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
        warnings: Vec::new(),
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
