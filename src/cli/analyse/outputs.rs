//! The files that are written: which, what is in them, and that none takes the place of what is read.

use std::path::{Path, PathBuf};

use super::{
    Arguments,
    device::Found,
    overlay,
    picture::{Picture, grey_png},
};
use crate::{
    atomic::Pending,
    attach::cpu::Attachment,
    cli::{Failure, files},
    sri::Sri,
};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "What is written")]
pub(super) struct OutputFiles {
    /// Where the rates go, as a grey PNG.
    #[arg(short, long, value_name = "SRI.png")]
    pub(super) output: Option<PathBuf>,
    /// Where a picture goes that shows the rates.
    #[arg(long, value_name = "FILE.png")]
    pub(super) overlay: Option<PathBuf>,
    /// Where the image for hardware goes, as a grey PNG.
    #[arg(long, value_name = "FILE.png", requires = "attachment")]
    pub(super) attachment_output: Option<PathBuf>,
    /// Where the reasons go, as a grey PNG.
    #[arg(long, value_name = "FILE.png")]
    pub(super) reasons: Option<PathBuf>,
    /// Where the rates of half the resolution go, for passes that run at it.
    #[arg(long = "half-output", value_name = "SRI.png", hide_short_help = true)]
    pub(super) half: Option<PathBuf>,
    /// Where the rates without the extra half rate go, for passes that add no noise.
    #[arg(long = "plain-output", value_name = "SRI.png", hide_short_help = true)]
    pub(super) plain: Option<PathBuf>,
    /// Where √luma of what is analysed goes, which later frames can use in place of its colour.
    #[arg(long = "luma-output", value_name = "FILE.png", hide_short_help = true)]
    pub(super) luma: Option<PathBuf>,
}

impl OutputFiles {
    /// All that are named.
    pub(super) fn paths(&self) -> impl Iterator<Item = &Path> {
        [
            &self.output,
            &self.overlay,
            &self.attachment_output,
            &self.reasons,
            &self.half,
            &self.plain,
            &self.luma,
        ]
        .into_iter()
        .filter_map(|path| path.as_deref())
    }
}

/// What is written.
pub(super) struct Made<'a> {
    /// The picture that was named.
    pub(super) picture: &'a Picture,
    /// The rates.
    pub(super) sri: &'a Sri,
    /// All else that was found.
    pub(super) found: &'a Found,
    /// The size of what was analysed.
    pub(super) analysed_size: [u32; 2],
    /// The image for hardware variable-rate shading.
    pub(super) attachment: Option<&'a Attachment>,
}

/// Refuses outputs that are inputs, streams, or each other.
pub(super) fn refuse_to_overwrite(arguments: &Arguments) -> Result<(), Failure> {
    let paths: Vec<&Path> = arguments.outputs.paths().collect();
    for (index, path) in paths.iter().enumerate() {
        if files::is_stream(path) {
            return Err(Failure::Misused(
                "pictures are written to files; the results are what standard output is for"
                    .to_owned(),
            ));
        }
        let mut inputs = arguments
            .given
            .paths()
            .chain([&arguments.image])
            .chain(arguments.options.settings_path());
        if inputs.any(|input| files::is_same(path, input)) {
            return Err(Failure::Misused(format!(
                "{}: this would overwrite what is analysed",
                path.display()
            )));
        }
        if paths[..index]
            .iter()
            .any(|other| files::is_same(path, other))
        {
            return Err(Failure::Misused(format!(
                "{}: two outputs cannot go to one file",
                path.display()
            )));
        }
    }
    Ok(())
}

/// The codes of an image of rates, as a grey PNG.
fn codes(sri: &Sri) -> Vec<u8> {
    let layout = sri.layout();
    grey_png([layout.width, layout.height], |x, y| sri.code(x, y))
}

/// Writes all files: first each beside its place, then, when all are there, into their places.
pub(super) fn write(arguments: &Arguments, made: &Made) -> Result<(), Failure> {
    let files = &arguments.outputs;
    let found = made.found;
    let layout = made.sri.layout();
    let attachment = made.attachment.map(|attachment| {
        let layout = attachment.layout();
        grey_png([layout.width, layout.height], |x, y| {
            attachment.texel(x, y).unwrap_or_default()
        })
    });
    let reasons = || {
        grey_png([layout.width, layout.height], |x, y| {
            found.reasons[(y * layout.pitch + x) as usize]
        })
    };
    let luma = || {
        let pitch = crate::analyse::params::luma_pitch(made.analysed_size[0]);
        grey_png(made.analysed_size, |x, y| {
            found.sqrt_luma[(y * pitch + x) as usize]
        })
    };
    let all = [
        (
            &files.output,
            files.output.as_ref().map(|_| codes(made.sri)),
        ),
        (&files.attachment_output, attachment),
        (&files.reasons, files.reasons.as_ref().map(|_| reasons())),
        (
            &files.overlay,
            files
                .overlay
                .as_ref()
                .map(|_| overlay::draw(made.picture, made.sri)),
        ),
        (&files.half, found.half.as_ref().map(codes)),
        (
            &files.plain,
            files.plain.as_ref().map(|_| codes(&found.plain)),
        ),
        (&files.luma, files.luma.as_ref().map(|_| luma())),
    ];
    let mut pending: Vec<(&Path, Pending)> = Vec::new();
    for (path, png) in &all {
        if let (Some(path), Some(png)) = (path, png) {
            pending.push((path, files::prepare(path, png)?));
        }
    }
    for (path, file) in pending {
        file.appear()
            .map_err(|error| files::unwritable(path, &error))?;
    }
    Ok(())
}
