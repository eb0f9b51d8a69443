//! For each [code](Code), a shader that is refused, or warned about, for that reason alone.
//!
//! The first lines of a shader may set options (`// options: {..}`, JSON over the defaults) and name an entry point
//! (`// entry: NAME`); `// here` marks the line that the finding is about.
//!
//! *Guarantees* (a test): every code that can be given has an example, which yields it, nothing else, and that line.

use serde_json::Value;

use crate::{Code, Entries, Finding, Options, Source, input, rewrite};

/// The mark of the line that a finding is about.
pub const MARK: &str = "// here";

/// A shader that yields a code.
#[derive(Clone, Debug)]
pub struct Example {
    /// The shader, which lines of options and marks are part of.
    pub text: &'static str,
    /// What is asked of the rewriter.
    pub options: Options,
    /// The entry point that is asked for.
    pub entry: Option<&'static str>,
}

/// The example of a code; none for [`Code::Defect`], which nobody knows how to make, and [`Code::UnsupportedStore`], which is not
/// given any more.
pub fn of(code: Code) -> Option<Example> {
    let text = match code.number() {
        1 => include_str!("codes/001.wgsl"),
        2 => include_str!("codes/002.wgsl"),
        3 => include_str!("codes/003.wgsl"),
        4 => include_str!("codes/004.wgsl"),
        5 => include_str!("codes/005.wgsl"),
        10 => include_str!("codes/010.wgsl"),
        11 => include_str!("codes/011.wgsl"),
        12 => include_str!("codes/012.wgsl"),
        13 => include_str!("codes/013.wgsl"),
        14 => include_str!("codes/014.wgsl"),
        15 => include_str!("codes/015.wgsl"),
        16 => include_str!("codes/016.wgsl"),
        18 => include_str!("codes/018.wgsl"),
        19 => include_str!("codes/019.wgsl"),
        20 => include_str!("codes/020.wgsl"),
        21 => include_str!("codes/021.wgsl"),
        22 => include_str!("codes/022.wgsl"),
        23 => include_str!("codes/023.wgsl"),
        24 => include_str!("codes/024.wgsl"),
        25 => include_str!("codes/025.wgsl"),
        26 => include_str!("codes/026.wgsl"),
        27 => include_str!("codes/027.wgsl"),
        100 => include_str!("codes/100.wgsl"),
        101 => include_str!("codes/101.wgsl"),
        102 => include_str!("codes/102.wgsl"),
        103 => include_str!("codes/103.wgsl"),
        104 => include_str!("codes/104.wgsl"),
        105 => include_str!("codes/105.wgsl"),
        106 => include_str!("codes/106.wgsl"),
        107 => include_str!("codes/107.wgsl"),
        _ => return None,
    };
    let set = |line: &str| line.strip_prefix("// options: ").map(options);
    let named = |line: &'static str| line.strip_prefix("// entry: ");
    Some(Example {
        text,
        options: text.lines().find_map(set).unwrap_or_default(),
        entry: text.lines().find_map(named),
    })
}

/// Options from JSON over the defaults.
fn options(json: &str) -> Options {
    let whole = serde_json::to_value(Options::default()).and_then(|mut all| {
        if let (Value::Object(all), Value::Object(set)) = (&mut all, serde_json::from_str(json)?) {
            all.extend(set);
        }
        serde_json::from_value(all)
    });
    match whole {
        Ok(options) => options,
        Err(error) => unreachable!("the options of an example are options: {error}"),
    }
}

impl Example {
    /// The shader as a source, called as the code.
    pub fn source(&self, code: Code) -> Source {
        Source::new(format!("{code}.wgsl"), self.text)
    }

    /// What the rewriter says of it.
    pub fn findings(&self, source: &Source) -> Vec<Finding> {
        let (module, info) = match input::wgsl(source) {
            Ok(parsed) => parsed,
            Err(invalid) => unreachable!("examples are valid: {}", invalid.rendered),
        };
        let entries = self.entry.map_or(Entries::PerPixel, Entries::Named);
        match rewrite(&module, &info, entries, &self.options) {
            Ok(rewritten) => rewritten.warnings.into_iter().map(|(_, w)| w).collect(),
            Err(refusal) => refusal.findings,
        }
    }

    /// The line that is marked, from 1.
    pub fn marked(&self) -> Option<usize> {
        let line = self.text.lines().position(|line| line.ends_with(MARK))?;
        Some(line + 1)
    }
}
