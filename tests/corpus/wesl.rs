//! WESL as our linker reads it: imports and modules in naga_oil's words, `@if`, `@elif` and `@else` decided.

use std::path::Path;

/// The text of a WESL file in a crate, with nothing defined.
pub fn to_wgsl(root: &Path, path: &Path, text: &str) -> String {
    let package = package(root);
    let below = path.strip_prefix(root).expect("a file of the crate");
    let below = below.strip_prefix("src").unwrap_or(below);
    let module = below.with_extension("");
    let module = module.display().to_string().replace('/', "::");
    let parent = module.rsplit_once("::").map_or("", |(parent, _)| parent);
    let text = without_comments(text);
    let text = decided(&text);
    let mut whole = format!("#define_import_path {package}::{module}\n");
    let mut rest = text.as_str();
    while let Some(at) = find_import(rest) {
        let (before, after) = rest.split_at(at);
        let (import, after) = after.split_once(';').expect("the end of an import");
        let path = import
            .strip_prefix("import")
            .expect("an import")
            .split_whitespace()
            .collect::<String>()
            .replace(",}", "}");
        let path = match path.split_once("::") {
            Some(("package", below)) => format!("{package}::{below}"),
            Some(("super", below)) => format!("{package}::{parent}::{below}"),
            _ => path,
        };
        whole.push_str(before);
        whole.push_str(&format!("#import {path}\n"));
        rest = after;
    }
    whole.push_str(rest);
    whole
}

/// The crate's name as its modules call it.
fn package(root: &Path) -> String {
    let folder = root.file_name().and_then(|name| name.to_str());
    let (name, _) = folder
        .and_then(|name| name.rsplit_once('-'))
        .expect("name and version");
    name.replace('-', "_")
}

fn find_import(text: &str) -> Option<usize> {
    match text.starts_with("import ") {
        true => Some(0),
        false => text.find("\nimport ").map(|at| at + 1),
    }
}

fn without_comments(text: &str) -> String {
    let mut whole = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("/") {
        let (before, after) = rest.split_at(at);
        whole.push_str(before);
        rest = match (after.starts_with("//"), after.starts_with("/*")) {
            (true, _) => &after[after.find('\n').unwrap_or(after.len())..],
            (_, true) => after.split_once("*/").map_or("", |(_, rest)| rest),
            _ => {
                whole.push('/');
                &after[1..]
            }
        };
    }
    whole + rest
}

/// The text with each `@if`, `@elif` and `@else` decided, nothing being defined.
fn decided(text: &str) -> String {
    let mut whole = String::new();
    let mut rest = text;
    // whether a condition of the last chain has held
    let mut done = false;
    loop {
        let next = [rest.find("@if("), rest.find("@elif("), rest.find("@else")];
        let Some(at) = next.into_iter().flatten().min() else {
            return whole + rest;
        };
        whole.push_str(&rest[..at]);
        let after = &rest[at..];
        let (is_chosen, item) = match after.strip_prefix("@else") {
            Some(item) => (!done, item),
            None => {
                done &= after.starts_with("@elif");
                let open = after.find('(').expect("a condition");
                let end = closing(after, '(', ')');
                (!done && holds(&after[open + 1..end - 1]), &after[end..])
            }
        };
        done |= is_chosen;
        let end = end_of_item(item);
        if is_chosen {
            whole.push_str(&decided(unwrapped(&item[..end])));
        }
        rest = &item[end..];
    }
}

/// What stands in the braces of a block that a condition decides, or an item as it is.
fn unwrapped(item: &str) -> &str {
    let inner = item.trim();
    match inner.starts_with('{') {
        true => &inner[1..inner.len() - 1],
        false => item,
    }
}

/// Whether a condition holds where nothing is defined: names are false.
fn holds(condition: &str) -> bool {
    condition.split("||").any(|all| {
        all.split("&&").all(|name| {
            let name = name.trim();
            assert!(
                !name.contains(['(', ')']),
                "a condition without parentheses: {name}"
            );
            name.starts_with('!')
        })
    })
}

/// Where a declaration or a statement ends: at its semicolon, or with its braces.
fn end_of_item(text: &str) -> usize {
    let semicolon = text.find(';').map_or(text.len(), |at| at + 1);
    match text.find('{') {
        Some(at) if at < semicolon => closing(text, '{', '}'),
        _ => semicolon,
    }
}

/// Behind the bracket that closes the first one.
fn closing(text: &str, open: char, close: char) -> usize {
    let mut depth = 0;
    for (at, letter) in text.char_indices() {
        if letter == open {
            depth += 1;
        } else if letter == close {
            depth -= 1;
            if depth == 0 {
                return at + 1;
            }
        }
    }
    text.len()
}

/// Each rule on a text that has them all.
#[test]
fn what_wesl_decides_is_decided() {
    let text = "import package::a::{\n  b, // one\n  c,\n};\nimport super::d::e;\n@if(X)\nvar<private> x: u32;\n@elif(!Y)\nvar<private> y: u32;\n@else\nvar<private> z: u32;\n\
        @if(!X && !Y) { const z = 1; }\nfn f() { @if(X || Y) { g(); } h(); }\n";
    let wgsl = to_wgsl(
        Path::new("/p-q-1.0.0"),
        Path::new("/p-q-1.0.0/src/m/n.wesl"),
        text,
    );
    let lines: Vec<&str> = wgsl
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect();
    assert_eq!(
        lines,
        [
            "#define_import_path p_q::m::n",
            "#import p_q::a::{b,c}",
            "#import p_q::m::d::e",
            "var<private> y: u32;",
            "const z = 1;",
            "fn f() {  h(); }",
        ]
    );
}
