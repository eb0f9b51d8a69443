//! Rewrites compute shaders into variable-rate compute shaders.
//!
//! A shader that computes one result per invocation is wrapped so that only *primary* pixels are shaded and their
//! *duplicates* get copies: VRCSPrefix finds the pixel that an invocation has to shade, or lets it leave at once, so that
//! whole waves retire; VRCSPostFix repeats each store for the duplicates (Fuller and Hammer, *Variable-Rate Compute Shaders in
//! DOOM: The Dark Ages*, GPC 2025). The shader's source does not change.
//!
//! ```
//! let source = vrcs_passes::Source::new(
//!     "shade.wgsl",
//!     "
//!     @group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
//!
//!     @compute @workgroup_size(8, 8)
//!     fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
//!         textureStore(picture, id.xy, vec4(vec2<f32>(id.xy) / 64.0, 0.0, 1.0));
//!     }
//!     ",
//! );
//! let (module, info) = vrcs_passes::input::wgsl(&source)?;
//! let rewritten = vrcs_passes::rewrite(&module, &info, "shade", &vrcs_passes::Options::default())?;
//! let text = vrcs_passes::emit::wgsl(&rewritten.module, &rewritten.info)?;
//! assert!(text.contains("fn vrcs_copy_picture"));
//! assert_eq!(rewritten.manifest.entries[0].workgroup_size, [16, 16, 1]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The contract
//!
//! Let S(p) be what the original's invocation p writes, and q(p) the primary of p. The rewritten dispatch writes, for
//! every p of the logical extent and of the shader's own domain, the *values* of S(q(p)) at the *addresses* that p itself
//! would have used; and nothing else. A shader for which this cannot be proved is [refused](Refusal), with the
//! place in its source and the reason. It is never rewritten wrongly and never passed through in silence.
//!
//! # Three ways to use it
//!
//! - In a build script, [`build::Rewriter`] rewrites a folder and writes typed constants for what the shaders bind.
//! - The program `vrcs` (of the crate of that name) rewrites files and folders, explains and checks.
//! - As a library: an [`input::Reader`] reads WGSL of several files with naga_oil's `#import` and `#ifdef`, SPIR-V and GLSL;
//!   [`rewrite`] rewrites; [`emit::write`](emit::write()) writes WGSL, SPIR-V, HLSL, MSL and GLSL; [`explain::explain`] tells
//!   what is made of a shader and why. The features `spirv`, `glsl`, `hlsl` and `msl`, on by default, bring the languages
//!   besides WGSL.
//!
//! # How it is built
//!
//! [`analysis`] learns everything about the untouched module, [`plan`] decides, [`transform`] carries out, [`ir::verify`] checks
//! what naga's validator does not, and [`emit`] writes WGSL and compares a fresh parse of it with the module.

pub mod analysis;
pub mod auto;
pub mod build;
pub mod deep;
pub mod detail;
pub mod emit;
pub mod examples;
pub mod explain;
pub mod finding;
pub mod full;
pub mod graded;
mod group_size;
pub mod inline;
pub mod input;
pub mod instrument;
pub mod ir;
pub mod manifest;
pub mod near;
pub mod options;
pub mod plan;
pub mod prelude;
pub mod source;
pub mod told;
pub mod transform;

use std::collections::BTreeMap;

use naga::{
    Function, Handle, Module, ShaderStage,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use analysis::{Facts, FunctionRef};
pub use finding::{Code, Color, Finding, Refusal, Severity};
use ir::{import::Imports, names, verify};
use manifest::Manifest;
pub use options::Options;
use options::{MaxRate, Mode, Policy};
pub use source::Source;
use transform::{
    bindings::Placement,
    settled::{Settled, with_settled},
};

/// Which entry points to rewrite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries<'e> {
    /// The one with this name.
    Named(&'e str),
    /// Every compute entry point that stores per pixel.
    PerPixel,
}

impl<'e> From<&'e str> for Entries<'e> {
    fn from(name: &'e str) -> Entries<'e> {
        Entries::Named(name)
    }
}

/// A module with rewritten entry points.
#[derive(Clone, Debug)]
pub struct Rewritten {
    /// The module.
    pub module: Module,
    /// What naga knows of it.
    pub info: ModuleInfo,
    /// What is needed to dispatch it.
    pub manifest: Manifest,
    /// Findings that did not stop the rewrite, with the name of their entry point.
    pub warnings: Vec<(String, Finding)>,
    /// Compute entry points that store nothing per pixel, left as they are, and why.
    pub left_alone: Vec<(String, Finding)>,
}

/// Rewrites entry points of a module.
///
/// `module` has to be valid, and `info` what the validator said of it. The result validates, keeps all that is the author's
/// where it was (types, constants, overrides, globals, functions, other entry points), and adds two bindings that the
/// [manifest](Manifest) names.
///
/// # Errors
/// All reasons for which an entry point that was named, or that stores per pixel, cannot be rewritten.
pub fn rewrite<'e>(
    module: &Module,
    info: &ModuleInfo,
    entries: impl Into<Entries<'e>>,
    options: &Options,
) -> Result<Rewritten, Refusal> {
    rewrite_and_look(module, info, entries.into(), options, &mut |_, _| ())
}

/// What is shown each plan that is carried out, with the module that it is about.
pub(crate) type Look<'l> = dyn FnMut(&Module, &plan::EntryPlan) + Send + 'l;

pub(crate) fn rewrite_and_look(
    module: &Module,
    info: &ModuleInfo,
    entries: Entries,
    options: &Options,
    look: &mut Look,
) -> Result<Rewritten, Refusal> {
    let depth = deep::of_module(module);
    if depth > deep::MOST {
        let finding = Finding::new(
            Code::TooManyPaths,
            format!(
                "the module nests {depth} deep, and {} is the most",
                deep::MOST
            ),
        );
        return Err(finding
            .help("split long expressions and chains of `else if`")
            .into());
    }
    deep::run_if_deep(depth, || rewrite_here(module, info, entries, options, look))
}

fn rewrite_here(
    module: &Module,
    info: &ModuleInfo,
    entries: Entries,
    options: &Options,
    look: &mut Look,
) -> Result<Rewritten, Refusal> {
    if options.mode == Mode::Auto {
        let (mode, reason) = match options.targets.values().any(|&p| p == Policy::Full) {
            true => (
                Mode::Tiled,
                "a target is `full`, and only tiles visit every pixel",
            ),
            false => auto::mode(module, info, entries),
        };
        let with = |mode| Options {
            mode,
            ..options.clone()
        };
        let (mut rewritten, reason) = match rewrite_here(module, info, entries, &with(mode), look) {
            Ok(rewritten) => (rewritten, reason),
            Err(refusal)
                if mode != Mode::Tiled && full::unasked::may_answer(&refusal.findings, mode) =>
            {
                let tiled = rewrite_here(module, info, entries, &with(Mode::Tiled), look);
                let why = "a target is stored for every pixel, and only tiles visit them all";
                (tiled?, why)
            }
            Err(refusal) => return Err(refusal),
        };
        for entry in &mut rewritten.manifest.entries {
            entry.mode_reason = Some(reason.to_owned());
        }
        return Ok(rewritten);
    }
    let chosen = choose(module, entries)?;
    check_names(module, options)?;
    for &index in &chosen {
        group_size::check(module, index)?;
    }
    if let Some((module, info)) = detail::follow_rate(module, info, &chosen, options)? {
        let options = Options {
            scale_gradients: false,
            bias_level: Default::default(),
            ..options.clone()
        };
        return rewrite_here(&module, &info, entries, &options, look);
    }
    if options.mode != Mode::Graded {
        let asks_depth = |&index: &usize| graded::asks_depth(module, index);
        if !options.linear_depth && chosen.iter().any(asks_depth) {
            let options = Options {
                linear_depth: true,
                ..options.clone()
            };
            return rewrite_here(module, info, entries, &options, look);
        }
        check_linear_depth(module, info, &chosen, options)?;
    }
    if options.mode == Mode::Graded {
        return graded::rewrite(module, info, &chosen, options);
    }
    let inlined = inline::barriers(module, &chosen);
    let (module, info) = match &inlined {
        Some(inlined) => (&inlined.module, &inlined.info),
        None => (module, info),
    };
    let mut taken = BTreeMap::new();
    match rewrite_all(module, info, &chosen, options, &taken, look)? {
        Outcome::Rewritten(rewritten) => return Ok(*rewritten),
        Outcome::Refused(refused) => {
            let mut refusals = Vec::new();
            for (index, findings) in refused {
                match full::unasked::take(module, index, options, &findings) {
                    Ok(Some(policies)) => {
                        taken.insert(index, policies);
                    }
                    Ok(None) => refusals.extend(findings),
                    Err(findings) => refusals.extend(findings),
                }
            }
            if !refusals.is_empty() {
                return Err(Refusal { findings: refusals });
            }
        }
    }
    match rewrite_all(module, info, &chosen, options, &taken, look)? {
        Outcome::Rewritten(rewritten) => Ok(*rewritten),
        Outcome::Refused(refused) => Err(Refusal {
            findings: refused
                .into_iter()
                .flat_map(|(_, findings)| findings)
                .collect(),
        }),
    }
}

/// What becomes of entry points.
enum Outcome {
    Rewritten(Box<Rewritten>),
    /// Those that stand in the way, and why.
    Refused(Vec<(usize, Vec<Finding>)>),
}

/// Rewrites entry points, some with policies that were [taken](full::unasked) for them.
fn rewrite_all(
    module: &Module,
    info: &ModuleInfo,
    chosen: &[usize],
    options: &Options,
    taken: &BTreeMap<usize, full::unasked::Taken>,
    look: &mut Look,
) -> Result<Outcome, Refusal> {
    let options_of = |index: &usize| taken.get(index).map_or(options, |taken| &taken.options);
    let each: Vec<_> = chosen
        .iter()
        .map(|index| (*index, options_of(index)))
        .collect();
    let split = full::split(module, &each)?;
    let mut rewriter = Rewriter::new((module, info), split.as_ref(), chosen, options)?;
    let mut refused = Vec::new();
    let mut left_alone = Vec::new();
    for (index, options) in each {
        rewriter.options = options;
        let told = taken.get(&index).map_or(&[][..], |taken| &taken.warnings);
        let Err(findings) = rewriter.entry(index, told, look) else {
            continue;
        };
        match findings.as_slice() {
            [only] if only.code == Code::NothingPerPixel && chosen.len() > 1 => {
                left_alone.push((module.entry_points[index].name.clone(), only.clone()));
            }
            _ => refused.push((index, findings)),
        }
    }
    rewriter.options = options;
    if refused.is_empty() && rewriter.rewritten.is_empty() {
        return Err(Refusal {
            findings: left_alone.into_iter().map(|(_, finding)| finding).collect(),
        });
    }
    match refused.is_empty() {
        true => Ok(Outcome::Rewritten(Box::new(rewriter.finish(left_alone)?))),
        false => Ok(Outcome::Refused(refused)),
    }
}

/// Whether there is room for linear depth in the entries, and it is the pixel's at hand wherever it is asked for.
fn check_linear_depth(
    module: &Module,
    info: &ModuleInfo,
    entries: &[usize],
    options: &Options,
) -> Result<(), Refusal> {
    if !options.linear_depth {
        return Ok(());
    }
    if options.max_rate != MaxRate::R2x2 || options.tile.iter().any(|&side| side > 16) {
        return Err(Finding::new(
            Code::UnfitOption,
            "entries have bits to spare for linear depth only where no group is larger than 2x2 and no side of a tile longer than 16",
        )
        .help("choose --max-rate 2x2 and a tile of 16x16, or do without `vrcs_depth()` and --linear-depth")
        .into());
    }
    let together = |&&index: &&usize| {
        graded::asks_depth(module, index) && auto::works_together(module, info, index)
    };
    match entries.iter().find(together) {
        None => Ok(()),
        Some(&index) => Err(Finding::new(
            Code::UnfitOption,
            format!(
                "`{}` asks `vrcs_depth()`, and its invocations work together: some do it for a primary, some for themselves",
                module.entry_points[index].name
            ),
        )
        .help("load the depth in the shader, or do what needs it in an entry point without barriers and workgroup memory")
        .into()),
    }
}

/// Every resource that the options name is in the module.
fn check_names(module: &Module, options: &Options) -> Result<(), Refusal> {
    let names = || (module.global_variables.iter()).filter_map(|(_, g)| g.name.as_deref());
    let targets = options
        .targets
        .keys()
        .map(|name| (name, "to which a policy could apply"));
    let biased = (options.bias_level.iter()).map(|name| (name, "whose level could be biased"));
    let distinct = options.distinct.iter().flatten();
    let distinct = distinct.map(|name| (name, "that could be distinct from another"));
    let apart =
        (options.apart.iter()).map(|name| (name, "that could be read apart from its stores"));
    for (name, what) in targets.chain(biased).chain(distinct).chain(apart) {
        if !names().any(|known| known == name) {
            let finding = Finding::new(
                Code::UnfitOption,
                format!("the shader has no resource called `{name}` {what}"),
            );
            return Err(match near::nearest(name, names()) {
                Some(near) => finding.help(format!("did you mean `{near}`?")),
                None => finding,
            }
            .into());
        }
    }
    check_words(module, options)
}

/// What the author gives a word of is a resource that a shader may write.
fn check_words(module: &Module, options: &Options) -> Result<(), Refusal> {
    let distinct = options.distinct.iter().flatten();
    let distinct = distinct.map(|name| {
        (
            name,
            "it is distinct",
            "name two storage buffers or textures that are written",
        )
    });
    let apart = options.apart.iter();
    let apart = apart.map(|name| {
        (
            name,
            "its reads lie apart",
            "name a storage buffer or texture that is read and written",
        )
    });
    for (name, word, help) in distinct.chain(apart) {
        let named = |global: &naga::GlobalVariable| global.name.as_ref() == Some(name);
        let is_written = (module.global_variables.iter())
            .any(|(_, global)| named(global) && transform::bindings::is_writable(module, global));
        if !is_written {
            let finding = Finding::new(
                Code::UnfitOption,
                format!("`{name}` cannot be written, so it needs no word that {word}"),
            );
            return Err(finding.help(help).into());
        }
    }
    Ok(())
}

/// The compute entry points that are meant.
fn choose(module: &Module, entries: Entries) -> Result<Vec<usize>, Refusal> {
    let compute: Vec<usize> = module
        .entry_points
        .iter()
        .enumerate()
        .filter(|(_, entry)| entry.stage == ShaderStage::Compute)
        .map(|(index, _)| index)
        .collect();
    if compute.is_empty() {
        let finding = Finding::new(
            Code::NoComputeEntry,
            "the module has no compute entry point",
        );
        let help = "name a shader with `@compute`; vertex and fragment shaders have the hardware's variable-rate shading";
        return Err(finding.help(help).into());
    }
    let Entries::Named(name) = entries else {
        return Ok(compute);
    };
    let found = compute
        .iter()
        .find(|&&index| module.entry_points[index].name == name);
    match found {
        Some(&index) => Ok(vec![index]),
        None => {
            let names: Vec<_> = compute
                .iter()
                .map(|&index| format!("`{}`", module.entry_points[index].name))
                .collect();
            let finding = Finding::new(
                Code::UnknownEntry,
                format!("no compute entry point is called `{name}`"),
            );
            Err(finding
                .help(format!("there are {}", names.join(", ")))
                .into())
        }
    }
}

/// A module while its entry points are rewritten, one by one.
struct Rewriter<'r> {
    /// The author's module.
    author: (&'r Module, &'r ModuleInfo),
    /// What is rewritten: the author's module, with the stores to `full` targets apart.
    original: &'r Module,
    info: &'r ModuleInfo,
    full: Option<&'r BTreeMap<usize, full::Full>>,
    options: &'r Options,
    placement: Placement,
    imports: Imports,
    module: Module,
    manifest: Manifest,
    rewritten: Vec<usize>,
    /// Each clone, and what it was made from.
    clones: Vec<(usize, FunctionRef, Handle<Function>)>,
    /// Each entry point's conditions that are literals now.
    settled: BTreeMap<usize, Vec<Settled>>,
    /// Each entry point that was split, and what it became.
    split: Vec<(usize, Handle<Function>)>,
    warnings: Vec<(String, Finding)>,
}

impl<'r> Rewriter<'r> {
    fn new(
        author: (&'r Module, &'r ModuleInfo),
        split: Option<&'r full::Split>,
        entries: &[usize],
        options: &'r Options,
    ) -> Result<Rewriter<'r>, Refusal> {
        let placement = transform::bindings::place(author.0, author.1, entries, options)?;
        let (original, info) = split.map_or(author, |split| (&split.module, &split.info));
        Ok(Rewriter {
            author,
            full: split.map(|split| &split.full),
            original,
            info,
            options,
            placement,
            imports: transform::prologue::imports(placement),
            module: original.clone(),
            manifest: Manifest::new(),
            rewritten: Vec::new(),
            clones: Vec::new(),
            settled: BTreeMap::new(),
            split: Vec::new(),
            warnings: Vec::new(),
        })
    }

    /// Rewrites an entry point, `told` being what is to be said of it besides.
    fn entry(
        &mut self,
        index: usize,
        told: &[Finding],
        look: &mut Look,
    ) -> Result<(), Vec<Finding>> {
        let name = &self.original.entry_points[index].name;
        if is_rewritten(self.original, self.info, index) {
            let finding = Finding::new(
                Code::AlreadyRewritten,
                format!("the entry point `{name}` has been rewritten before"),
            );
            return Err(vec![finding.help("rewrite the shader that it came from")]);
        }
        let facts = Facts::new(self.original, index);
        let full = self.full.and_then(|full| full.get(&index));
        let mut plan = plan::plan(self.original, self.info, &facts, index, self.options).map_err(
            |findings| match (full, findings.as_slice()) {
                (Some(full), [only]) if only.code == Code::NothingPerPixel => {
                    vec![full::nothing_left(self.original, &full.targets)]
                }
                _ => findings,
            },
        )?;
        plan.warnings.splice(0..0, told.iter().cloned());
        look(self.original, &plan);
        let beyond =
            transform::bindings::check_limits(self.author.0, self.author.1, index, self.options)
                .map_err(|finding| vec![finding])?;
        plan.warnings.extend(beyond);
        plan.full = full.map(|full| full.function);
        let applied = transform::apply(
            &mut self.module,
            self.original,
            self.info,
            index,
            &mut plan,
            &mut self.imports,
            self.options,
        )?;
        for &global in full.iter().flat_map(|full| &full.targets) {
            let policy = Policy::Full;
            plan.targets.push(plan::TargetPlan { global, policy });
        }
        plan.targets.sort_by_key(|target| target.global);
        self.clones.extend(
            applied
                .clones
                .into_iter()
                .map(|(of, clone)| (index, of, clone)),
        );
        self.settled.insert(index, applied.settled);
        self.split.extend(applied.split.map(|split| (index, split)));
        self.manifest.entries.push(manifest::entry(
            self.author.0,
            self.author.1,
            index,
            self.options,
            self.placement,
            &plan.targets,
        ));
        if let (Some(group), Some(entry)) = (plan.group.take(), self.manifest.entries.last_mut()) {
            let size = group_size::by_default(self.original, self.info, index);
            entry.set_group(group.report, size);
        }
        self.warnings
            .extend(plan.warnings.drain(..).map(|w| (name.clone(), w)));
        self.rewritten.push(index);
        Ok(())
    }

    /// Checks what was made.
    fn finish(mut self, left_alone: Vec<(String, Finding)>) -> Result<Rewritten, Refusal> {
        let defect = |what: String| {
            Refusal::from(
                Finding::new(Code::Defect, format!("the rewriter made a mistake: {what}"))
                    .help("this is a defect of vrcs; please report it with the shader"),
            )
        };
        verify::check(&self.module).map_err(|broken| defect(broken.to_string()))?;
        let before: Vec<Function> = self
            .clones
            .iter()
            .map(|&(entry, of, _)| {
                let function = of.get(self.original, entry);
                match (of, self.settled.get(&entry)) {
                    (FunctionRef::Entry, Some(settled)) => with_settled(function, settled),
                    _ => function.clone(),
                }
            })
            .collect();
        let after = self.clones.iter();
        let clones: Vec<(&Function, &Function)> = before
            .iter()
            .zip(after.map(|&(_, _, clone)| &self.module.functions[clone]))
            .collect();
        verify::follows(self.original, &self.module, &self.rewritten, &clones)
            .map_err(|broken| defect(broken.to_string()))?;
        for &(entry, split) in &self.split {
            let before = &self.original.entry_points[entry].function;
            verify::barriers(
                before,
                &self.module,
                split,
                &self.module.entry_points[entry].function,
            )
            .map_err(|broken| defect(broken.to_string()))?;
        }
        let word = |[a, b]: &[String; 2]| {
            format!("`{a}` and `{b}` are never the same memory, by the author's word")
        };
        let words = self.options.distinct.iter().map(word);
        self.manifest.preconditions.extend(words);
        let word = |name: &String| {
            format!(
                "`{name}` is never read where another pixel stores, whatever its data, by the author's word"
            )
        };
        let words = self.options.apart.iter().map(word);
        self.manifest.preconditions.extend(words);
        graded::give_their_meaning(&mut self.module, &mut self.imports, self.options);
        names::leave_to_resources(&mut self.module);
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&self.module)
            .map_err(|error| defect(format!("{:?}", error.into_inner())))?;
        Ok(Rewritten {
            module: self.module,
            info,
            manifest: self.manifest,
            warnings: self.warnings,
            left_alone,
        })
    }
}

/// Whether an entry point uses the coordinate buffer already.
fn is_rewritten(module: &Module, info: &ModuleInfo, entry: usize) -> bool {
    let uses = info.get_entry_point(entry);
    module.global_variables.iter().any(|(handle, global)| {
        global.name.as_deref() == Some("vrcs_coords")
            && global.binding.is_some()
            && !uses[handle].is_empty()
    })
}
