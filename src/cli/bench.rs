//! `vrcs bench`

use super::{Failure, parse_size, talk};
use crate::{
    bench::{Bench, BenchError, Found, Row},
    check::gpu::Gpu,
};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  vrcs bench
  vrcs bench --filter heavy --json > heavy.json
  vrcs bench --size 1920x1080 --adapter nvidia")]
pub(super) struct Arguments {
    /// Print what was found as JSON.
    #[arg(long)]
    json: bool,
    /// Only rows whose name contains this.
    ///
    /// The rows are identity, heavy, light, classified, indirect, barriers, build, encodings, stage, machinery, resolution and rewrite.
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// The size of the picture.
    #[arg(long, value_parser = parse_size, default_value = "3840x2160", value_name = "WxH")]
    size: [u32; 2],
    /// Rounds that are counted, after a warm-up.
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(3..=400), value_name = "N")]
    rounds: u32,
    /// Lights of the heavy pass.
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65536), value_name = "N")]
    lights: u32,
    /// Megabytes of inputs that are rotated, so that no cache flatters.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=4096), value_name = "MB")]
    rotated: u32,
    /// The adapter: a part of its name. See `vrcs adapters`.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let gpu = Gpu::open(arguments.adapter.as_deref())?;
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if arguments.size.iter().any(|&side| side > limit || side < 16) {
        return Err(Failure::Misused(format!(
            "the picture has to be 16 to {limit} pixels wide and high on {}",
            gpu.info.name
        )));
    }
    let bench = Bench {
        size: arguments.size,
        rounds: arguments.rounds as usize,
        filter: arguments.filter.clone(),
        lights: arguments.lights,
        rotated: u64::from(arguments.rotated) << 20,
    };
    let found = bench.run(&gpu, &mut talk::status);
    talk::status_done();
    let found = found.map_err(|error| match error {
        BenchError::Gpu(error) => error.into(),
        BenchError::NoRow(_) => Failure::Misused(error.to_string()),
        error => Failure::Outside(error.to_string()),
    })?;
    match arguments.json {
        true => {
            let text = serde_json::to_string_pretty(&found)
                .map_err(|error| Failure::Outside(error.to_string()))?;
            talk::data(&text)
        }
        false => print(&found),
    }
}

fn print(found: &Found) -> Result<(), Failure> {
    talk::data(&format!(
        "{} ({}), {}x{}",
        found.device,
        found.driver.trim(),
        found.size[0],
        found.size[1]
    ))?;
    talk::data(match found.validates_indirect {
        true => "wgpu validates the arguments of indirect dispatches",
        false => {
            "wgpu does not validate the arguments of indirect dispatches; a row tells what that costs"
        }
    })?;
    if found.is_software {
        talk::data("a software driver: its times say nothing of goals, and none is called met")?;
    }
    let width = found.rows.iter().map(|row| row.name.chars().count()).max();
    for row in &found.rows {
        print_row(row, width.unwrap_or_default())?;
    }
    Ok(())
}

fn print_row(row: &Row, width: usize) -> Result<(), Failure> {
    let number = |value: f64| match row.unit {
        "x" => format!("{value:.3}"),
        unit => format!("{value:.1} {unit}"),
    };
    let verdict = match row.met {
        Some(true) => "met",
        Some(false) => "missed",
        None => "",
    };
    let padding = " ".repeat(width - row.name.chars().count());
    let parts: Vec<String> = row
        .parts
        .iter()
        .map(|part| format!("{} {:.4} ms", part.name, part.milliseconds))
        .collect();
    let drift = row.drift.map_or(String::new(), |drift| {
        let scaled = if drift.is_scaled {
            ", scaled by the control"
        } else {
            ""
        };
        format!(
            "; control {:.3} x, {} rounds, {} not counted{scaled}",
            drift.control, drift.counted, drift.rejected
        )
    });
    talk::data(&format!(
        "{}{padding}  {:>10}  goal {:>10}  {verdict:6}  {}{drift}",
        row.name,
        number(row.value),
        number(row.goal),
        parts.join(", ")
    ))
}
