//! Several files as one shader: files joined in order, naga_oil's conditions and imports resolved.
//!
//! *Does*: preprocesses each file; finds the modules that are imported, modules of modules included; gives each
//! thing of a module a name that nothing else in the text has; and joins it all, modules first.
//! *Guarantees*: every byte of the joined text is led back to the file and place that it stands for. A name of a module
//! neither hides a name of another file nor a built-in function that another file calls.
//! *Refuses*: imports of what there is not, virtual functions and their overrides.
//!
//! The syntax is naga_oil's. Its composer is not used: its modules carry spans into a text of its own, with headers in front
//! and longer names in it, which cannot be led back; it forbids names that end in digits in modules; and it loses workgroup
//! sizes that overrides decide.

mod imports;
mod preprocess;
mod tokens;

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, btree_map::Entry},
    ops::Range,
};

use imports::Import;
pub use preprocess::Defines;
use preprocess::{Part, Preprocessed};
use tokens::{Token, Word};

use super::directives;
use crate::source::Source;

/// Whether a text has to be composed before it can be parsed.
pub fn has_commands(text: &str) -> bool {
    preprocess::has_commands(text)
}

/// The name under which a file can be imported, if it has one: its `#define_import_path`.
pub fn import_path(text: &str) -> Option<String> {
    if !text.contains("define_import_path") {
        return None;
    }
    let bare = tokens::without_comments(text);
    bare.lines().find_map(|line| {
        let rest = line.trim_start().strip_prefix('#')?.trim_start();
        let path = rest.strip_prefix("define_import_path")?;
        Some(path.trim().trim_end_matches(';').to_owned())
    })
}

/// What is wrong with a file.
#[derive(Debug)]
pub(super) struct Problem {
    pub(super) file: usize,
    pub(super) range: Range<usize>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

impl Problem {
    fn at(file: usize, range: Range<usize>, message: String) -> Problem {
        Problem {
            file,
            range,
            message,
            help: None,
        }
    }

    fn help(mut self, help: impl Into<String>) -> Problem {
        self.help = Some(help.into());
        self
    }
}

/// A file on its way into the joined text.
struct Unit<'t> {
    text: &'t str,
    /// Its name in imports; the shader's own files may have none.
    name: String,
    preprocessed: Preprocessed,
    /// Its tokens that count, in order.
    tokens: Vec<Token>,
    /// What it declares.
    items: BTreeSet<String>,
    /// The members of its structs, by where they are declared.
    members: BTreeSet<usize>,
}

/// Joins files in order; `modules` can be imported.
///
/// Tells, too, whether a module was needed. The files of the result are `files`, then `modules`, so that problems can be
/// rendered even where there is no text.
pub(super) fn compose(
    files: &[(String, String)],
    modules: &[(String, String)],
    defines: &Defines,
) -> Result<(Source, bool), Box<(Source, Problem)>> {
    let mut source = Source::default();
    for (name, text) in files.iter().chain(modules) {
        source.add_file(name.clone(), text.clone());
    }
    let all: Vec<&(String, String)> = files.iter().chain(modules).collect();
    let linked = Linker::new(&all, files.len(), defines.clone())
        .and_then(|linker| Ok((linker.link()?, linker.order.len() > linker.own)));
    match linked {
        Ok((parts, has_modules)) => {
            for part in parts {
                match part {
                    Placed::Kept(file, range) => source.keep(file, range),
                    Placed::Replaced(file, range, words) => source.replace(file, range, &words),
                }
            }
            Ok((source, has_modules))
        }
        Err(problem) => Err(Box::new((source, problem))),
    }
}

/// A part of the joined text.
enum Placed {
    Kept(usize, Range<usize>),
    Replaced(usize, Range<usize>, String),
}

struct Linker<'t> {
    /// How many of the files are the shader's own.
    own: usize,
    units: BTreeMap<usize, Unit<'t>>,
    by_name: HashMap<String, usize>,
    /// The modules that are imported, those they need before them, then the shader's own files.
    order: Vec<usize>,
}

impl<'t> Linker<'t> {
    fn new(
        all: &[&'t (String, String)],
        own: usize,
        mut defines: Defines,
    ) -> Result<Linker<'t>, Problem> {
        let mut linker = Linker {
            own,
            units: BTreeMap::new(),
            by_name: HashMap::new(),
            order: Vec::new(),
        };
        for (index, (name, text)) in all.iter().enumerate().skip(own) {
            if let Some(path) = import_path(text) {
                linker.by_name.entry(path).or_insert(index);
            }
            linker
                .by_name
                .entry(name.replace('\\', "/"))
                .or_insert(index);
        }
        let mut wanted = Vec::new();
        for (index, (_, text)) in all.iter().enumerate().take(own) {
            let unit = Unit::new(text, index, &mut defines)?;
            linker.units.insert(index, unit);
            wanted.push(index);
        }
        // depth first, without recursion: a module is placed when all that it needs has been seen
        let mut stack: Vec<(usize, bool)> = wanted.iter().rev().map(|&i| (i, false)).collect();
        let mut seen = BTreeSet::new();
        while let Some((index, is_done)) = stack.pop() {
            if is_done {
                linker.order.push(index);
                continue;
            }
            if !seen.insert(index) {
                continue;
            }
            if let Entry::Vacant(unit) = linker.units.entry(index) {
                // what a module defines is its own
                unit.insert(Unit::new(&all[index].1, index, &mut defines.clone())?);
            }
            stack.push((index, true));
            let needed = linker.needed(index)?;
            stack.extend(needed.into_iter().rev().map(|module| (module, false)));
        }
        linker.order.sort_by_key(|&index| index < own);
        Ok(linker)
    }

    /// The modules that a file uses.
    fn needed(&self, index: usize) -> Result<BTreeSet<usize>, Problem> {
        let unit = &self.units[&index];
        let mut needed = BTreeSet::new();
        for word in unit.words() {
            if let Some((module, _)) = self.resolve(index, word)? {
                needed.insert(module);
            }
        }
        Ok(needed)
    }

    /// The module and the thing of it that a word stands for; `None` if it is a word like any other.
    fn resolve(&self, index: usize, word: &Word) -> Result<Option<(usize, String)>, Problem> {
        let unit = &self.units[&index];
        if unit.members.contains(&word.range.start) {
            return Ok(None);
        }
        let imported = unit
            .preprocessed
            .imports
            .iter()
            .rev()
            .find(|import| import.name == word.parts[0]);
        let path: Vec<&str> = match imported {
            Some(Import { path, .. }) => path
                .iter()
                .chain(&word.parts[1..])
                .map(String::as_str)
                .collect(),
            None => word.parts.iter().map(String::as_str).collect(),
        };
        let Some((&item, module)) = path.split_last() else {
            return Ok(None);
        };
        if module.is_empty() {
            return Ok(None);
        }
        let name = module.join("::");
        match self.find(&name) {
            Some(found) => Ok(Some((found, item.to_owned()))),
            None => Err(self.no_module(index, word, &name)),
        }
    }

    /// The module with a name. A file in quotes may leave folders out.
    fn find(&self, name: &str) -> Option<usize> {
        if let Some(&found) = self.by_name.get(name) {
            return Some(found);
        }
        let is_file = name.contains('.') || name.contains('/');
        let suffix = format!("/{}", name.trim_start_matches("./"));
        self.by_name
            .iter()
            .filter(|(known, _)| is_file && (known.ends_with(&suffix) || **known == suffix[1..]))
            .map(|(_, &index)| index)
            .min()
    }

    fn no_module(&self, index: usize, word: &Word, name: &str) -> Problem {
        let known: BTreeSet<&str> = self
            .by_name
            .keys()
            .filter(|known| known.contains("::") || !known.contains('.'))
            .map(String::as_str)
            .collect();
        let help = match crate::near::nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.is_empty() => {
                "give the file that has this `#define_import_path` too".to_owned()
            }
            None => format!(
                "give the file that has this `#define_import_path` too; there are {}",
                crate::near::list(known)
            ),
        };
        Problem::at(
            index,
            word.range.clone(),
            format!("there is no module `{name}`"),
        )
        .help(help)
    }

    /// The names that things of modules get in the joined text.
    fn names(&self) -> Result<HashMap<(usize, String), String>, Problem> {
        // which files say a word without meaning a module's thing
        let mut said: HashMap<&str, BTreeSet<usize>> = HashMap::new();
        for &index in &self.order {
            for word in self.units[&index].words() {
                if word.parts.len() == 1 && self.resolve(index, word)?.is_none() {
                    said.entry(&word.parts[0]).or_default().insert(index);
                }
            }
        }
        let mut taken: BTreeSet<String> = BTreeSet::new();
        let mut names = HashMap::new();
        for &index in self.order.iter().filter(|&&index| index >= self.own) {
            let unit = &self.units[&index];
            for item in &unit.items {
                let elsewhere = said
                    .get(item.as_str())
                    .is_some_and(|files| files.iter().any(|&file| file != index));
                let is_free = |name: &String| {
                    !taken.contains(name) && (name == item || !said.contains_key(name.as_str()))
                };
                let stem = unit.name.rsplit("::").next().unwrap_or_default();
                let stem: String = stem
                    .chars()
                    .map(|c| if c.is_alphanumeric() { c } else { '_' })
                    .collect();
                let name = std::iter::once(item.clone())
                    .filter(|_| !elsewhere)
                    .chain(std::iter::once(format!("{item}_{stem}")))
                    .chain((2u32..).map(|n| format!("{item}_{stem}_{n}x")))
                    .find(is_free)
                    .unwrap_or_else(|| item.clone());
                taken.insert(name.clone());
                names.insert((index, item.clone()), name);
            }
        }
        Ok(names)
    }

    fn link(&self) -> Result<Vec<Placed>, Problem> {
        let names = self.names()?;
        let mut placed = Vec::new();
        // directives go first, whichever file they stand in
        let mut written = BTreeSet::new();
        for &index in &self.order {
            for directive in directives::find(self.units[&index].text) {
                if written.insert(directive.text.clone()) {
                    let words = format!("{}\n", directive.text);
                    placed.push(Placed::Replaced(index, directive.range, words));
                }
            }
        }
        for &index in &self.order {
            self.place(index, &names, &mut placed)?;
            let end = self.units[&index].text.len();
            placed.push(Placed::Replaced(index, end..end, "\n".to_owned()));
        }
        Ok(placed)
    }

    /// Places a file's parts, names replaced, directives left out.
    fn place(
        &self,
        index: usize,
        names: &HashMap<(usize, String), String>,
        placed: &mut Vec<Placed>,
    ) -> Result<(), Problem> {
        let unit = &self.units[&index];
        let mut changes: BTreeMap<usize, (usize, String)> = BTreeMap::new();
        for word in unit.words() {
            let Range { start, end } = word.range;
            if let Some((module, item)) = self.resolve(index, word)? {
                let name = names
                    .get(&(module, item.clone()))
                    .ok_or_else(|| self.no_item(index, word, module, &item))?;
                changes.insert(start, (end, name.clone()));
            } else if index >= self.own
                && word.parts.len() == 1
                && !unit.members.contains(&start)
                && let Some(name) = names.get(&(index, word.parts[0].clone()))
                && *name != word.parts[0]
            {
                changes.insert(start, (end, name.clone()));
            }
        }
        for directive in directives::find(unit.text) {
            changes.insert(directive.range.start, (directive.range.end, String::new()));
        }
        // a directive may run over the end of its line
        let mut done = 0;
        for part in &unit.preprocessed.parts {
            match part {
                Part::Value(range, words) => {
                    placed.push(Placed::Replaced(index, range.clone(), words.clone()));
                }
                Part::Text(range) => {
                    let mut at = range.start.max(done);
                    for (&start, (end, words)) in changes.range(range.clone()) {
                        placed.push(Placed::Kept(index, at..start));
                        placed.push(Placed::Replaced(index, start..*end, words.clone()));
                        at = *end;
                    }
                    done = at;
                    placed.push(Placed::Kept(index, at.min(range.end)..range.end));
                }
            }
        }
        Ok(())
    }

    fn no_item(&self, index: usize, word: &Word, module: usize, item: &str) -> Problem {
        let unit = &self.units[&module];
        let problem = Problem::at(
            index,
            word.range.clone(),
            format!("the module `{}` has no `{item}`", unit.name),
        );
        match crate::near::nearest(item, unit.items.iter().map(String::as_str)) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help(format!(
                "it has {}",
                crate::near::list(unit.items.iter().map(String::as_str))
            )),
        }
    }
}

impl<'t> Unit<'t> {
    fn new(text: &'t str, index: usize, defines: &mut Defines) -> Result<Unit<'t>, Problem> {
        let preprocessed = preprocess::preprocess(text, index, defines)?;
        let mut bare = tokens::without_comments(text);
        // directives are no part of what is linked
        for directive in directives::find(text) {
            let spaces = " ".repeat(directive.range.len());
            bare.replace_range(directive.range, &spaces);
        }
        let mut found = Vec::new();
        for part in &preprocessed.parts {
            if let Part::Text(range) = part {
                found.extend(tokens::tokens(&bare, range.clone()));
            }
        }
        let mut unit = Unit {
            text,
            name: preprocessed
                .path
                .clone()
                .unwrap_or_else(|| format!("file {}", index + 1)),
            preprocessed,
            tokens: found,
            items: BTreeSet::new(),
            members: BTreeSet::new(),
        };
        unit.declare(index)?;
        Ok(unit)
    }

    /// The words that can be names of things: not members behind a dot, not attributes.
    fn words(&self) -> impl Iterator<Item = &Word> {
        self.tokens.iter().enumerate().filter_map(|(at, token)| {
            let Token::Word(word) = token else {
                return None;
            };
            let before = at.checked_sub(1).map(|at| &self.tokens[at]);
            let is_name = !matches!(before, Some(Token::Mark('.' | '@', _)));
            is_name.then_some(word)
        })
    }

    /// Finds what the file declares outside of functions, and the members of its structs.
    fn declare(&mut self, index: usize) -> Result<(), Problem> {
        let mut depth = 0usize;
        let mut in_struct = false;
        let mut angles = 0usize;
        let mut declares = false;
        for (at, token) in self.tokens.iter().enumerate() {
            match token {
                Token::Mark('{' | '(' | '[', _) => depth += 1,
                Token::Mark('}' | ')' | ']', _) => {
                    depth = depth.saturating_sub(1);
                    in_struct &= depth > 0;
                }
                Token::Mark('<', _) if declares => angles += 1,
                Token::Mark('>', _) if declares => angles = angles.saturating_sub(1),
                Token::Mark(..) => {}
                Token::Word(word) if depth == 0 && declares && angles == 0 => {
                    self.items.insert(word.parts.join("::"));
                    declares = false;
                }
                Token::Word(word) if depth == 0 && !declares => {
                    let keyword = word.parts.join("::");
                    let next_is_fn = matches!(
                        self.tokens.get(at + 1),
                        Some(Token::Word(next)) if next.parts == ["fn"]
                    );
                    if matches!(keyword.as_str(), "virtual" | "override") && next_is_fn {
                        return Err(Problem::at(
                            index,
                            word.range.clone(),
                            format!("`{keyword} fn` is not supported"),
                        )
                        .help("compose such modules with naga_oil, and hand over the module"));
                    }
                    declares = matches!(
                        keyword.as_str(),
                        "fn" | "struct" | "const" | "var" | "override" | "alias"
                    );
                    in_struct = keyword == "struct";
                }
                Token::Word(word) => {
                    let is_member = in_struct
                        && depth == 1
                        && matches!(self.tokens.get(at + 1), Some(Token::Mark(':', _)));
                    if is_member {
                        self.members.insert(word.range.start);
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(files: &[&str], modules: &[(&str, &str)]) -> Result<String, String> {
        let named = |(name, text): &(&str, &str)| ((*name).to_owned(), (*text).to_owned());
        let files: Vec<_> = files
            .iter()
            .map(|&text| named(&("main.wgsl", text)))
            .collect();
        let modules: Vec<_> = modules.iter().map(named).collect();
        match compose(&files, &modules, &Defines::new()) {
            Ok((source, _)) => Ok(source
                .text()
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ")),
            Err(failed) => Err(format!(
                "{}; {}",
                failed.1.message,
                failed.1.help.unwrap_or_default()
            )),
        }
    }

    #[test]
    fn files_without_imports_are_joined() {
        assert_eq!(
            text(&["const A = 1;", "const B = A;"], &[]).as_deref(),
            Ok("const A = 1; const B = A;")
        );
    }

    #[test]
    fn directives_go_first_and_once() {
        assert_eq!(
            text(
                &["enable f16; const A = 1;", "enable f16;\nconst B = A;"],
                &[]
            )
            .as_deref(),
            Ok("enable f16; const A = 1; const B = A;")
        );
    }

    #[test]
    fn imported_names_are_replaced() {
        let module = "#define_import_path lib::hash\nconst K = 3u;\nfn hash2(x: u32) -> u32 { return x * K; }";
        let main = "#import lib::hash\n#import lib::hash::{K as SEED}\nfn f() { hash::hash2(SEED); lib::hash::hash2(1u); a.K = 1; }";
        assert_eq!(
            text(&[main], &[("hash.wgsl", module)]).as_deref(),
            Ok("const K = 3u; fn hash2(x: u32) -> u32 { return x * K; } \
                fn f() { hash2(K); hash2(1u); a.K = 1; }")
        );
    }

    #[test]
    fn a_modules_names_hide_nothing() {
        // `sign` of the main file is WGSL's own
        let module = "#define_import_path lib\nfn sign(x: f32) -> f32 { return 1.0; }\nfn two() -> f32 { return sign(2.0); }";
        let main = "#import lib::two\nfn f() { two() + sign(3.0); }";
        let joined = text(&[main], &[("lib.wgsl", module)]).expect("a text");
        assert!(joined.contains("fn sign_lib(x"), "{joined}");
        assert!(joined.contains("return sign_lib(2.0)"), "{joined}");
        assert!(joined.contains("two() + sign(3.0)"), "{joined}");
    }

    #[test]
    fn two_modules_may_use_one_name() {
        let a = "#define_import_path a\nconst N = 1;\nfn f() { N; }";
        let b = "#define_import_path b\n#import a\nconst N = 2;\nfn f() { a::f(); N; }\nstruct S { N: u32 }";
        let joined = text(
            &["#import b\nfn main() { b::f(); }"],
            &[("a.wgsl", a), ("b.wgsl", b)],
        )
        .expect("a text");
        assert_eq!(
            joined,
            "const N_a = 1; fn f_a() { N_a; } const N_b = 2; fn f_b() { f_a(); N_b; } \
             struct S { N: u32 } fn main() { f_b(); }"
        );
    }

    #[test]
    fn files_can_be_imported_by_name() {
        let module = "fn two() -> f32 { return 2.0; }";
        let main = "#import \"lib/two.wgsl\"::two\nfn f() { two(); }";
        assert_eq!(
            text(&[main], &[("shaders/lib/two.wgsl", module)]).as_deref(),
            Ok("fn two() -> f32 { return 2.0; } fn f() { two(); }")
        );
    }

    #[test]
    fn what_is_not_there_is_told() {
        let module = (
            "noise.wgsl",
            "#define_import_path lib::noise\nfn value() {}",
        );
        assert_eq!(
            text(&["#import lib::nose\nfn f() { nose::value(); }"], &[module]),
            Err("there is no module `lib::nose`; did you mean `lib::noise`?".to_owned())
        );
        assert_eq!(
            text(
                &["#import lib::noise\nfn f() { noise::vale(); }"],
                &[module]
            ),
            Err("the module `lib::noise` has no `vale`; did you mean `value`?".to_owned())
        );
    }

    #[test]
    fn modules_may_import_each_other() {
        let a = "#define_import_path a\n#import b\nfn f() { b::g(); }";
        let b = "#define_import_path b\n#import a\nfn g() {} fn h() { a::f(); }";
        assert!(text(&["#import a\nfn main() { a::f(); }"], &[("a", a), ("b", b)]).is_ok());
    }
}
