//! `xtask sweep`: the main job. Every split method, every kind of ray, what each costs.

mod builds;
pub mod configuration;
mod json;
mod report;
mod run;

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;

use self::configuration::{KernelName, Layout, WidthName};
use crate::input::{SCENE_HELP, SceneSource, SplitMethodName};

#[derive(Args)]
pub struct Arguments {
    #[arg(help = SCENE_HELP, value_name = "SCENE", value_parser = SceneSource::parse, default_value = "builtin:stadium")]
    scenes: Vec<SceneSource>,
    /// The split methods to build with; all by default
    #[arg(long, value_enum, value_delimiter = ',', value_name = "METHOD")]
    split_method: Vec<SplitMethodName>,
    /// The layouts of trees over meshes; both by default
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LAYOUT")]
    layout: Vec<Layout>,
    /// The SIMD widths to traverse wide trees with; all that the processor has by default
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WIDTH")]
    simd_width: Vec<WidthName>,
    /// The box test and triangle test in binary trees; all by default, to show what the naive ones lose
    #[arg(long, value_enum, value_delimiter = ',', value_name = "KERNELS")]
    kernels: Vec<KernelName>,
    /// Rays of each kind, at most
    #[arg(long, default_value_t = 1 << 16, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    rays: u32,
    /// Rays of each kind whose answers are compared with the exact ones, and rays for each kind of leak; 0 for none. Most
    /// of a sweep's time goes there
    #[arg(long, default_value_t = 1024, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1 << 24))]
    judged_rays: u32,
    /// Timed rounds, of builds and then of traces; each goes through all configurations in turn, and the median counts.
    /// Scenes of more than 3 million primitives are built in one timed round
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Threads that build; rays are always traced by one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// Where results.jsonl goes
    #[arg(long, default_value = "target/sweep/latest", value_name = "DIR")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads.unwrap_or(0) as usize).build()?;
    let mut sweeps = Vec::new();
    for source in &arguments.scenes {
        let sweep = run::sweep(arguments, source, &pool)?;
        report::print(&sweep, pool.current_num_threads());
        sweeps.push(sweep);
    }
    if sweeps.len() > 1 {
        report::print_growth(&sweeps);
    }
    let path = arguments.out.join("results.jsonl");
    std::fs::create_dir_all(&arguments.out)
        .and_then(|()| std::fs::write(&path, json::json_lines(&sweeps)))
        .with_context(|| format!("{}: cannot be written", path.display()))?;
    println!("results  {}", path.display());
    sweeps.iter().try_for_each(run::Sweep::check)
}
