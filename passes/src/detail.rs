//! Texture detail that follows the shading rate, as hardware VRS has it on its own: a primary stands for a block, so its
//! footprint in a texture is the block's.
//!
//! ```wgsl
//! // before                                  // after, with --scale-gradients
//! textureSampleGrad(t, s, at, dx, dy)        vrcs_sample_t(at, dx, dy)
//!
//! fn vrcs_sample_t(at: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
//!     let rate = vec2<f32>(vrcs_rate());
//!     return textureSampleGrad(t, s, at, dx * rate.x, dy * rate.y);
//! }
//! ```
//!
//! `textureSampleLevel` has no footprint to be told from: its level is the author's own idea. Only for textures that are
//! [named](crate::Options::bias_level) it is biased, by log2 of the block's longer side: isotropic filters blur by that one.
//!
//! *Does*: turns such samples into calls of a function that asks `vrcs_rate()`, which the rewrite then gives its
//! [meaning](crate::graded). Where the rate is 1×1 the factor is 1 and the bias is 0: the author's own numbers.
//! *Needs*: a valid module. *Guarantees*: expressions keep their places, variables too; functions move up, in their order.
//! A helper that other entry points call, too, is changed for them as well, and for them the rate is 1×1.
//! *Refuses*: graded mode, where every pixel is shaded for itself, and samples of binding arrays.

use std::collections::BTreeSet;

use naga::{
    Arena, BinaryOperator, Expression, Function, Handle, MathFunction, Module, Range, SampleLevel,
    Scalar, Span, Statement, Type, UniqueArena,
    proc::TypeResolution,
    valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator},
};

use crate::{
    finding::{Code as FindingCode, Finding, Refusal},
    graded,
    ir::{
        build::{self, Code},
        statements::rebuild,
        visit,
    },
    options::{Mode, Options},
};

/// The module with samples of these entry points that follow the rate; `None` if the options ask for none, or no sample is
/// meant.
///
/// # Errors
/// Why that cannot be.
pub fn follow_rate(
    module: &Module,
    info: &ModuleInfo,
    entries: &[usize],
    options: &Options,
) -> Result<Option<(Module, ModuleInfo)>, Refusal> {
    if !options.scale_gradients && options.bias_level.is_empty() {
        return Ok(None);
    }
    if options.mode == Mode::Graded {
        let finding = Finding::new(
            FindingCode::UnfitOption,
            "in mode `graded` every pixel is shaded for itself, so its textures keep their detail",
        );
        return Err(finding
            .help("leave out --scale-gradients and --bias-level")
            .into());
    }
    let reachable = reachable(module, entries);
    let mut scaled = Module {
        functions: Arena::new(),
        doc_comments: None,
        ..module.clone()
    };
    // callees stand before callers
    let rate = match graded::rate_stub(module) {
        Some(stub) => scaled
            .functions
            .append(module.functions[stub].clone(), Span::UNDEFINED),
        None => {
            let stub = graded::new_rate_stub(&mut scaled.types);
            scaled.functions.append(stub, Span::UNDEFINED)
        }
    };
    let mut rewriter = Rewriter {
        module: scaled,
        options,
        rate,
        moved: Vec::with_capacity(module.functions.len()),
        count: 0,
        blocked: None,
    };
    for (handle, function) in module.functions.iter() {
        if graded::rate_stub(module) == Some(handle) {
            rewriter.moved.push(rate);
            continue;
        }
        let mut function = function.clone();
        rewriter.function(&mut function, &info[handle], reachable.contains(&handle));
        let span = module.functions.get_span(handle);
        let moved = rewriter.module.functions.append(function, span);
        rewriter.moved.push(moved);
    }
    for (index, entry) in module.entry_points.iter().enumerate() {
        let mut function = entry.function.clone();
        let is_meant = entries.contains(&index);
        rewriter.function(&mut function, info.get_entry_point(index), is_meant);
        rewriter.module.entry_points[index].function = function;
    }
    if let Some(span) = rewriter.blocked {
        let finding = Finding::new(
            FindingCode::UnfitOption,
            "a texture of a binding array is sampled, and its detail cannot follow the rate",
        );
        return Err(finding
            .at(span, "samples a binding array")
            .help("multiply its gradients by vrcs_rate() in the shader")
            .into());
    }
    if rewriter.count == 0 {
        return Ok(None);
    }
    let module = rewriter.module;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|error| {
            Finding::new(
                FindingCode::Defect,
                format!("the rewriter made a mistake: {:?}", error.into_inner()),
            )
        })?;
    Ok(Some((module, info)))
}

/// The functions that entry points may call.
fn reachable(module: &Module, entries: &[usize]) -> BTreeSet<Handle<Function>> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&Function> = entries
        .iter()
        .map(|&entry| &module.entry_points[entry].function)
        .collect();
    while let Some(function) = open.pop() {
        visit::statements(&function.body, &mut |statement| {
            if let Statement::Call { function, .. } = *statement
                && found.insert(function)
            {
                open.push(&module.functions[function]);
            }
        });
    }
    found
}

struct Rewriter<'r> {
    module: Module,
    options: &'r Options,
    /// `vrcs_rate`.
    rate: Handle<Function>,
    /// Where the author's functions are now.
    moved: Vec<Handle<Function>>,
    /// The samples that follow the rate.
    count: usize,
    /// A sample that cannot.
    blocked: Option<Span>,
}

impl Rewriter<'_> {
    fn function(&mut self, function: &mut Function, info: &FunctionInfo, is_meant: bool) {
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::CallResult(callee) = expression {
                *callee = self.moved[callee.index()];
            }
        }
        let body = std::mem::take(&mut function.body);
        function.body = rebuild(&body, &mut |_, mut statement, span, block| {
            if let Statement::Call { function, .. } = &mut statement {
                *function = self.moved[function.index()];
            }
            let Statement::Emit(range) = &statement else {
                block.push(statement, span);
                return;
            };
            // the expressions before a call, and those behind it, are emitted apart
            let mut run: Option<(Handle<Expression>, Handle<Expression>)> = None;
            for handle in range.clone() {
                let call = is_meant
                    .then(|| self.sample(function, info, handle))
                    .flatten();
                let Some((sampler, arguments)) = call else {
                    run = Some((run.map_or(handle, |(first, _)| first), handle));
                    continue;
                };
                if let Some((first, last)) = run.take() {
                    block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
                }
                function.expressions[handle] = Expression::CallResult(sampler);
                let call = Statement::Call {
                    function: sampler,
                    arguments,
                    result: Some(handle),
                };
                block.push(call, function.expressions.get_span(handle));
            }
            if let Some((first, last)) = run {
                block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
            }
        });
    }

    /// A function in the place of a sample that is to follow the rate, and its arguments.
    fn sample(
        &mut self,
        of: &Function,
        info: &FunctionInfo,
        handle: Handle<Expression>,
    ) -> Option<(Handle<Function>, Vec<Handle<Expression>>)> {
        let Expression::ImageSample {
            image,
            sampler,
            level,
            ..
        } = of.expressions[handle]
        else {
            return None;
        };
        let name = match of.expressions[image] {
            Expression::GlobalVariable(global) => self.module.global_variables[global].name.clone(),
            _ => None,
        };
        let is_meant = match level {
            SampleLevel::Gradient { .. } => self.options.scale_gradients,
            SampleLevel::Exact(_) => name
                .as_deref()
                .is_some_and(|name| self.options.bias_level.contains(name)),
            SampleLevel::Auto | SampleLevel::Zero | SampleLevel::Bias(_) => false,
        };
        if !is_meant {
            return None;
        }
        let is_whole = |handle: Handle<Expression>| {
            matches!(
                of.expressions[handle],
                Expression::GlobalVariable(_) | Expression::FunctionArgument(_)
            )
        };
        if !is_whole(image) || !is_whole(sampler) {
            self.blocked = self.blocked.or(Some(of.expressions.get_span(handle)));
            return None;
        }
        self.count += 1;
        let name = format!("vrcs_sample_{}", name.as_deref().unwrap_or("texture"));
        Some(self.write(&name, of, info, handle))
    }

    /// Writes the function.
    fn write(
        &mut self,
        name: &str,
        of: &Function,
        info: &FunctionInfo,
        handle: Handle<Expression>,
    ) -> (Handle<Function>, Vec<Handle<Expression>>) {
        let sample = &of.expressions[handle];
        let mut arguments = Vec::new();
        let mut inside = Vec::new();
        visit::operands(sample, &mut |&operand| inside.push(operand));
        let offset = match sample {
            Expression::ImageSample { offset, .. } => *offset,
            _ => None,
        };
        for &operand in &inside {
            let is_global = matches!(of.expressions[operand], Expression::GlobalVariable(_));
            if !is_global && Some(operand) != offset && !arguments.contains(&operand) {
                arguments.push(operand);
            }
        }
        let types = &mut self.module.types;
        let typed: Vec<Handle<Type>> = arguments.iter().map(|&a| type_of(types, info, a)).collect();
        let result = type_of(types, info, handle);
        let names = arguments.iter().map(|&argument| role(sample, argument));
        let named: Vec<_> = names.zip(typed).collect();
        let (mut function, own) = build::function(name, &named, Some(result));
        // the levels of a depth texture are whole
        let of_level = match sample {
            Expression::ImageSample {
                level: SampleLevel::Exact(level),
                ..
            } => info[*level].ty.inner_with(&self.module.types).scalar(),
            _ => None,
        };
        let mut code = Code::new(&mut self.module.types, &mut function, Span::UNDEFINED);
        let mut copy = sample.clone();
        visit::operands_mut(&mut copy, &mut |operand| {
            *operand = match arguments.iter().position(|argument| argument == operand) {
                Some(index) => own[index],
                None => constant(&mut code, of, *operand),
            };
        });
        let rate = code.value_of(self.rate, Vec::new());
        if let Expression::ImageSample { level, .. } = &mut copy {
            *level = follow(&mut code, *level, rate, of_level.unwrap_or(Scalar::F32));
        }
        let value = code.add_at(copy, of.expressions.get_span(handle));
        code.push(Statement::Return { value: Some(value) });
        function.body = code.finish();
        let made = self.module.functions.append(function, Span::UNDEFINED);
        (made, arguments)
    }
}

/// The level of a sample at a rate.
fn follow(
    code: &mut Code,
    level: SampleLevel,
    rate: Handle<Expression>,
    of_level: Scalar,
) -> SampleLevel {
    match level {
        SampleLevel::Gradient { x, y } => {
            let rate = code.convert(rate, Scalar::F32);
            let [width, height] = [0, 1].map(|axis| code.at(rate, axis));
            SampleLevel::Gradient {
                x: code.binary(BinaryOperator::Multiply, x, width),
                y: code.binary(BinaryOperator::Multiply, y, height),
            }
        }
        SampleLevel::Exact(level) => {
            let [width, height] = [0, 1].map(|axis| code.at(rate, axis));
            let longer = code.add(Expression::Math {
                fun: MathFunction::Max,
                arg: width,
                arg1: Some(height),
                arg2: None,
                arg3: None,
            });
            let bias = code.math1(MathFunction::FirstLeadingBit, longer);
            let bias = match of_level {
                Scalar::U32 => bias,
                other => code.convert(bias, other),
            };
            SampleLevel::Exact(code.binary(BinaryOperator::Add, level, bias))
        }
        other => other,
    }
}

/// A constant of another function, or a resource, written anew.
fn constant(code: &mut Code, of: &Function, handle: Handle<Expression>) -> Handle<Expression> {
    let mut copy = of.expressions[handle].clone();
    visit::operands_mut(&mut copy, &mut |operand| {
        *operand = constant(code, of, *operand)
    });
    code.add(copy)
}

fn type_of(
    types: &mut UniqueArena<Type>,
    info: &FunctionInfo,
    handle: Handle<Expression>,
) -> Handle<Type> {
    match &info[handle].ty {
        TypeResolution::Handle(handle) => *handle,
        TypeResolution::Value(inner) => build::intern(types, inner.clone()),
    }
}

/// What an operand is to a sample.
fn role(sample: &Expression, operand: Handle<Expression>) -> &'static str {
    let Expression::ImageSample {
        image,
        sampler,
        coordinate,
        array_index,
        depth_ref,
        level,
        ..
    } = *sample
    else {
        unreachable!("only samples are written anew");
    };
    match level {
        _ if operand == image => "texture",
        _ if operand == sampler => "filter",
        _ if operand == coordinate => "at",
        _ if Some(operand) == array_index => "layer",
        _ if Some(operand) == depth_ref => "reference",
        SampleLevel::Gradient { x, .. } if operand == x => "dx",
        SampleLevel::Gradient { .. } => "dy",
        _ => "level",
    }
}
