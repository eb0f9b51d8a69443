//! The example runs, and finds its own picture right.

use std::process::Command;

#[test]
fn the_example_runs() {
    let output = Command::new(env!("CARGO_BIN_EXE_build-time"))
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        text.contains("at 2x2        6000 of 24000 pixels shaded"),
        "{text}"
    );
    assert!(text.contains("checked"), "{text}");
}
