//! The program's command line.
//!
//! Results go to standard output, all else to standard error. Exit status: 0 done, 1 refused or failed, 2 misused, 3 input/output
//! or device.

mod analyse;
mod batch;
mod bench;
mod check;
mod demo;
mod explain;
mod files;
mod generate;
mod inputs;
mod make;
mod plan;
mod rewrite;
mod talk;
mod tradeoff;
mod watch;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::check::gpu::GpuError;

/// Makes compute shaders variable-rate, and proves on a real driver that they still do what they did.
#[derive(Debug, Parser)]
#[command(
    name = "vrcs",
    version,
    max_term_width = 100,
    after_help = "Examples:
  vrcs rewrite lighting.wgsl -o lighting.vrcs.wgsl --manifest lighting.json
  vrcs explain lighting.wgsl
  vrcs check lighting.wgsl --size 320x200 --cases 200
  vrcs demo --out out

Exit status: 0 done, 1 refused or failed, 2 misused, 3 input/output or device."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Rewrite shaders into variable-rate ones. Needs no GPU.
    Rewrite(rewrite::Arguments),
    /// Tell what is made of a shader and why, or what a code means. Needs no GPU.
    Explain(explain::Arguments),
    /// Prove a rewrite on a driver, over many shading rates, bit for bit.
    Check(check::Arguments),
    /// Tell how coarse a picture may be shaded: rates, overlay, hardware's image.
    Analyse(Box<analyse::Arguments>),
    /// Tell what an analysis of a scene compiles, binds and dispatches. Needs no GPU.
    Plan(plan::Arguments),
    /// Shade a scene at full and at variable rate; write pictures, print what it saved.
    Demo(demo::Arguments),
    /// Tell what accuracy costs in time: settings on scenes, a report.
    Tradeoff(tradeoff::Arguments),
    /// Measure the goals of speed on a GPU, each against its floor.
    Bench(bench::Arguments),
    /// List the codes of refusals and warnings, with what they mean.
    Codes(explain::Codes),
    /// List the adapters that `check` and `demo` can run on.
    Adapters,
    /// Print the completions for a shell.
    Completions(generate::Completions),
    /// Write the man pages.
    Man(generate::Man),
    /// One check, in a process of its own: what `check` starts. Its name is like no word that a user could mean.
    #[command(name = check::child::NAME, hide = true)]
    CheckChild,
}

/// Why the program ends without having done what was asked.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A shader was refused, or a check failed. The reasons have been told, or are told here.
    Refused(String),
    /// The arguments make no sense together.
    Misused(String),
    /// A file or the device did not do what it should.
    Outside(String),
}

impl Failure {
    fn status(&self) -> u8 {
        match self {
            Failure::Refused(_) => 1,
            Failure::Misused(_) => 2,
            Failure::Outside(_) => 3,
        }
    }

    fn message(&self) -> &str {
        match self {
            Failure::Refused(message) | Failure::Misused(message) | Failure::Outside(message) => {
                message
            }
        }
    }
}

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Failure {
        match error {
            GpuError::NoSuchAdapter { .. } => Failure::Misused(error.to_string()),
            _ => Failure::Outside(error.to_string()),
        }
    }
}

/// Runs the program with the process's own arguments.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // a reader that has gone away is not told
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    let outcome = match arguments.command {
        Command::Rewrite(arguments) => rewrite::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Codes(arguments) => explain::codes(&arguments),
        Command::Completions(arguments) => generate::completions(&arguments),
        Command::Man(arguments) => generate::man(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Analyse(arguments) => analyse::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Tradeoff(arguments) => tradeoff::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Adapters => adapters(),
        Command::CheckChild => check::child::run(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !failure.message().is_empty() {
                talk::error(failure.message());
            }
            ExitCode::from(failure.status())
        }
    }
}

fn adapters() -> Result<(), Failure> {
    let adapters = crate::check::gpu::adapters();
    if adapters.is_empty() {
        return Err(GpuError::NoDriver.into());
    }
    for adapter in adapters {
        let info = adapter.get_info();
        let kind = match info.device_type {
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::DiscreteGpu => "discrete GPU",
            wgpu::DeviceType::IntegratedGpu => "integrated GPU",
            wgpu::DeviceType::VirtualGpu => "virtual GPU",
            wgpu::DeviceType::Other => "other",
        };
        talk::data(&format!(
            "{}\t{:?}\t{kind}\t{} {}",
            info.name, info.backend, info.driver, info.driver_info
        ))?;
    }
    Ok(())
}

/// A picture's size on the command line: `WIDTHxHEIGHT`.
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides: Option<Vec<u32>> = text.split('x').map(|side| side.parse().ok()).collect();
    match sides.as_deref() {
        Some(&[width, height]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("a size is WIDTHxHEIGHT, for example 640x360".to_owned()),
    }
}
