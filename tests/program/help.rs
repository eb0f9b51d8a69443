//! `--help`, completions and manual pages, and colours.

use std::path::Path;

use crate::{folder, names, status, stderr, stdout, vrcs};

/// Every command, by what `vrcs --help` lists.
fn commands(folder: &Path) -> Vec<String> {
    let listed = stdout(&vrcs(&["--help"], folder));
    let listed = listed.lines().skip_while(|line| *line != "Commands:");
    let listed = listed.skip(1).take_while(|line| !line.is_empty());
    listed
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

#[test]
fn a_commands_help_fits_a_screen_has_examples_and_hides_nothing_from_the_long_one() {
    let folder = folder();
    let commands = commands(folder.path());
    assert!(commands.len() >= 12, "{commands:?}");
    for command in std::iter::once("").chain(commands.iter().map(String::as_str)) {
        let asked = |help| {
            let arguments: Vec<&str> = [command, help]
                .into_iter()
                .filter(|argument| !argument.is_empty())
                .collect();
            stdout(&vrcs(&arguments, folder.path()))
        };
        let (short, long) = (asked("-h"), asked("--help"));
        let lines = short.lines().count();
        assert!(lines <= 40, "vrcs {command} -h has {lines} lines:\n{short}");
        let widest = short.lines().map(|line| line.chars().count()).max();
        assert!(widest <= Some(100), "vrcs {command} -h: {widest:?} columns");
        let takes_nothing = ["codes", "adapters"].contains(&command);
        assert!(
            takes_nothing || short.contains("Examples:\n  vrcs "),
            "vrcs {command} -h has no examples:\n{short}"
        );
        for option in short
            .split_whitespace()
            .filter(|word| word.starts_with("--"))
        {
            let name = option.trim_matches(|c: char| !c.is_alphanumeric() && c != '-');
            assert!(long.contains(name), "vrcs {command} --help lacks {name}");
        }
    }
    // what is seldom wanted is in the long help alone
    let long = stdout(&vrcs(&["rewrite", "--help"], folder.path()));
    let short = stdout(&vrcs(&["rewrite", "-h"], folder.path()));
    assert!(long.contains("--max-storage-buffers") && !short.contains("--max-storage-buffers"));
}

#[test]
fn completions_and_man_pages_are_made() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = vrcs(&["completions", shell], folder.path());
        assert_eq!(status(&output), 0);
        assert!(stdout(&output).contains("rewrite"), "{shell}");
    }
    let output = vrcs(&["man", "pages"], folder.path());
    assert_eq!(status(&output), 0);
    let pages = names(&folder.path().join("pages"));
    assert!(pages.contains(&"vrcs.1".to_owned()) && pages.contains(&"vrcs-rewrite.1".to_owned()));
    assert!(
        !pages.iter().any(|page| page.contains("child")),
        "{pages:?}"
    );
}

#[test]
fn no_colours_where_nobody_wants_them() {
    let folder = folder();
    let output = vrcs(&["rewrite", "nothing.wgsl"], folder.path());
    assert!(!stderr(&output).contains('\x1b'));
    assert!(!stdout(&vrcs(&["explain", "good.wgsl"], folder.path())).contains('\x1b'));
}
