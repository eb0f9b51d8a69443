//! The rewriter as a library in a tool: `cargo run --example rewrite -- SHADER.wgsl` prints the rewritten shader, and to standard
//! error what is needed to dispatch it.

use std::process::ExitCode;

use vrcs_passes::{Color, Entries, Options, Source, emit, input, rewrite};

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: rewrite SHADER.wgsl");
        return ExitCode::from(2);
    };
    match rewrite_file(&path) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn rewrite_file(path: &str) -> Result<(), String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    let source = Source::new(path, text);
    let (module, info) = input::wgsl(&source).map_err(|invalid| invalid.rendered)?;
    let rewritten = rewrite(&module, &info, Entries::PerPixel, &Options::default())
        .map_err(|refusal| refusal.render(&source, Color::Never))?;
    let text = emit::wgsl(&rewritten.module, &rewritten.info).map_err(|error| error.to_string())?;
    for entry in &rewritten.manifest.entries {
        eprintln!("{}: workgroups of {:?}", entry.name, entry.workgroup_size);
    }
    print!("{text}");
    Ok(())
}
