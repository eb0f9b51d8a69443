//! The `vrcs` program. Everything it does is in [`vrcs::cli`]; see `vrcs --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_mesa();
    // naga's parser recurses as deep as the shader nests
    let program = std::thread::Builder::new()
        .name("vrcs".to_owned())
        .stack_size(256 << 20)
        .spawn(vrcs::cli::run);
    match program.map(std::thread::JoinHandle::join) {
        Ok(Ok(code)) => code,
        Ok(Err(_)) => ExitCode::from(101),
        Err(error) => {
            eprintln!("error: no thread: {error}");
            ExitCode::from(3)
        }
    }
}

/// Mesa's layer for choosing among displays complains on standard error where there is no display at all.
fn quiet_mesa() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none()
        && std::env::var_os("NODEVICE_SELECT").is_none()
    {
        // SAFETY: no other thread has been started yet, so nobody reads the environment meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
