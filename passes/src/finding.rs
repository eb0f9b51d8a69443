//! What the rewriter has to say about a shader: refusals and warnings, each with a stable code, the place in the
//! author's own text, and what the author can change.

use std::fmt;

use codespan_reporting::{
    diagnostic::{Diagnostic, Label as CodespanLabel, Severity as CodespanSeverity},
    term::{self, termcolor},
};
use naga::{GlobalVariable, Handle, Span};
use serde::Serialize;

use crate::source::Source;

/// Declares the codes with their numbers, names and explanations in one place.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $name:ident = $number:literal, $severity:ident;)+) => {
        /// A stable code. Refusals are below 100, warnings from 100 on.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Code {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Code {
            /// Every code.
            pub const ALL: &'static [Code] = &[$(Code::$name),+];

            /// The code's number.
            pub fn number(self) -> u16 {
                match self {
                    $(Code::$name => $number,)+
                }
            }

            /// Whether the code stops the rewrite.
            pub fn severity(self) -> Severity {
                match self {
                    $(Code::$name => Severity::$severity,)+
                }
            }

            /// What the code means, in a few sentences.
            pub fn explanation(self) -> &'static str {
                match self {
                    $(Code::$name => concat!($($doc, "\n"),+).trim_ascii(),)+
                }
            }
        }
    };
}

codes! {
    /// The module has no compute entry point at all.
    NoComputeEntry = 1, Refusal;
    /// No compute entry point has the name that was asked for.
    UnknownEntry = 2, Refusal;
    /// The entry point stores nothing at an address that depends on both axes of its invocation grid, so there is no
    /// pixel that a duplicate could take from its primary.
    NothingPerPixel = 3, Refusal;
    /// The rewritten shader needs two bindings of its own, and no bind group of the device has two free numbers for them.
    NoFreeBinding = 4, Refusal;
    /// The entry point has been rewritten before.
    AlreadyRewritten = 5, Refusal;
    /// The address of a store cannot be computed a second time, so it is not known where a duplicate would have stored:
    /// it is made from memory that the shader writes, from an atomic's result, or in a way that is not followed.
    AddressNotRecomputable = 10, Refusal;
    /// A store's address is not one-to-one with the invocation: it leaves out an axis of the invocation grid, or several pixels have
    /// the same (`id.xy / 2u`). A duplicate's store would be lost, or which of several primaries' values stays would be chance.
    AddressNotOneToOne = 11, Refusal;
    /// A store runs only for some ids and does not go to a pixel's own address. When the invocation that was to run it
    /// is a duplicate, the store would be lost.
    ConditionalOnIds = 12, Refusal;
    /// The shader reads what other invocations of the same dispatch write. What they write changes when they become
    /// duplicates.
    ReadsOthersOutput = 13, Refusal;
    /// An atomic counts invocations, or hands something on from one to the next. Duplicates do not run, so the count would change.
    /// An exchange at the invocation's own place alone is no such thing.
    Atomic = 14, Refusal;
    /// The invocations of a workgroup work together, through workgroup memory or barriers, in a way that cannot be taken apart. All of
    /// them have to reach each barrier, and what they share must not hang on which of them are duplicates: between two barriers,
    /// either the whole workgroup does something, or each pixel does something for itself.
    WorkgroupMemory = 15, Refusal;
    /// A subgroup operation's result depends on which invocations share a subgroup, and that changes.
    SubgroupOperation = 16, Refusal;
    /// The store has a form that is not supported. Not given any more: every form of store is.
    UnsupportedStore = 17, Refusal;
    /// There are too many paths of calls to follow them all.
    TooManyPaths = 18, Refusal;
    /// The policy for the target is `refuse`.
    PolicyRefuses = 19, Refusal;
    /// The device limits that are assumed do not leave room for the added resources.
    OverLimit = 20, Refusal;
    /// A name that the options give, of a target, a texture or a width, or another option does not fit the shader.
    UnfitOption = 21, Refusal;
    /// Graded mode changes only what `vrcs_copies()` and `vrcs_rate()` give, and the shader calls neither.
    NothingGraded = 22, Refusal;
    /// The shader has barriers or workgroup memory, so its workgroups have to be tiles: the mode can only be `tiled`.
    NeedsTiles = 23, Refusal;
    /// The place that was asked for the added bindings is another binding's.
    PlaceTaken = 24, Refusal;
    /// The entry point uses as many uniform or storage buffers as the device is taken to have, and one of each is added.
    TooManyBuffers = 25, Refusal;
    /// A target's policy is `full`, and its stores cannot be separated from the rest of the shader: one side reads what the
    /// other stores, needs the result of its atomics, or shares a private variable with it, or invocations work together.
    NotSeparable = 26, Refusal;
    /// The workgroup size divides by zero, whatever values the overrides in it are given, so that no pipeline can be made of the
    /// entry point as it stands.
    NoWorkgroupSize = 27, Refusal;
    /// The rewriter made something that naga does not accept: a defect of this crate.
    Defect = 99, Refusal;
    /// A store runs only for some ids. It follows its primary: a duplicate gets a copy if its primary ran the store.
    FollowsPrimary = 100, Warning;
    /// The shader reads its own pixel of a target that it also writes. Duplicates take their primary's value, state
    /// included, so that blocks that stay coarse share one history.
    SharedState = 101, Warning;
    /// A value is handed from each invocation to the one that shades for it, through workgroup memory: it cannot be
    /// computed from the ids. That takes memory, and sometimes a barrier.
    Exchanged = 102, Warning;
    /// A region between two barriers works for the whole workgroup and stores to a target with what it finds out. Every
    /// invocation runs it; those whose pixel is a duplicate only keep from storing, so no wave retires there.
    MaskedRegion = 103, Warning;
    /// The entry point on its own uses more uniform or storage buffers than WebGPU's default limit, so the device is one that gives
    /// more; it has to give one more of each.
    BeyondUsualLimit = 104, Warning;
    /// The invocations of a workgroup work together on one pixel, the workgroup's own. A primary would have to be a whole workgroup; here
    /// it is an invocation, no two that store lie in one block, and no rate saves anything.
    PixelIsAGroup = 105, Warning;
    /// Neighbours in the grid of invocations are no neighbours in the texture that is stored to: a line of invocations covers several
    /// rows, or workgroups are dealt out over the picture by their numbers. Rates are of the grid, so that a block that shares one is no
    /// block of the picture.
    Scattered = 106, Warning;
    /// Copies cannot serve a target: a store to it runs only for some ids, goes to one place for several pixels, or to a place that cannot
    /// be computed again. Nothing was said of it, and its stores can be separated from the rest, so it has the policy `full`: every pixel of
    /// the logical extent stores there what the original does, and what those stores need is not saved.
    StoredForEveryPixel = 107, Warning;
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VRCS{:03}", self.number())
    }
}

impl std::str::FromStr for Code {
    type Err = String;

    /// Understands `VRCS013`, `vrcs13` and `13`.
    fn from_str(text: &str) -> Result<Code, String> {
        let digits = match text.get(..4) {
            Some(prefix) if prefix.eq_ignore_ascii_case("vrcs") => &text[4..],
            _ => text,
        };
        let number: Option<u16> = digits.parse().ok();
        let found = Code::ALL.iter().find(|code| Some(code.number()) == number);
        found
            .copied()
            .ok_or_else(|| format!("there is no code `{text}`; `vrcs codes` lists them"))
    }
}

impl Serialize for Code {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Whether a finding stops the rewrite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The entry point is not rewritten.
    Refusal,
    /// The entry point is rewritten; the author should know something.
    Warning,
}

/// A place that a finding is about, and what is said of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is said of it.
    pub text: String,
}

/// Something to say about a shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The code.
    pub code: Code,
    /// One sentence.
    pub message: String,
    /// The places, the main one first.
    pub labels: Vec<Label>,
    /// What the author can do.
    pub help: Option<String>,
    /// The resource whose plain stores alone it is about: were every pixel to store there [for itself](crate::full), it would not be given.
    pub stored: Option<Handle<GlobalVariable>>,
}

impl Finding {
    /// A finding without a place.
    pub fn new(code: Code, message: impl Into<String>) -> Finding {
        Finding {
            code,
            message: message.into(),
            labels: Vec::new(),
            help: None,
            stored: None,
        }
    }

    /// Adds a place.
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Finding {
        if span.is_defined() {
            self.labels.push(Label {
                span,
                text: text.into(),
            });
        }
        self
    }

    /// Adds a place, if nothing is said of it yet.
    pub(crate) fn at_another(self, span: Span, text: impl Into<String>) -> Finding {
        match self.labels.iter().any(|label| label.span == span) {
            true => self,
            false => self.at(span, text),
        }
    }

    /// Says which resource's plain stores it is about.
    pub(crate) fn about(mut self, stored: Option<Handle<GlobalVariable>>) -> Finding {
        self.stored = stored;
        self
    }

    /// Says what the author can do.
    pub fn help(mut self, help: impl Into<String>) -> Finding {
        self.help = Some(help.into());
        self
    }

    /// The finding as text, with the lines of source that it is about, as naga renders its own errors.
    pub fn render(&self, source: &Source, color: Color) -> String {
        let severity = match self.code.severity() {
            Severity::Refusal => CodespanSeverity::Error,
            Severity::Warning => CodespanSeverity::Warning,
        };
        let labels = self.labels.iter().enumerate().filter_map(|(index, label)| {
            let (file, range) = source.locate(label.span)?;
            let label_at = match index {
                0 => CodespanLabel::primary(file, range),
                _ => CodespanLabel::secondary(file, range),
            };
            Some(label_at.with_message(&label.text))
        });
        let diagnostic = Diagnostic::new(severity)
            .with_code(self.code.to_string())
            .with_message(&self.message)
            .with_labels(labels.collect())
            .with_notes(
                self.help
                    .iter()
                    .map(|help| format!("help: {help}"))
                    .collect(),
            );
        emit(&diagnostic, source, color).unwrap_or_else(|| format!("{self}\n"))
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}] {}", self.code, self.message)
    }
}

/// Whether rendered text carries terminal colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Color {
    /// Plain text.
    #[default]
    Never,
    /// ANSI colours.
    Always,
}

/// Renders a diagnostic, in colour or not. `None` if a label lies outside its file, which [`Source::locate`] rules out.
pub(crate) fn emit(
    diagnostic: &Diagnostic<usize>,
    source: &Source,
    color: Color,
) -> Option<String> {
    let mut buffer = match color {
        Color::Always => termcolor::Buffer::ansi(),
        Color::Never => termcolor::Buffer::no_color(),
    };
    term::emit_to_write_style(
        &mut buffer,
        &term::Config::default(),
        &source.codespan_files(),
        diagnostic,
    )
    .ok()?;
    Some(String::from_utf8_lossy(buffer.as_slice()).into_owned())
}

/// Why an entry point was not rewritten: one finding or several, the weightiest first.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}", .findings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
pub struct Refusal {
    /// The reasons.
    pub findings: Vec<Finding>,
}

impl Refusal {
    /// All findings as text.
    pub fn render(&self, source: &Source, color: Color) -> String {
        self.findings
            .iter()
            .map(|finding| finding.render(source, color))
            .collect()
    }
}

impl From<Finding> for Refusal {
    fn from(finding: Finding) -> Refusal {
        Refusal {
            findings: vec![finding],
        }
    }
}
