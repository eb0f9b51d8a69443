//! What the program says: results on standard output, all else on standard error, in colour only to a terminal that wants
//! it.

use std::io::{IsTerminal, Write};

use vrcs_passes::Color;

use super::Failure;

/// Whether standard error gets colours: a terminal, and `NO_COLOR` is not set.
pub(crate) fn color() -> Color {
    let unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    match std::io::stderr().is_terminal() && !unwanted {
        true => Color::Always,
        false => Color::Never,
    }
}

/// Says something. Nobody to hear it is no reason to stop.
pub(crate) fn say(text: &str) {
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes());
    if !text.ends_with('\n') {
        let _ = stderr.write_all(b"\n");
    }
}

/// Says what went wrong.
pub(crate) fn error(message: &str) {
    say(&labelled_error(message));
}

/// A message with the word that tells an error.
pub(crate) fn labelled_error(message: &str) -> String {
    match color() {
        Color::Always => format!("\x1b[1;31merror\x1b[0m: {message}"),
        Color::Never => format!("error: {message}"),
    }
}

/// A bar that tells how far a batch is, to a terminal only.
pub(crate) struct Progress(Option<indicatif::ProgressBar>);

impl Progress {
    /// A bar for so many steps.
    pub(crate) fn new(steps: usize) -> Progress {
        let is_seen = std::io::stderr().is_terminal() && steps > 1;
        Progress(is_seen.then(|| {
            let bar = indicatif::ProgressBar::new(steps as u64);
            let style = indicatif::ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}");
            bar.with_style(style.unwrap_or_else(|_| indicatif::ProgressStyle::default_bar()))
        }))
    }

    /// Whether anybody sees it.
    pub(crate) fn is_seen(&self) -> bool {
        self.0.is_some()
    }

    /// There are so many more steps than was known.
    pub(crate) fn lengthen(&self, more: usize) {
        if let Some(bar) = &self.0 {
            bar.inc_length(more as u64);
        }
    }

    /// A step is done.
    pub(crate) fn step(&self, name: &str) {
        if let Some(bar) = &self.0 {
            bar.set_message(name.to_owned());
            bar.inc(1);
        }
    }

    /// All is done.
    pub(crate) fn done(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// Says what is going on, in place of what was said so before; to a terminal only.
pub(crate) fn status(text: &str) {
    if std::io::stderr().is_terminal() {
        let mut stderr = std::io::stderr().lock();
        let _ = write!(stderr, "\r\x1b[2K{text}");
        let _ = stderr.flush();
    }
}

/// Ends what is going on.
pub(crate) fn status_done() {
    status("");
}

/// Gives a line of results.
pub(crate) fn data(line: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{line}").map_err(|error| match error.kind() {
        // whoever read it has had enough
        std::io::ErrorKind::BrokenPipe => Failure::Outside(String::new()),
        _ => Failure::Outside(format!("standard output: {error}")),
    })
}
