//! `vrcs demo`

use std::path::{Path, PathBuf};

use vrcs_passes::Source;

use super::{Failure, files, parse_size, talk};
use crate::{
    analyse::content::Sensitivity,
    check::{Verdict, gpu::Gpu},
    demo::{Demo, DemoError, Shown},
    web,
};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Where the pictures go.
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    out: PathBuf,
    /// The size of the picture.
    #[arg(long, value_parser = parse_size, default_value = "1280x720", value_name = "WxH")]
    size: [u32; 2],
    /// How large a difference may be, as a share of the luma around it: the paper's t, which is 0.15 for a 4K display at
    /// arm's length, and less for larger pixels.
    #[arg(long, default_value_t = 0.06, value_name = "T")]
    threshold: f64,
    /// The adapter: a part of its name. See `vrcs adapters`.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Write a page instead, `index.html` in this folder, that runs the original and the rewritten shader in the browser's own WebGPU;
    /// needs no GPU here.
    #[arg(long, value_name = "FOLDER")]
    web: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.threshold.is_nan() || arguments.threshold < 0.0 {
        return Err(Failure::Misused(
            "the threshold has to be 0 or more".to_owned(),
        ));
    }
    if let Some(folder) = &arguments.web {
        return write_page(folder, arguments.size);
    }
    let gpu = Gpu::open(arguments.adapter.as_deref())?;
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if arguments.size.iter().any(|&side| side > limit) {
        return Err(Failure::Misused(format!(
            "the picture can be at most {limit} pixels wide and high on {}",
            gpu.info.name
        )));
    }
    let demo = Demo {
        size: arguments.size,
        out: arguments.out.clone(),
        sensitivity: Sensitivity {
            threshold: arguments.threshold,
            ..Sensitivity::default()
        },
    };
    let shown = demo.run(&gpu, &mut talk::status);
    talk::status_done();
    let shown = shown.map_err(|error| match error {
        DemoError::Gpu(error) => error.into(),
        error => Failure::Outside(error.to_string()),
    })?;
    print(&shown)?;
    match shown.laws.verdict {
        Verdict::Passed => Ok(()),
        _ => Err(Failure::Refused("the laws do not hold".to_owned())),
    }
}

fn write_page(folder: &Path, size: [u32; 2]) -> Result<(), Failure> {
    let source = Source::new("plaza.wgsl", crate::demo::SCENE);
    let page =
        web::page(&source, "plaza", size).map_err(|error| Failure::Outside(error.to_string()))?;
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Outside(format!("{}: {error}", folder.display())))?;
    let path = folder.join("index.html");
    crate::atomic::write(&path, page.as_bytes())
        .map_err(|error| files::unwritable(&path, &error))?;
    talk::data(&path.display().to_string())
}

fn print(shown: &Shown) -> Result<(), Failure> {
    let times = &shown.times;
    let share = |part: f64| format!("{part:8.2} ms  {:5.1} %", 100.0 * part / times.original);
    let rates: Vec<String> = shown
        .rates
        .iter()
        .map(|(rate, share)| format!("{rate} {:.1} %", 100.0 * share))
        .collect();
    let held: u32 = shown.laws.held.values().sum();
    let laws = match shown.laws.verdict {
        Verdict::Passed => format!(
            "{} of {}, in {held} trials",
            shown.laws.held.len(),
            shown.laws.held.len()
        ),
        _ => format!(
            "NO: {}",
            shown
                .laws
                .why
                .clone()
                .unwrap_or_else(|| format!("{:?}", shown.laws.failure))
        ),
    };
    let psnr = |psnr: f64| match psnr.is_infinite() {
        true => "equal".to_owned(),
        false => format!("{psnr:.1} dB"),
    };
    let clock = match times.by_gpu {
        true => "GPU timestamps",
        false => "the host's clock",
    };
    let statistics = &shown.statistics;
    let rows = [
        ("adapter", shown.adapter.clone()),
        ("picture", format!("{}x{}", shown.size[0], shown.size[1])),
        ("rates", rates.join(", ")),
        (
            "primaries",
            format!("{:.1} % of pixels", 100.0 * statistics.primary_share()),
        ),
        (
            "waves retired",
            format!("{:.1} %", 100.0 * statistics.retired_share()),
        ),
        ("original shader", share(times.original)),
        ("rewritten, all 1x1", share(times.identity)),
        ("rewritten", share(times.variable)),
        ("coordinate build", share(times.build)),
        ("deblocker", share(times.deblock)),
        ("times from", clock.to_owned()),
        ("PSNR", psnr(shown.psnr)),
        ("PSNR, deblocked", psnr(shown.psnr_deblocked)),
        ("laws held", laws),
    ];
    for (name, value) in rows {
        talk::data(&format!("{name:<20} {value}"))?;
    }
    for picture in &shown.pictures {
        talk::data(&format!("{:<20} {}", "picture written", picture.display()))?;
    }
    Ok(())
}
