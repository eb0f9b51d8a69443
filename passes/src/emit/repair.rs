//! Puts back into written WGSL what naga's writer leaves out: names that end in a digit, struct layouts, workgroup sizes,
//! initialisers and lengths of arrays that are computed from overrides, `enable subgroups;`.
//!
//! *Needs*: text as naga 30 writes it: no comments, one struct member a line, one declaration a line, in the order of the
//! module's arenas. The [audit](super::audit) finds out if a later naga writes otherwise.

use std::collections::{HashMap, HashSet};

use naga::{
    Function, Handle, Module, ShaderStage, Statement, Type, TypeInner,
    proc::{Alignment, Layouter},
};

use super::{
    EmitError,
    constant::{self, Initialised, LeftOut},
    lengths::{self, Length},
};
use crate::{input::Directives, ir::visit};

/// Repairs written text.
pub(super) fn repair(
    text: String,
    module: &Module,
    left_out: &[LeftOut],
    lengths: &[Length],
) -> Result<String, EmitError> {
    let text = restore_names(text, module);
    let gaps = layout_gaps(module)?;
    let names = override_names(&text);
    let override_name = |index: usize| names.get(index).cloned().unwrap_or_default();
    let mut out = String::with_capacity(text.len());
    if uses_subgroups(module) {
        out.push_str("enable subgroups;\n\n");
    }
    let mut structs = written_structs(module).into_iter();
    let mut overrides = module.overrides.iter();
    let mut globals = 0..module.global_variables.len();
    let mut entries = module.entry_points.iter();
    let mut members: Option<(Handle<Type>, usize)> = None;
    for line in text.lines() {
        let mut line = line.to_owned();
        if line.starts_with("struct ") {
            members = structs.next().map(|ty| (ty, 0));
        } else if line == "}" {
            members = None;
        } else if let Some((ty, index)) = &mut members {
            if let Some(size) = gaps.get(&(*ty, *index)) {
                line.insert_str(
                    line.len() - line.trim_start().len(),
                    &format!("@size({size}) "),
                );
            }
            *index += 1;
        } else if is_declaration(&line, "override ") {
            let item = overrides.next();
            if item.is_some_and(|(_, item)| !lengths::is_declared(item)) {
                continue;
            }
            let of = item.map(|(handle, _)| Initialised::Override(handle.index()));
            initialise(&mut line, of, module, left_out, &override_name)?;
        } else if is_declaration(&line, "var") {
            let of = globals.next().map(Initialised::Global);
            initialise(&mut line, of, module, left_out, &override_name)?;
        } else if is_stage(&line)
            && let Some(entry) = entries.next()
            && let Some(sizes) = entry.workgroup_size_overrides
            && entry.stage == ShaderStage::Compute
            && sizes.iter().any(Option::is_some)
        {
            let mut written = Vec::with_capacity(3);
            for (axis, size) in sizes.iter().enumerate() {
                written.push(match *size {
                    Some(size) => constant::text(module, size, &override_name)?,
                    None => entry.workgroup_size[axis].to_string(),
                });
            }
            line = format!("@compute @workgroup_size({}) ", written.join(", "));
        }
        lengths::put(&mut line, lengths, module, &override_name)?;
        out.push_str(line.trim_end());
        out.push('\n');
    }
    Ok(out)
}

/// Puts the author's directives at the head of a text, where they are not there yet.
pub(super) fn put_directives(text: String, directives: &Directives) -> String {
    let there = Directives::of(&text);
    let mut head = String::new();
    for (keyword, wanted, there) in [
        ("enable", &directives.enables, &there.enables),
        ("requires", &directives.requires, &there.requires),
    ] {
        for name in wanted.iter().filter(|name| !there.contains(name)) {
            head.push_str(&format!("{keyword} {name};\n"));
        }
    }
    for rule in &directives.diagnostics {
        head.push_str(&format!("diagnostic({rule});\n"));
    }
    head + &text
}

/// The structs that naga writes, in order.
pub(super) fn written_structs(module: &Module) -> Vec<Handle<Type>> {
    let special = &module.special_types;
    module
        .types
        .iter()
        .filter(|(_, ty)| matches!(ty.inner, TypeInner::Struct { .. }))
        .map(|(handle, _)| handle)
        .filter(|handle| {
            !special.predeclared_types.values().any(|ty| ty == handle)
                && Some(*handle) != special.external_texture_params
                && Some(*handle) != special.external_texture_transfer_function
        })
        .collect()
}

fn is_declaration(line: &str, keyword: &str) -> bool {
    // attributes may stand in front, on the same line
    let after_attributes = |mut line: &str| -> bool {
        while let Some(rest) = line.strip_prefix('@') {
            let Some(end) = rest.find(' ') else {
                return false;
            };
            line = rest[end..].trim_start();
        }
        match keyword {
            "var" => line.starts_with("var<") || line.starts_with("var "),
            keyword => line.starts_with(keyword),
        }
    };
    !line.starts_with(' ') && after_attributes(line)
}

fn is_stage(line: &str) -> bool {
    ["@compute", "@vertex", "@fragment", "@task", "@mesh", "@ray"]
        .iter()
        .any(|stage| line.starts_with(stage))
}

fn initialise(
    line: &mut String,
    of: Option<Initialised>,
    module: &Module,
    left_out: &[LeftOut],
    override_name: &dyn Fn(usize) -> String,
) -> Result<(), EmitError> {
    let Some(left_out) = left_out.iter().find(|left_out| Some(left_out.of) == of) else {
        return Ok(());
    };
    let value = constant::text(module, left_out.init, override_name)?;
    if let Some(at) = line.rfind(';') {
        line.insert_str(at, &format!(" = {value}"));
    }
    Ok(())
}

/// The names of the overrides as the text has them, in order.
fn override_names(text: &str) -> Vec<String> {
    text.lines()
        .filter(|line| is_declaration(line, "override "))
        .filter_map(|line| {
            let (_, after) = line.split_once("override ")?;
            let end = after.find([':', ';', ' ', '='])?;
            Some(after[..end].to_owned())
        })
        .collect()
}

/// For each struct member that is followed by more room than WGSL's rules would leave: the size that it has to claim.
fn layout_gaps(module: &Module) -> Result<HashMap<(Handle<Type>, usize), u32>, EmitError> {
    let mut layouter = Layouter::default();
    layouter
        .update(module.to_ctx())
        .map_err(|error| EmitError::Writer(error.to_string()))?;
    let mut gaps = HashMap::new();
    for ty in written_structs(module) {
        let TypeInner::Struct { ref members, span } = module.types[ty].inner else {
            continue;
        };
        let mut alignment = Alignment::ONE;
        for (index, member) in members.iter().enumerate() {
            let layout = layouter[member.ty];
            alignment = alignment.max(layout.alignment);
            let end = member.offset + layout.size;
            let (natural, actual) = match members.get(index + 1) {
                Some(next) => (layouter[next.ty].alignment.round_up(end), next.offset),
                None => (alignment.round_up(end), span),
            };
            let is_sized = !matches!(
                module.types[member.ty].inner,
                TypeInner::Array {
                    size: naga::ArraySize::Dynamic,
                    ..
                }
            );
            if natural != actual && is_sized && actual > member.offset {
                gaps.insert((ty, index), actual - member.offset);
            }
        }
    }
    Ok(gaps)
}

/// naga writes `name1_` for `name1`, and `step_` for `step`; gives names back their own form where nothing else is called so.
fn restore_names(text: String, module: &Module) -> String {
    let mut wanted = HashSet::new();
    let mut want = |name: Option<&String>| {
        if let Some(name) = name
            && name.ends_with(|c: char| c.is_ascii_digit())
        {
            wanted.insert(name.clone());
        }
    };
    for (_, ty) in module.types.iter() {
        want(ty.name.as_ref());
        if let TypeInner::Struct { members, .. } = &ty.inner {
            members.iter().for_each(|member| want(member.name.as_ref()));
        }
    }
    module
        .constants
        .iter()
        .for_each(|(_, c)| want(c.name.as_ref()));
    module
        .global_variables
        .iter()
        .for_each(|(_, g)| want(g.name.as_ref()));
    let mut want_function = |function: &Function| {
        want(function.name.as_ref());
        function
            .arguments
            .iter()
            .for_each(|a| want(a.name.as_ref()));
        function
            .local_variables
            .iter()
            .for_each(|(_, l)| want(l.name.as_ref()));
        function
            .named_expressions
            .values()
            .for_each(|name| want(Some(name)));
    };
    module.functions.iter().for_each(|(_, f)| want_function(f));
    module.entry_points.iter().for_each(|entry| {
        want_function(&entry.function);
    });
    // what the program that runs the shader calls it by; an author may call it as a built-in function is called, too
    let outside = module.overrides.iter().filter_map(|(_, o)| o.name.as_ref());
    wanted.extend(outside.cloned());
    wanted.extend(module.entry_points.iter().map(|entry| entry.name.clone()));
    let present: HashSet<&str> = identifiers(&text).map(|(_, word)| word).collect();
    wanted.retain(|name| {
        !present.contains(name.as_str()) && present.contains(format!("{name}_").as_str())
    });
    if wanted.is_empty() {
        return text;
    }
    let mut out = String::with_capacity(text.len());
    let mut copied = 0;
    for (at, word) in identifiers(&text) {
        if let Some(name) = word.strip_suffix('_')
            && wanted.contains(name)
        {
            out.push_str(&text[copied..at]);
            out.push_str(name);
            copied = at + word.len();
        }
    }
    out.push_str(&text[copied..]);
    out
}

/// The words of a text that could be identifiers, with their places.
fn identifiers(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    text.split(move |c: char| !is_word(c))
        .filter(|word| word.starts_with(|c: char| c.is_alphabetic() || c == '_'))
        .map(|word| (word.as_ptr() as usize - text.as_ptr() as usize, word))
}

/// Whether a module needs `enable subgroups;`.
pub(super) fn uses_subgroups(module: &Module) -> bool {
    let is_subgroup = |binding: &Option<naga::Binding>| {
        use naga::BuiltIn as B;
        matches!(
            binding.as_ref().and_then(naga::Binding::to_built_in),
            Some(B::NumSubgroups | B::SubgroupId | B::SubgroupSize | B::SubgroupInvocationId)
        )
    };
    let mut found = false;
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    for function in functions.chain(entries) {
        found |= function.arguments.iter().any(|argument| {
            is_subgroup(&argument.binding)
                || match &module.types[argument.ty].inner {
                    TypeInner::Struct { members, .. } => {
                        members.iter().any(|member| is_subgroup(&member.binding))
                    }
                    _ => false,
                }
        });
        visit::statements(&function.body, &mut |statement| {
            found |= matches!(
                statement,
                Statement::SubgroupBallot { .. }
                    | Statement::SubgroupGather { .. }
                    | Statement::SubgroupCollectiveOperation { .. }
            );
        });
    }
    found
}
