//! Holds SPIR-V against Khronos' validator, `spirv-val`: the rewritten shader's, and where that is refused, the original's.

use std::{
    io::Write,
    process::{Command, Stdio},
};

use naga::{Module, valid::ModuleInfo};
use vrcs_passes::{
    emit::{self, Form},
    input::Shader,
};

use super::table::Row;

/// Whether the validator is there.
pub fn is_there() -> bool {
    let there = Command::new("spirv-val").arg("--version").output().is_ok();
    assert!(
        there || std::env::var_os("VRCS_REQUIRE_TOOLS").is_none(),
        "spirv-val is not installed: it comes with the package spirv-tools"
    );
    there
}

/// What the validator says of an entry point, as it is and rewritten; `None` if it takes the rewritten one.
pub fn refused(row: &Row, shader: &Shader) -> Option<[Option<String>; 2]> {
    let options = row
        .choice
        .as_ref()
        .map(|choice| choice.options.clone())
        .unwrap_or_default();
    let rewritten =
        vrcs_passes::rewrite(&shader.module, &shader.info, row.entry.as_str(), &options)
            .expect("a rewrite, as the row says");
    let after = complaint(&rewritten.module, &rewritten.info, &row.entry)?;
    Some([
        complaint(&shader.module, &shader.info, &row.entry),
        Some(after),
    ])
}

/// What the validator has against an entry point, without the numbers of ids.
fn complaint(module: &Module, info: &ModuleInfo, entry: &str) -> Option<String> {
    let unset = module.overrides.iter().filter(|(_, o)| o.init.is_none());
    let form = Form {
        entry: Some(entry.to_owned()),
        constants: unset
            .filter_map(|(_, o)| Some((o.name.clone()?, 8.0)))
            .collect(),
        ..Form::default()
    };
    let bytes = match emit::spirv(module, info, &form) {
        Ok(written) => written.bytes,
        Err(error) => return Some(format!("naga: {error}")),
    };
    let mut child = Command::new("spirv-val")
        .args(["--target-env", "vulkan1.2", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("spirv-val starts");
    child
        .stdin
        .take()
        .expect("its input")
        .write_all(&bytes)
        .expect("its input takes SPIR-V");
    let output = child.wait_with_output().expect("spirv-val ends");
    if output.status.success() {
        return None;
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    let (_, what) = said.split_once(": ").unwrap_or(("", &said));
    let is_no_digit = |c: &char| !c.is_ascii_digit();
    Some(what.lines().next()?.chars().filter(is_no_digit).collect())
}
