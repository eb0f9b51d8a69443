//! `vrcs tradeoff`: what accuracy costs in time.
//!
//! Does: tries settings on the scenes, measures error and time of each, writes a page, tables and a plot.
//! Needs: a device with timestamps; a software driver will do.
//! Guarantees: an interrupted study leaves a report of what it had, and goes on where it was, from the journal in its folder.
//! Refuses: unknown scenes and settings, a sweep of nothing, pictures that the device cannot hold.

use std::path::{Path, PathBuf};

use super::{Failure, batch::build_of_the_program, files, parse_size, talk};
use crate::{
    check::gpu::Gpu,
    scenes::SceneName,
    tradeoff::{
        Trouble,
        bench::COMPARED,
        report,
        run::{Request, Step, run as study},
        study::{Effect, Point, SceneStudy, Span, Study},
        sweep::{self, Trial},
        turns::Rounds,
    },
};

#[derive(Debug, clap::Args)]
#[command(after_help = "Files, in the folder of --out:
  report.html      everything, in one page that needs no network
  points.csv       a line for each scene and setting
  passes.csv       a line for each of its passes and stages
  study.json       the same and more, for programs
  plot.svg         time against error
  presets.toml     the presets that were chosen for each scene, and why
  points.jsonl     the journal: an interrupted study goes on from it

Examples:
  vrcs tradeoff --quick
  vrcs tradeoff interior foliage --size 1920x1080 --sweep own.toml")]
pub(super) struct Arguments {
    /// interior, foliage, landscape, text, ramps, disocclusion; all of them by default.
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Where the report goes.
    #[arg(long, value_name = "FOLDER", default_value = "tradeoff")]
    out: PathBuf,
    /// Frames of each setting, after a warm-up.
    ///
    /// The last four are compared with full rate, with --quick the last two.
    #[arg(long, value_name = "N", default_value = "8")]
    frames: u32,
    /// The settings to try; a standard sweep by default.
    ///
    /// TOML with [base], [vary] and [[grid]].
    #[arg(long, value_name = "FILE.toml", conflicts_with = "quick")]
    sweep: Option<PathBuf>,
    /// Try the presets and a few more settings only.
    ///
    /// Two frames of each are compared with full rate, and the truth is found for one frame.
    #[arg(long)]
    quick: bool,
    /// The size of the pictures.
    ///
    /// By default 1920x1080 on a GPU and 640x360 on a software driver.
    #[arg(long, value_parser = parse_size, value_name = "WxH")]
    size: Option<[u32; 2]>,
    /// Where all chance comes from.
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// The adapter: a part of its name. See `vrcs adapters`.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Failure {
        match trouble {
            Trouble::Gpu(error) => error.into(),
            Trouble::Setting(why) => Failure::Misused(why),
            // drivers tell in several lines
            other => Failure::Outside(other.to_string().replace('\n', " ")),
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenes = scenes(&arguments.scenes)?;
    let trials = trials(arguments)?;
    if arguments.frames == 0 {
        return Err(Failure::Misused(
            "a study needs one frame or more".to_owned(),
        ));
    }
    let gpu = Gpu::open(arguments.adapter.as_deref())?;
    let request = Request {
        scenes,
        out: arguments.out.clone(),
        size: size(&gpu, arguments.size)?,
        frames: arguments.frames,
        compared: if arguments.quick { 2 } else { COMPARED },
        rounds: rounds(&gpu, arguments.quick),
        trials,
        effects: true,
        chooses: true,
        truth: if arguments.quick { 1 } else { 3 },
        seed: arguments.seed,
        command: command(),
        build: build_of_the_program(),
    };
    let found = study_with_bar(&gpu, &request)?;
    print(&found, &request.out)
}

/// Runs a study under a bar; where nobody sees one, each step is a line.
pub(super) fn study_with_bar(gpu: &Gpu, request: &Request) -> Result<Study, Failure> {
    let mut steps = request.steps();
    let bar = talk::Progress::new(steps);
    let mut done = 0;
    let begun = std::time::Instant::now();
    let found = study(gpu, request, &mut |step| match step {
        Step::More(more) => {
            steps += more;
            bar.lengthen(more);
        }
        Step::Done(name) => {
            done += 1;
            match bar.is_seen() {
                true => bar.step(name),
                false => {
                    let seconds = begun.elapsed().as_secs_f64();
                    talk::say(&format!("{done}/{steps} {name}, {seconds:.0} s"));
                }
            }
        }
    });
    bar.done();
    let found = found?;
    for line in found.scenes.iter().flat_map(|scene| &scene.left_out) {
        talk::say(line);
    }
    Ok(found)
}

fn scenes(names: &[String]) -> Result<Vec<SceneName>, Failure> {
    let mut scenes = Vec::new();
    for name in names {
        let scene: SceneName = name
            .parse()
            .map_err(|error: crate::scenes::UnknownScene| Failure::Misused(error.to_string()))?;
        if !scenes.contains(&scene) {
            scenes.push(scene);
        }
    }
    Ok(match scenes.is_empty() {
        true => SceneName::ALL.to_vec(),
        false => scenes,
    })
}

fn trials(arguments: &Arguments) -> Result<Vec<Trial>, Failure> {
    match (&arguments.sweep, arguments.quick) {
        (None, true) => Ok(sweep::quick()),
        (None, false) => Ok(sweep::standard()),
        (Some(path), _) => {
            let text = files::read_text(path)?;
            sweep::parse(&text).map_err(|error| {
                Failure::Misused(format!("{}: {error}", files::display_name(path)))
            })
        }
    }
}

/// The size asked for, or what suits the device.
pub(super) fn size(gpu: &Gpu, asked: Option<[u32; 2]>) -> Result<[u32; 2], Failure> {
    let size = asked.unwrap_or(match gpu.is_software() {
        true => [640, 360],
        false => [1920, 1080],
    });
    let limit = gpu.device.limits().max_texture_dimension_2d;
    match size.iter().any(|&side| side > limit) {
        true => Err(Failure::Misused(format!(
            "the picture can be at most {limit} pixels wide and high on {}",
            gpu.info.name
        ))),
        false => Ok(size),
    }
}

/// Timed rounds. A software driver's take long.
pub(super) fn rounds(gpu: &Gpu, is_quick: bool) -> Rounds {
    let (warm, counted) = match (gpu.is_software(), is_quick) {
        (true, true) => (1, 8),
        (true, false) => (1, 12),
        (false, true) => (10, 32),
        (false, false) => (10, 64),
    };
    // a software driver shares its machine, whose other work a few more rounds do not outwait
    let most = match gpu.is_software() {
        true => counted + counted / 2,
        false => counted * 3,
    };
    Rounds {
        warm,
        counted,
        most,
    }
}

/// The command as it was given, without the program's folder.
pub(super) fn command() -> String {
    let rest: Vec<String> = std::env::args().skip(1).collect();
    format!("vrcs {}", rest.join(" "))
}

/// The presets and the front of each scene, as a table.
pub(super) fn print(study: &Study, out: &Path) -> Result<(), Failure> {
    talk::data(&format!(
        "{}, {}x{}, {} frames",
        study.adapter, study.size[0], study.size[1], study.frames
    ))?;
    for scene in &study.scenes {
        print_scene(scene)?;
    }
    if let Some(summary) = &study.summary {
        talk::data("")?;
        for sentence in &summary.verdict {
            talk::data(sentence)?;
        }
    }
    for name in [
        "report.html",
        "points.csv",
        "passes.csv",
        "study.json",
        "plot.svg",
        "presets.toml",
    ] {
        talk::data(&format!("{:<10} {}", "written", out.join(name).display()))?;
    }
    Ok(())
}

fn print_scene(scene: &SceneStudy) -> Result<(), Failure> {
    talk::data("")?;
    talk::data(&format!(
        "{:<34} {:>9} {:>9} {:>21} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6}",
        scene.name, "ms", "full rate", "time", "shaded", "retired", "FLIP", "p99", "SSIM", "PSNR"
    ))?;
    let front = report::front_of(scene);
    let shown = |index: &usize| {
        let is_preset = scene.points[*index].preset.is_some();
        is_preset || front.contains(index) || !scene.presets_of(*index).is_empty()
    };
    let mut order: Vec<usize> = (0..scene.points.len()).filter(shown).collect();
    order.sort_by(|&a, &b| {
        let share = |i: usize| scene.points[i].time.share.median;
        share(b).total_cmp(&share(a))
    });
    for index in order {
        print_point(&scene.points[index], front.contains(&index))?;
    }
    if let Some(point) = scene.points.iter().find(|point| !point.time.is_steady) {
        talk::data(&format!(
            "the machine was not steady: the control was up to {:.0} % off its median, so that all rounds count",
            100.0 * point.time.drift
        ))?;
    }
    for chosen in &scene.chosen {
        let name = &scene.points[chosen.point].name;
        let because = chosen.because.join(" ");
        talk::data(&format!(
            "{} for {} is {name}. {because}",
            chosen.preset, scene.name
        ))?;
    }
    for point in scene.points.iter().filter(|p| p.preset.is_some()) {
        let name = &point.name;
        talk::data(&match report::break_even_ms(point) {
            Some(0.0) => format!("{name}: no machinery"),
            Some(ms) => {
                format!("{name} pays where these passes take more than {ms:.3} ms at full rate")
            }
            None => format!("{name} saves no shading time here"),
        })?;
    }
    for effect in &scene.effects {
        print_effect(effect)?;
    }
    if let Some(truth) = &scene.truth
        && let Some(paper) = truth.curve.iter().find(|at| (at.t - 0.15).abs() < 1e-9)
    {
        talk::data(&format!(
            "the paper's analysis at t 0.15: {:.1} % of quads too coarse, {:.1} % too fine",
            100.0 * paper.too_coarse,
            100.0 * paper.too_fine
        ))?;
    }
    Ok(())
}

fn print_effect(effect: &Effect) -> Result<(), Failure> {
    let shown = |span: &Span| match span.is_within_noise() {
        true => "within noise".to_owned(),
        false => format!("{:+.3} ms", span.median),
    };
    talk::data(&format!(
        "{} adds {} of machinery, {} to the frame, {:+.1} % of pixels shaded",
        effect.name,
        shown(&effect.machinery_ms),
        shown(&effect.frame_ms),
        100.0 * effect.primaries
    ))
}

fn print_point(point: &Point, on_front: bool) -> Result<(), Failure> {
    let mark = if on_front { "*" } else { " " };
    let name: String = point.name.chars().take(32).collect();
    let (seen, time) = (&point.seen, &point.time);
    let psnr = match seen.error.psnr {
        Some(psnr) => format!("{psnr:.1}"),
        None => "equal".to_owned(),
    };
    let span = format!(
        "{:.1} % [{:.1}, {:.1}]",
        100.0 * time.share.median,
        100.0 * time.share.low,
        100.0 * time.share.high
    );
    talk::data(&format!(
        "{mark} {name:<32} {:>9.3} {:>9.3} {span:>21} {:>5.1} % {:>5.1} % {:>7.4} {:>7.4} {:>7.4} {psnr:>6}",
        time.variable_ms,
        time.full_ms,
        100.0 * seen.primary_share,
        100.0 * seen.retired_share,
        seen.error.flip_mean,
        seen.error.flip_p99,
        seen.error.ssim,
    ))
}
