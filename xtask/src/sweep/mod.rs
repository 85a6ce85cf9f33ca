//! `xtask sweep`: the main job. Which configuration is the fastest at the error that one accepts?
//!
//! Data goes one way: [`settings`] (command line, sweep file) → [`plan`] (jobs, as data) → [mod@run] (jobs at work) →
//! [`results`] (a file each) → [`rows`] (what tables show) → [`tables`] for people, [`lines`] for programs, [`report`]
//! for colleagues. `merge` begins at the results.

mod command;
mod configuration;
mod effort;
mod host;
mod jobs;
mod leak_maps;
mod lines;
pub mod merge;
mod occlusion;
mod plan;
mod quality;
pub mod report;
mod results;
mod rows;
mod run;
mod settings;
mod shard;
pub mod subject;
mod sweep_file;
mod tables;
mod verdict;
mod workshop;

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;

use self::configuration::{Calls, KernelName, Layout};
use self::plan::{Job, Plan};
use self::report::Section;
use self::results::{Folder, JobResult};
use self::rows::Sweep;
use self::settings::{RaySetName, RaysArgument, Settings, WidthChoice, parse_duration};
use self::shard::ShardArgument;
use crate::input::{SCENE_HELP, SceneSource, SplitMethodName};
use crate::measure::now;
use crate::museum::{self, page};

#[derive(Args)]
pub struct Arguments {
    #[arg(help = SCENE_HELP, value_name = "SCENE", value_parser = SceneSource::parse)]
    scenes: Vec<SceneSource>,
    /// The split methods and presets to build with
    #[arg(long, value_enum, value_delimiter = ',', value_name = "METHOD")]
    split_method: Vec<SplitMethodName>,
    /// The layouts of trees over meshes
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LAYOUT")]
    layout: Vec<Layout>,
    /// The SIMD widths to traverse wide trees with
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WIDTH")]
    simd_width: Vec<WidthChoice>,
    /// Whether wide trees are asked ray by ray, many at once, or ray by ray on all threads
    #[arg(long, value_enum, value_delimiter = ',', value_name = "CALLS")]
    calls: Vec<Calls>,
    /// The box test and triangle test in binary trees; all by default, to show what the naive ones lose
    #[arg(long, value_enum, value_delimiter = ',', value_name = "KERNELS")]
    kernels: Vec<KernelName>,
    /// The most primitives in a leaf of binary trees
    #[arg(long, value_delimiter = ',', value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65535))]
    leaf_size: Vec<u32>,
    /// The sets of rays that are generated
    #[arg(long, value_enum, value_delimiter = ',', value_name = "SET")]
    ray_set: Vec<RaySetName>,
    /// Rays of each generated set, at most; or a file of your engine's own (.rays or .npy, see `trace --help`), which
    /// then stand for the generated ones unless --ray-set asks for these. May be given more than once
    #[arg(long, value_name = "N|FILE", value_parser = RaysArgument::parse)]
    rays: Vec<RaysArgument>,
    /// The camera of primary rays and pictures, as `render --camera` takes it: it looks from outside where a file has
    /// none
    #[arg(long, value_name = "SETTINGS", value_parser = settings::parse_camera)]
    camera: Option<String>,
    /// Rays of each set whose answers are compared with the exact ones, and rays for each kind of leak; 0 for none
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1 << 24))]
    judged_rays: Option<u32>,
    /// Timed rounds; each goes through all configurations in turn, and the median counts. Scenes of more than 3 million
    /// primitives are built in one timed round
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), conflicts_with = "budget")]
    rounds: Option<u32>,
    /// Time for each scene: rounds go on until then (90s, 2m, 1h); one is made whatever it takes
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    budget: Option<Duration>,
    /// Fewer rays, smaller pictures, about ten seconds
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// More rays, larger pictures, nine rounds, whatever they take
    #[arg(long)]
    full: bool,
    /// Threads that build, and that trace where calls are parallel; all by default. Other calls trace on one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// Whether pictures are drawn, and the museum is shown
    #[arg(long, value_name = "BOOL")]
    pictures: Option<bool>,
    /// Whether trees are kept in files, to see when that pays
    #[arg(long, value_name = "BOOL")]
    cache: Option<bool>,
    /// A sweep file: scenes, rays and configurations of your own. Options go before what it says
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// Print the built-in sweep file, and do nothing else
    #[arg(long)]
    print_config: bool,
    /// Print the plan, a line of JSON for each job, and do nothing else
    #[arg(long)]
    list: bool,
    /// Do a part of the jobs: 3/8, or auto where a scheduler's variables say which (auto/8 where it does not say of how
    /// many). `merge` makes the report of all
    #[arg(long, value_name = "I/N", value_parser = ShardArgument::parse)]
    shard: Option<ShardArgument>,
    /// Begin anew instead of keeping what an earlier run of the same plan left
    #[arg(long)]
    fresh: bool,
    /// Where report.html, results.jsonl, results.csv and the pictures go
    #[arg(long, default_value = "target/sweep/latest", value_name = "DIR")]
    out: PathBuf,
}

/// The exit code after Ctrl-C, as shells have it.
pub const INTERRUPTED: i32 = 130;

/// The exit code of a merge that lacks jobs.
pub const INCOMPLETE: u8 = 3;

/// Why there is no report of everything.
#[derive(Debug)]
pub struct Incomplete {
    missing: Vec<String>,
    of: usize,
}

impl fmt::Display for Incomplete {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} jobs are missing: {}", self.missing.len(), self.of, self.missing.join(" "))
    }
}

impl std::error::Error for Incomplete {}

/// The exit code that belongs to an error of `sweep` or `merge`, where it has one of its own.
pub fn exit_code(error: &anyhow::Error) -> Option<u8> {
    if error.is::<run::Interrupted>() {
        return Some(INTERRUPTED as u8);
    }
    error.is::<Incomplete>().then_some(INCOMPLETE)
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if arguments.print_config {
        print!("{}", sweep_file::DEFAULT);
        return Ok(());
    }
    let settings = Settings::new(arguments)?;
    let shard = arguments.shard.map(|shard| shard.shard(|name| std::env::var(name).ok())).transpose()?;
    let plan = Plan::new(&settings)?;
    let jobs: Vec<&Job> = shard.map_or_else(|| plan.jobs.iter().collect(), |shard| shard.jobs(&plan));
    if arguments.list {
        print!("{}", plan.list(&jobs));
        return Ok(());
    }
    run::watch_for_interrupts();
    let folder = Folder(arguments.out.clone());
    prepare(&folder, &plan, arguments.fresh, shard.is_some())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads.unwrap_or(0) as usize).build()?;
    let done = |folder: &Folder| -> Result<usize> {
        let results = folder.results()?;
        Ok(jobs.iter().filter(|job| results.get(&job.id).is_some_and(|result| result.is_complete)).count())
    };
    let before = done(&folder)?;
    if before > 0 {
        println!("{before} of {} jobs were done before; --fresh does them again", jobs.len());
    }
    let outcome = run::run(&plan, &jobs, settings.rounds, &folder, &pool);
    if outcome.as_ref().is_err_and(|error| error.is::<run::Interrupted>()) {
        println!("kept     {}: the same command goes on from there", folder.0.display());
    }
    outcome?;
    match shard {
        None => publish(&plan, &folder.results()?, &folder),
        Some(shard) => {
            println!("shard    {shard} of plan {} is complete: {} jobs in {}", plan.id, jobs.len(), folder.0.display());
            Ok(())
        }
    }
}

/// Makes the directory ready for the plan's results. Those of another plan are cleared away, unless other shards may be
/// at work there.
fn prepare(folder: &Folder, plan: &Plan, fresh: bool, is_shard: bool) -> Result<()> {
    let is_foreign = |result: &JobResult| result.plan != plan.id;
    if is_shard
        && !fresh
        && let Some(other) = folder.results()?.values().find(|result| is_foreign(result))
    {
        bail!(
            "{}: has results of plan {}, and this is {}; take another --out",
            folder.0.display(),
            other.plan,
            plan.id
        );
    }
    if is_shard && fresh {
        return Err(crate::input::usage_error("--fresh would delete what other shards did; take another --out"));
    }
    if fresh || folder.results()?.values().any(is_foreign) {
        folder.clear()?;
    }
    folder.begin(plan)
}

/// The bugs of the field, as a part of the report.
fn museum() -> Result<Section> {
    /// Counted in each exhibit.
    const RAYS: usize = 4096;
    let html = page::fragment(&museum::findings(&[], RAYS)?, "h3");
    Ok(Section { title: page::TITLE.to_owned(), html })
}

/// Tables, files and the report of results; and whether what must hold does.
fn publish(plan: &Plan, results: &BTreeMap<String, JobResult>, folder: &Folder) -> Result<()> {
    let sweeps = Sweep::all(plan, results);
    for sweep in &sweeps {
        tables::print(sweep);
    }
    if sweeps.len() > 1 {
        tables::print_scenes(&sweeps);
    }
    results::write(&folder.0.join("results.jsonl"), lines::json_lines(&sweeps).as_bytes())?;
    results::write(&folder.0.join("results.csv"), lines::csv(&sweeps).as_bytes())?;
    let museum = plan.pictures.map(|_| museum()).transpose()?;
    let report = report::report(plan, &sweeps, now(), museum.as_slice())?;
    let pictures = folder.0.join("pictures");
    std::fs::create_dir_all(&pictures).with_context(|| format!("{}: cannot be made", pictures.display()))?;
    for (name, bytes) in &report.files {
        results::write(&pictures.join(name), bytes)?;
    }
    let page = folder.0.join("report.html");
    results::write(&page, report.html.as_bytes())?;
    println!("report   {}   (also results.jsonl, results.csv, pictures)", page.display());
    sweeps.iter().try_for_each(Sweep::check)
}
