//! The Rust module of a build: for each shader its text, and typed constants for what it binds and how it is dispatched.

use std::{
    collections::BTreeSet,
    fmt::{self, Write},
    path::Path,
};

use super::Done;
use crate::{
    emit::{Language, Target},
    manifest::Entry,
};

/// What every module starts with.
const HEAD: &str = r#"/// A binding: its group, and its number in the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code)]
pub struct Binding {
    /// The group.
    pub group: u32,
    /// The number in the group.
    pub binding: u32,
}

/// A rewritten entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code)]
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// How primaries find their pixels.
    pub mode: &'static str,
    /// Its workgroup size.
    pub workgroup_size: [u32; 3],
    /// The tile of the coordinate buffer, in pixels.
    pub tile: [u32; 2],
    /// How many invocations retire together, for the nearly-full rule.
    pub wave: u32,
    /// What the logical extent is divided by, rounded up, for the number of workgroups.
    pub divide: [u32; 3],
}

#[allow(dead_code)]
impl Entry {
    /// The number of workgroups for a logical extent, in invocations.
    pub const fn groups(&self, extent: [u32; 3]) -> [u32; 3] {
        [
            extent[0].div_ceil(self.divide[0]),
            extent[1].div_ceil(self.divide[1]),
            extent[2].div_ceil(self.divide[2]),
        ]
    }
}
"#;

/// The words that cannot be names, apart from those that no shader can be called.
const KEYWORDS: &[&str] = &[
    "as", "async", "await", "box", "break", "const", "continue", "crate", "do", "dyn", "else",
    "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self",
    "static", "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized",
    "use", "virtual", "where", "while", "yield", "abstract", "become", "bindings",
];

/// The module's name for a shader: `deep/light.wgsl` is `deep_light`.
pub(super) fn module_name(below: &Path) -> String {
    let stem = below.with_extension("");
    let parts: Vec<String> = stem
        .components()
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    snake(&parts.join("_"))
}

/// A name in lower case, words apart by `_`.
fn snake(name: &str) -> String {
    let mut out = String::new();
    let mut was_lower = false;
    for c in name.chars() {
        if c.is_uppercase() && was_lower {
            out.push('_');
        }
        was_lower = c.is_lowercase() || c.is_ascii_digit();
        match c.is_alphanumeric() {
            true => out.extend(c.to_lowercase()),
            false => out.push('_'),
        }
    }
    if out.starts_with(|c: char| c.is_ascii_digit()) || out.is_empty() {
        out.insert(0, '_');
    }
    if KEYWORDS.contains(&out.as_str()) {
        out.push('_');
    }
    out
}

/// The module.
pub(super) fn module(done: &[Done], target: Target) -> String {
    let mut out = format!(
        "// Made by vrcs-passes {}; do not edit.\n\n{HEAD}",
        env!("CARGO_PKG_VERSION")
    );
    for one in done {
        match shader(&mut out, one, target) {
            Ok(()) => {}
            Err(fmt::Error) => unreachable!("text in memory takes whatever is written"),
        }
    }
    out
}

fn shader(out: &mut String, one: &Done, target: Target) -> fmt::Result {
    let file = one.below.to_string_lossy().replace('\\', "/");
    let json = one.below.with_extension("json");
    let json = json.to_string_lossy().replace('\\', "/");
    let from = one.from.replace('\\', "/");
    writeln!(out, "\n/// `{from}`, rewritten.")?;
    writeln!(out, "#[allow(dead_code)]\npub mod {} {{", one.name)?;
    writeln!(out, "    use super::{{Binding, Entry}};\n")?;
    match target.language() {
        Language::SpirV => {
            writeln!(out, "    /// The shader as SPIR-V, little-endian.")?;
            write!(out, "    pub const BYTES: &[u8] = include_bytes!")?;
        }
        language => {
            writeln!(
                out,
                "    /// The shader's text, in {}.",
                language.name().to_uppercase()
            )?;
            write!(out, "    pub const TEXT: &str = include_str!")?;
        }
    }
    writeln!(
        out,
        "(concat!(env!(\"OUT_DIR\"), {:?}));",
        format!("/vrcs/{file}")
    )?;
    writeln!(out, "    /// The manifest, as JSON.")?;
    writeln!(
        out,
        "    pub const MANIFEST: &str = include_str!(concat!(env!(\"OUT_DIR\"), {:?}));",
        format!("/vrcs/{json}")
    )?;
    let mut taken = BTreeSet::from(["bindings".to_owned()]);
    for of in &one.manifest.entries {
        entry(out, of, &mut taken)?;
    }
    own_bindings(out, one)?;
    writeln!(out, "}}")
}

fn free(name: String, taken: &mut BTreeSet<String>) -> String {
    let mut name = name;
    while !taken.insert(name.clone()) {
        name.push('_');
    }
    name
}

fn entry(out: &mut String, entry: &Entry, taken: &mut BTreeSet<String>) -> fmt::Result {
    let name = free(snake(&entry.name), taken);
    writeln!(out, "\n    /// The entry point `{}`.", entry.name)?;
    writeln!(out, "    pub mod {name} {{")?;
    writeln!(out, "        use super::{{Binding, Entry}};\n")?;
    writeln!(out, "        /// How it is dispatched.")?;
    writeln!(out, "        pub const ENTRY: Entry = Entry {{")?;
    writeln!(out, "            name: {:?},", entry.name)?;
    let mode = format!("{:?}", entry.mode).to_lowercase();
    writeln!(out, "            mode: {mode:?},")?;
    writeln!(
        out,
        "            workgroup_size: {:?},",
        entry.workgroup_size
    )?;
    writeln!(out, "            tile: {:?},", entry.tile)?;
    writeln!(out, "            wave: {},", entry.wave)?;
    writeln!(out, "            divide: {:?},", entry.dispatch.divide)?;
    writeln!(out, "        }};")?;
    for binding in &entry.bindings {
        let name = snake(&binding.name).to_uppercase();
        writeln!(
            out,
            "        /// The added binding `{}`: {}.",
            binding.name, binding.kind
        )?;
        constant(out, "        ", &name, binding.group, binding.binding)?;
        writeln!(
            out,
            "        /// The least size of `{}`, in bytes.",
            binding.name
        )?;
        writeln!(
            out,
            "        pub const {name}_SIZE: u32 = {};",
            binding.size
        )?;
    }
    writeln!(out, "    }}")
}

fn own_bindings(out: &mut String, one: &Done) -> fmt::Result {
    let mut taken = BTreeSet::new();
    writeln!(out, "\n    /// The shader's own bindings.")?;
    writeln!(out, "    pub mod bindings {{")?;
    writeln!(out, "        use super::Binding;\n")?;
    for (name, group, binding, size) in &one.bindings {
        let constant_name = free(snake(name).to_uppercase(), &mut taken);
        writeln!(out, "        /// `{name}`")?;
        constant(out, "        ", &constant_name, *group, *binding)?;
        if let Some(size) = size {
            let size_name = free(format!("{constant_name}_SIZE"), &mut taken);
            writeln!(out, "        /// The least size of `{name}`, in bytes.")?;
            writeln!(out, "        pub const {size_name}: u32 = {size};")?;
        }
    }
    writeln!(out, "    }}")
}

fn constant(out: &mut String, indent: &str, name: &str, group: u32, binding: u32) -> fmt::Result {
    writeln!(
        out,
        "{indent}pub const {name}: Binding = Binding {{ group: {group}, binding: {binding} }};"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_rust_names() {
        for (name, expected) in [
            ("light", "light"),
            ("mainImage", "main_image"),
            ("deep light-2", "deep_light_2"),
            ("3d", "_3d"),
            ("match", "match_"),
            ("RGBA", "rgba"),
        ] {
            assert_eq!(snake(name), expected);
        }
        assert_eq!(
            module_name(Path::new("deep/Light.frag.wgsl")),
            "deep_light_frag"
        );
    }
}
