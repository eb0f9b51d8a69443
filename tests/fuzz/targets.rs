//! What fuzzers call: whatever the input is, the rewriter never panics, and never makes what is not valid.
//!
//! *Does*: reads a text, or a mutation of one of the tests' shaders; rewrites what is valid; writes the result, which compares a
//! fresh parse of the text with the module; renders every refusal.
//! *Needs*: nothing of its input. *Fails*: by a panic.

use std::{path::Path, sync::OnceLock};

use vrcs_passes::{
    Code, Color, Entries, Options, Source, emit, input,
    options::{FullTiles, MaxRate},
    rewrite,
};

/// Any text.
pub fn text(data: &[u8]) {
    let (choice, text) = match data.split_first() {
        Some((choice, text)) => (*choice, text),
        None => (0, data),
    };
    pound(&String::from_utf8_lossy(text), choice);
}

/// A mutation of one of the tests' shaders: the first byte picks it, each two more change it in one place.
pub fn mutated(data: &[u8]) {
    let Some((&pick, rest)) = data.split_first() else {
        return;
    };
    let shaders = shaders();
    let mut tokens: Vec<&str> = tokens(&shaders[usize::from(pick) % shaders.len()]);
    let donor: Vec<&str> = self::tokens(&shaders[usize::from(pick / 2) % shaders.len()]);
    for change in rest.chunks_exact(4).take(12) {
        if tokens.is_empty() {
            return;
        }
        let at = usize::from(u16::from_le_bytes([change[0], change[1]])) % tokens.len();
        let other = usize::from(change[2]).wrapping_mul(31) % tokens.len();
        match change[3] % 8 {
            0 => drop(tokens.remove(at)),
            1 => tokens.insert(at, tokens[other]),
            2 => tokens.swap(at, other),
            3 => tokens[at] = donor[other % donor.len()],
            4 => tokens[at] = NUMBERS[other % NUMBERS.len()],
            5 => tokens[at] = OPERATORS[other % OPERATORS.len()],
            // most changes keep the kind of the token, so that the result is a shader more often than not
            _ => {
                let kind = kind(tokens[at]);
                let alike = (0..tokens.len())
                    .map(|step| tokens[(other + step) % tokens.len()])
                    .find(|token| self::kind(token) == kind);
                tokens[at] = alike.unwrap_or(tokens[at]);
            }
        }
    }
    pound(&tokens.concat(), pick);
}

const NUMBERS: [&str; 10] = [
    "0u",
    "1u",
    "0",
    "1",
    "-1",
    "4294967295u",
    "2147483647",
    "0.0",
    "1e38",
    "3u",
];
const OPERATORS: [&str; 14] = [
    "+", "-", "*", "/", "%", "<", ">=", "==", "^", "&", "|", "<<", ">>", "&&",
];

/// The tests' shaders.
fn shaders() -> &'static [String] {
    static SHADERS: OnceLock<Vec<String>> = OnceLock::new();
    SHADERS.get_or_init(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = [root.join("tests/shaders"), root.join("../shaders")]
            .into_iter()
            .find(|folder| folder.is_dir())
            .expect("the tests' shaders");
        let mut paths: Vec<_> = std::fs::read_dir(folder)
            .expect("the tests' shaders")
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| {
                path.extension()
                    .is_some_and(|extension| extension == "wgsl")
            })
            .collect();
        paths.sort();
        paths
            .iter()
            .map(|path| std::fs::read_to_string(path).expect("a shader"))
            .collect()
    })
}

/// Whether a character belongs to a word, or is a space, or something else.
fn class(character: char) -> u8 {
    match character {
        c if c.is_alphanumeric() || matches!(c, '_' | '.' | '@') => 0,
        c if c.is_whitespace() => 1,
        _ => 2,
    }
}

/// What a token is: a number, a word, a space, an operator.
fn kind(token: &str) -> u8 {
    match token.chars().next() {
        Some(c) if c.is_ascii_digit() => 3,
        Some(c) => class(c),
        None => 4,
    }
}

/// Words, runs of spaces, and single other characters.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut start = 0;
    let mut last = None;
    for (at, character) in text.char_indices() {
        let class = class(character);
        if last.is_some_and(|last| last != class || class == 2) {
            tokens.push(&text[start..at]);
            start = at;
        }
        last = Some(class);
    }
    tokens.push(&text[start..]);
    tokens
}

/// Reads, rewrites, writes.
fn pound(text: &str, choice: u8) {
    let source = Source::new("fuzzed.wgsl", text);
    let Ok((module, info)) = input::wgsl(&source) else {
        return;
    };
    let options = Options {
        max_rate: [MaxRate::R2x2, MaxRate::R4x4, MaxRate::R2x4, MaxRate::R4x2]
            [usize::from(choice & 3)],
        tile: [[16, 16], [8, 8], [32, 8], [16, 8]][usize::from(choice >> 2 & 3)],
        full_tiles: [FullTiles::Promote, FullTiles::Keep][usize::from(choice >> 4 & 1)],
        ..Options::default()
    };
    match rewrite(&module, &info, Entries::PerPixel, &options) {
        Ok(rewritten) => {
            for (_, warning) in &rewritten.warnings {
                warning.render(&source, Color::Never);
            }
            let Ok(text) = emit::wgsl(&rewritten.module, &rewritten.info) else {
                return;
            };
            let again = Source::new("rewritten.wgsl", text);
            if let Err(invalid) = input::wgsl(&again) {
                panic!("{}\n{}", invalid.rendered, source.text());
            }
        }
        Err(refusal) => {
            let rendered = refusal.render(&source, Color::Never);
            let is_defect = refusal.findings.iter().any(|f| f.code == Code::Defect);
            assert!(!is_defect, "{rendered}\n{}", source.text());
        }
    }
}
