//! SPIR-V as compilers write it, made into what naga's front end takes, and what that front end leaves out.
//!
//! *Does*: takes out what says nothing of what a shader does but stops naga: lines (`OpLine` between types), instruction sets whose
//! names say that they are not semantic, and workgroup sizes given by ids (`OpExecutionModeId`); keeps the lines, so that messages
//! point into the GLSL or HLSL that the module was compiled from, and the workgroup sizes, also those that
//! `BuiltIn WorkgroupSize` gives, which naga passes over and which go before `LocalSize` (SPIR-V specification, 3.21). What is computed
//! from specialisation constants outside functions (`OpSpecConstantOp`, composites, one constant twice) is computed in the functions that use it: naga
//! has overrides, but no constants made of them.
//! *Guarantees*: bytes that are no SPIR-V, or are cut, are passed on as they are: naga says what is wrong with them.
//! *Refuses*: combined image samplers, which naga has none of, by their names.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    ops::Range,
};

use naga::{Expression, Module, ShaderStage, Span};

use crate::source::Source;

const MAGIC: u32 = 0x0723_0203;
const HEADER: usize = 5;

/// The instructions that are looked at, by their numbers.
mod op {
    pub const SOURCE_CONTINUED: u16 = 2;
    pub const SOURCE: u16 = 3;
    pub const NAME: u16 = 5;
    pub const STRING: u16 = 7;
    pub const LINE: u16 = 8;
    pub const EXTENSION: u16 = 10;
    pub const EXT_INST_IMPORT: u16 = 11;
    pub const EXT_INST: u16 = 12;
    pub const ENTRY_POINT: u16 = 15;
    pub const TYPE_SAMPLED_IMAGE: u16 = 27;
    pub const TYPE_ARRAY: u16 = 28;
    pub const TYPE_RUNTIME_ARRAY: u16 = 29;
    pub const TYPE_POINTER: u16 = 32;
    pub const CONSTANT: u16 = 43;
    pub const CONSTANT_COMPOSITE: u16 = 44;
    pub const SPEC_CONSTANT: u16 = 50;
    pub const SPEC_CONSTANT_COMPOSITE: u16 = 51;
    pub const SPEC_CONSTANT_OP: u16 = 52;
    pub const FUNCTION: u16 = 54;
    pub const FUNCTION_PARAMETER: u16 = 55;
    pub const FUNCTION_END: u16 = 56;
    pub const VARIABLE: u16 = 59;
    pub const DECORATE: u16 = 71;
    pub const COMPOSITE_CONSTRUCT: u16 = 80;
    pub const COPY_OBJECT: u16 = 83;
    pub const BITCAST: u16 = 124;
    pub const LABEL: u16 = 248;
    pub const NO_LINE: u16 = 317;
    pub const EXECUTION_MODE_ID: u16 = 331;
}

const DECORATION_SPEC_ID: u32 = 1;
const DECORATION_BUILT_IN: u32 = 11;
const BUILT_IN_WORKGROUP_SIZE: u32 = 25;
const MODE_LOCAL_SIZE_ID: u32 = 38;
const MODEL_GL_COMPUTE: u32 = 5;
/// Of `NonSemantic.Shader.DebugInfo.100`: where a text is, and what was compiled from it.
const DEBUG_SOURCE: u32 = 35;
const DEBUG_LINE: u32 = 103;
const DEBUG_NO_LINE: u32 = 104;

/// A module, ready for naga.
pub(super) struct Prepared {
    /// What naga is given.
    pub bytes: Vec<u8>,
    /// The text that spans into `bytes` lead to.
    pub source: Source,
    /// The names of the combined image samplers.
    pub combined: Vec<String>,
    sizes: Sizes,
}

/// A side of a workgroup.
#[derive(Clone, Copy)]
enum Side {
    Number(u32),
    /// The specialisation constant of this number, and its default.
    Constant(u32, u32),
}

/// Workgroup sizes that naga does not read.
#[derive(Default)]
struct Sizes {
    /// Of every entry point.
    all: Option<[Side; 3]>,
    /// Of single ones, by name.
    each: HashMap<String, [Side; 3]>,
}

struct Instruction<'w> {
    op: u16,
    /// All its words, the one with its number and length included.
    words: &'w [u32],
}

/// The instructions of a module up to the first that is cut.
fn instructions(words: &[u32]) -> impl Iterator<Item = Instruction<'_>> {
    let mut left = words.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *left.first()?;
        let length = (first >> 16) as usize;
        if length == 0 || length > left.len() {
            return None;
        }
        let (words, rest) = left.split_at(length);
        left = rest;
        Some(Instruction {
            op: first as u16,
            words,
        })
    })
}

/// A literal string, and the words behind it.
fn string(words: &[u32]) -> (String, &[u32]) {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let text = String::from_utf8_lossy(&bytes[..end]).into_owned();
    (text, words.get(end / 4 + 1..).unwrap_or_default())
}

/// Makes a module ready for naga.
pub(super) fn prepare(name: &str, bytes: &[u8]) -> Prepared {
    let words: Vec<u32> = bytes
        .chunks_exact(4)
        .map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]))
        .collect();
    let whole = instructions(&words).map(|i| i.words.len()).sum::<usize>() + HEADER == words.len();
    if words.first() != Some(&MAGIC) || !whole || !bytes.len().is_multiple_of(4) {
        return Prepared {
            bytes: bytes.to_vec(),
            source: Source::new(name, ""),
            combined: Vec::new(),
            sizes: Sizes::default(),
        };
    }
    let (bytes, lines) = without_debug(&words);
    Prepared {
        bytes: bytes.iter().flat_map(|word| word.to_le_bytes()).collect(),
        source: source_of(name, &words, &lines),
        combined: combined(&words),
        sizes: sizes(&words),
    }
}

/// From a byte of the module on, the file, line and column that it was compiled from; `None` where that is not known.
struct Line {
    at: usize,
    place: Option<[u32; 3]>,
}

/// The module without what says nothing of what it does, and the lines that it was compiled from.
fn without_debug(words: &[u32]) -> (Vec<u32>, Vec<Line>) {
    let moved = specialised(words);
    let used = used_by_functions(words, &moved);
    let mut functions = used.iter();
    let mut kept = words[..HEADER].to_vec();
    let mut lines: Vec<Line> = Vec::new();
    let mut silent = HashSet::new();
    let mut numbers = HashMap::new();
    // what the function needs that has not been put into its first block yet
    let mut due: Vec<&Vec<u32>> = Vec::new();
    let mut is_in_block = false;
    for Instruction { op, words } in instructions(words) {
        let mut at_line = |at: usize, place| match lines.last_mut() {
            Some(last) if last.at == at * 4 => last.place = place,
            _ => lines.push(Line { at: at * 4, place }),
        };
        match (op, words) {
            (op::LINE, &[_, file, line, column]) => {
                at_line(kept.len(), Some([file, line, column]));
                continue;
            }
            (op::NO_LINE, _) => {
                at_line(kept.len(), None);
                continue;
            }
            (op::EXT_INST_IMPORT, &[_, id, ref name @ ..])
                if string(name).0.starts_with("NonSemantic.") =>
            {
                silent.insert(id);
                continue;
            }
            (op::EXT_INST, &[_, _, _, set, number, ref operands @ ..]) if silent.contains(&set) => {
                let number_of = |id: &u32| numbers.get(id).copied();
                match (number, operands) {
                    (DEBUG_LINE, [file, line, _, column, ..]) => {
                        let place = number_of(line).zip(number_of(column));
                        at_line(
                            kept.len(),
                            place.map(|(line, column)| [*file, line, column]),
                        );
                    }
                    (DEBUG_NO_LINE, _) => at_line(kept.len(), None),
                    _ => {}
                }
                continue;
            }
            (op::EXTENSION, [_, name @ ..]) if string(name).0 == "SPV_KHR_non_semantic_info" => {
                continue;
            }
            (op::EXECUTION_MODE_ID, &[_, _, MODE_LOCAL_SIZE_ID, ..]) => continue,
            (
                op::SPEC_CONSTANT | op::SPEC_CONSTANT_COMPOSITE | op::SPEC_CONSTANT_OP,
                &[_, _, id, ..],
            ) if moved.iter().any(|(other, _)| *other == id) => {
                continue;
            }
            (op::CONSTANT, &[_, _, id, value]) => {
                numbers.insert(id, value);
            }
            (op::FUNCTION, _) => {
                let used = functions.next();
                due = (moved.iter())
                    .filter(|(id, _)| used.is_some_and(|used| used.contains(id)))
                    .map(|(_, instruction)| instruction)
                    .collect();
                is_in_block = false;
            }
            (op::FUNCTION_PARAMETER | op::VARIABLE, _) => {}
            _ if is_in_block => due.drain(..).for_each(|due| kept.extend_from_slice(due)),
            _ => {}
        }
        is_in_block |= op == op::LABEL;
        kept.extend_from_slice(words);
        // a line would end with its block; glslang does not say it again, though, where the next block goes on with it
        if op == op::FUNCTION_END {
            at_line(kept.len(), None);
        }
    }
    (kept, lines)
}

/// What is computed from specialisation constants outside functions: its id, and the instruction that computes it inside one.
fn specialised(words: &[u32]) -> Vec<(u32, Vec<u32>)> {
    let mut spec = HashSet::new();
    let mut numbers = HashMap::new();
    let mut firsts: HashMap<u32, (u32, u32)> = HashMap::new();
    let mut moved: Vec<(u32, Vec<u32>)> = Vec::new();
    for Instruction { op, words } in instructions(words) {
        let first = |length: usize, op: u16| ((length as u32) << 16) | u32::from(op);
        match (op, words) {
            (op::DECORATE, &[_, id, DECORATION_SPEC_ID, number]) => {
                numbers.insert(id, number);
            }
            (op::SPEC_CONSTANT, &[_, ty, id, ..]) => {
                spec.insert(id);
                let Some(&number) = numbers.get(&id) else {
                    continue;
                };
                // one number twice, as `local_size_x_id` and `constant_id`: naga has an override for each
                match firsts.get(&number) {
                    Some(&(of, first_id)) => {
                        let op = match of == ty {
                            true => op::COPY_OBJECT,
                            false => op::BITCAST,
                        };
                        moved.push((id, vec![first(4, op), ty, id, first_id]));
                    }
                    None => {
                        firsts.insert(number, (ty, id));
                    }
                }
            }
            (op::SPEC_CONSTANT_COMPOSITE, &[_, ty, id, ref parts @ ..])
                if parts.iter().any(|part| spec.contains(part)) =>
            {
                spec.insert(id);
                let mut instruction = vec![first(words.len(), op::COMPOSITE_CONSTRUCT), ty, id];
                instruction.extend_from_slice(parts);
                moved.push((id, instruction));
            }
            (op::SPEC_CONSTANT_OP, &[_, ty, id, of, ref operands @ ..]) => {
                spec.insert(id);
                let mut instruction = vec![first(words.len() - 1, of as u16), ty, id];
                instruction.extend_from_slice(operands);
                moved.push((id, instruction));
            }
            (op::FUNCTION, _) => break,
            _ => {}
        }
    }
    moved
}

/// For each function, which of what is `moved` it needs. A word that only happens to be the same number counts: that is a value
/// too many, which nobody reads.
fn used_by_functions(words: &[u32], moved: &[(u32, Vec<u32>)]) -> Vec<HashSet<u32>> {
    let mut functions: Vec<HashSet<u32>> = Vec::new();
    for Instruction { op, words } in instructions(words) {
        if op == op::FUNCTION {
            functions.push(HashSet::new());
        }
        if let Some(function) = functions.last_mut() {
            let ids = moved.iter().map(|(id, _)| *id);
            function.extend(ids.filter(|id| words[1..].contains(id)));
        }
    }
    for function in &mut functions {
        for (id, instruction) in moved.iter().rev() {
            if function.contains(id) {
                let needed = moved.iter().map(|(id, _)| *id);
                function.extend(needed.filter(|needed| instruction[3..].contains(needed)));
            }
        }
    }
    functions
}

/// The files that lines are of, as far as the module carries their text.
fn source_of(name: &str, words: &[u32], lines: &[Line]) -> Source {
    let mut source = Source::new(name, "");
    let mut names: HashMap<u32, String> = HashMap::new();
    let mut texts: HashMap<u32, String> = HashMap::new();
    let mut last = None;
    for Instruction { op, words } in instructions(words) {
        match (op, words) {
            (op::STRING, &[_, id, ref text @ ..]) => {
                names.insert(id, string(text).0);
            }
            (op::SOURCE, &[_, _, _, file, ref text @ ..]) => {
                last = Some(file);
                texts.insert(file, string(text).0);
            }
            (op::EXT_INST, &[_, _, id, _, DEBUG_SOURCE, file, ref text @ ..]) => {
                // the ids of strings, which come before
                let text = text.first().and_then(|text| names.get(text)).cloned();
                if let Some(name) = names.get(&file).cloned() {
                    names.insert(id, name);
                }
                texts.insert(id, text.unwrap_or_default());
            }
            (op::SOURCE_CONTINUED, [_, text @ ..]) => {
                if let Some(known) = last.and_then(|file| texts.get_mut(&file)) {
                    known.push_str(&string(text).0);
                }
            }
            _ => {}
        }
    }
    // the last line of each file: one that the module does not carry is as many empty lines
    let mut most: BTreeMap<u32, u32> = BTreeMap::new();
    for [file, line, _] in lines.iter().filter_map(|line| line.place) {
        let most = most.entry(file).or_default();
        *most = (*most).max(line);
    }
    let mut files = HashMap::new();
    for (file, most) in most {
        let Some(name) = names.get(&file) else {
            continue;
        };
        let text = texts.remove(&file).unwrap_or_default();
        let text = without_head(&text);
        let text = match text.is_empty() {
            true => "\n".repeat((most as usize).min(1 << 20)),
            false => text.to_owned(),
        };
        let ranges = line_ranges(&text);
        files.insert(file, (source.add_file(name, text), ranges));
    }
    for line in lines {
        let place = line.place.and_then(|[file, line, column]| {
            let (file, ranges) = files.get(&file)?;
            let range = ranges.get(line.checked_sub(1)? as usize)?;
            let start = range.start + (column as usize).saturating_sub(1);
            let start = match (range.start..=range.end).contains(&start) {
                true => start,
                false => range.start,
            };
            Some((*file, start..range.end))
        });
        let (file, range) = place.unwrap_or((0, 0..0));
        source.stand_for(line.at, file, range);
    }
    source
}

/// The text behind what glslang puts before it: how it was called, and `#line 1`.
fn without_head(text: &str) -> &str {
    const HEAD: &str = "// OpModuleProcessed ";
    match text.starts_with(HEAD) {
        true => text.split_once("#line 1\n").map_or(text, |(_, rest)| rest),
        false => text,
    }
}

/// The lines of a text, without the white space around them.
fn line_ranges(text: &str) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut ranges = Vec::new();
    for line in text.split_inclusive('\n') {
        let words = line.trim();
        let before = line.len() - line.trim_start().len();
        let from = match words.is_empty() {
            true => start,
            false => start + before,
        };
        ranges.push(from..from + words.len());
        start += line.len();
    }
    ranges
}

/// The names of the variables that are combined image samplers, or arrays of them.
fn combined(words: &[u32]) -> Vec<String> {
    let mut names: HashMap<u32, String> = HashMap::new();
    let mut types = HashSet::new();
    let mut found = Vec::new();
    for Instruction { op, words } in instructions(words) {
        match (op, words) {
            (op::NAME, &[_, id, ref name @ ..]) => {
                names.insert(id, string(name).0);
            }
            (op::TYPE_SAMPLED_IMAGE, &[_, id, ..]) => {
                types.insert(id);
            }
            (op::TYPE_ARRAY | op::TYPE_RUNTIME_ARRAY, &[_, id, of, ..])
            | (op::TYPE_POINTER, &[_, id, _, of])
                if types.contains(&of) =>
            {
                types.insert(id);
            }
            (op::VARIABLE, &[_, ty, id, ..]) if types.contains(&ty) => {
                let name = names.get(&id).filter(|name| !name.is_empty());
                found.push(name.cloned().unwrap_or_else(|| format!("%{id}")));
            }
            _ => {}
        }
    }
    found
}

/// The workgroup sizes that naga does not read.
fn sizes(words: &[u32]) -> Sizes {
    let mut sizes = Sizes::default();
    let mut entries: HashMap<u32, Vec<String>> = HashMap::new();
    let mut spec_ids: HashMap<u32, u32> = HashMap::new();
    let mut sides: HashMap<u32, Side> = HashMap::new();
    let mut modes = Vec::new();
    let mut built_in = None;
    for Instruction { op, words } in instructions(words) {
        match (op, words) {
            (op::ENTRY_POINT, &[_, MODEL_GL_COMPUTE, function, ref name @ ..]) => {
                entries.entry(function).or_default().push(string(name).0);
            }
            (op::EXECUTION_MODE_ID, &[_, function, MODE_LOCAL_SIZE_ID, x, y, z]) => {
                modes.push((function, [x, y, z]));
            }
            (op::DECORATE, &[_, id, DECORATION_SPEC_ID, number]) => {
                spec_ids.insert(id, number);
            }
            (op::DECORATE, &[_, id, DECORATION_BUILT_IN, BUILT_IN_WORKGROUP_SIZE]) => {
                built_in = Some(id);
            }
            (op::CONSTANT | op::SPEC_CONSTANT, &[_, _, id, value]) => {
                let side = match spec_ids.get(&id) {
                    Some(&number) => Side::Constant(number, value),
                    None => Side::Number(value),
                };
                sides.insert(id, side);
            }
            (op::CONSTANT_COMPOSITE | op::SPEC_CONSTANT_COMPOSITE, &[_, _, id, x, y, z])
                if Some(id) == built_in =>
            {
                sizes.all = all_of([x, y, z], &sides);
            }
            _ => {}
        }
    }
    for (function, ids) in modes {
        if let (Some(names), Some(size)) = (entries.get(&function), all_of(ids, &sides)) {
            sizes
                .each
                .extend(names.iter().map(|name| (name.clone(), size)));
        }
    }
    sizes
}

fn all_of(ids: [u32; 3], sides: &HashMap<u32, Side>) -> Option<[Side; 3]> {
    let [x, y, z] = ids.map(|id| sides.get(&id).copied());
    Some([x?, y?, z?])
}

impl Prepared {
    /// Gives the entry points of the module that naga made of this the workgroup sizes that naga did not read.
    pub(super) fn size_groups(&self, module: &mut Module) {
        for entry in &mut module.entry_points {
            if entry.stage != ShaderStage::Compute {
                continue;
            }
            let Some(size) = self.sizes.all.or(self.sizes.each.get(&entry.name).copied()) else {
                continue;
            };
            let mut overrides = [None; 3];
            for axis in 0..3 {
                entry.workgroup_size[axis] = match size[axis] {
                    Side::Number(number) => number,
                    Side::Constant(number, value) => {
                        let known = module
                            .overrides
                            .iter()
                            .find(|(_, item)| item.id.map(u32::from) == Some(number));
                        match known {
                            Some((handle, _)) => {
                                let expression = Expression::Override(handle);
                                let expression = module
                                    .global_expressions
                                    .append(expression, Span::UNDEFINED);
                                overrides[axis] = Some(expression);
                                1
                            }
                            None => value,
                        }
                    }
                };
            }
            entry.workgroup_size_overrides =
                overrides.iter().any(Option::is_some).then_some(overrides);
        }
    }
}
