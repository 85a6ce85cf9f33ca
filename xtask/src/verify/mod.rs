//! `xtask verify`: the catalogue of hard cases, and a scene beside the oracle.

mod builds;

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use bvh_flat::primitive::Primitive;
use clap::Args;
use comfy_table::CellAlignment;
use hard_cases::{Case, Effort, Library, OPEN, Outcome, Run, cases};
use indicatif::{ProgressBar, ProgressStyle};
use scene::RaySets;

use crate::errors::{ErrorSummary, Errors, Truth, leaks, per_million, quantile};
use crate::input::{self, SCENE_HELP, SEED, SceneSource, SplitMethodName};
use crate::measure::timed;
use crate::sweep::subject::Subject;
use crate::table::{count, table};

#[derive(Args)]
pub struct Arguments {
    /// A scene to compare with the oracle instead of running the catalogue
    #[arg(long_help = SCENE_HELP, value_parser = SceneSource::parse)]
    scene: Option<SceneSource>,
    /// Run at full size: hours, with a progress bar; with cases B, time builds of hard input too
    #[arg(long)]
    full: bool,
    /// Run only the cases whose id begins with one of these: T, T01, S2
    #[arg(long, value_delimiter = ',', value_name = "ID", conflicts_with = "scene")]
    case: Vec<String>,
    /// How trees are built
    #[arg(long, value_enum, default_value_t = SplitMethodName::Sah, value_name = "METHOD")]
    split_method: SplitMethodName,
    /// The seed of everything random
    #[arg(long, default_value_t = SEED)]
    seed: u64,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    match &arguments.scene {
        Some(source) => verify_scene(arguments, source),
        None => verify_catalogue(arguments),
    }
}

fn verify_catalogue(arguments: &Arguments) -> Result<()> {
    let wanted = |case: &Case| arguments.case.is_empty() || arguments.case.iter().any(|id| case.id.starts_with(id));
    let chosen: Vec<Case> = cases().into_iter().filter(wanted).collect();
    if let Some(unknown) = arguments.case.iter().find(|id| !chosen.iter().any(|case| case.id.starts_with(*id))) {
        return Err(input::usage_error(format!("no case has an id that begins with \"{unknown}\"")));
    }
    let effort = if arguments.full { Effort::Full } else { Effort::Quick };
    let library = Library { config: arguments.split_method.config() };

    let bar = ProgressBar::new(1000 * chosen.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("verify {wide_bar} {percent:>3} %  {msg:<40} {eta:>5} left") {
        bar.set_style(style);
    }
    let mut rows = table(&["case", "what", "trials", "failures", "s", "figures"], 2);
    if let Some(figures) = rows.column_mut(5) {
        figures.set_cell_alignment(CellAlignment::Left);
    }
    let mut failed = Vec::new();
    for (done, case) in (0..).zip(&chosen) {
        bar.set_message(format!("{} {}", case.id, case.title));
        let at = AtomicU64::new(0);
        let progress = |part: f64| {
            let step = (1000.0 * part.clamp(0.0, 1.0)) as u64;
            if at.fetch_max(step, Ordering::Relaxed) < step {
                bar.set_position(1000 * done + step);
            }
        };
        let run = Run { effort, seed: arguments.seed, subject: &library, progress: &progress };
        let (time, outcome) = timed(|| (case.run)(&run));
        bar.set_position(1000 * (done + 1));
        let row = row(case, time, &outcome);
        if arguments.full {
            // Hours may pass until the table is printed.
            bar.suspend(|| {
                let [id, _, trials, failures, seconds, figures] = &row;
                let figures = figures.replace('\n', ", ");
                eprintln!("{id}  {trials} trials, {failures} failures, {seconds} s  {figures}");
            });
        }
        rows.add_row(row);
        if !outcome.passed() {
            failed.push((case, outcome));
        }
    }
    bar.finish_and_clear();
    println!("{rows}");
    for (case, outcome) in &failed {
        let reason = outcome.first_failure.as_deref().unwrap_or("nothing was tried");
        println!("{} {}: {reason}", case.id, case.title);
        if let Some((_, known)) = OPEN.iter().find(|(id, _)| *id == case.id) {
            println!("    known: {known}");
        }
    }
    println!("{} of {} cases passed, seed {}", chosen.len() - failed.len(), chosen.len(), arguments.seed);
    if arguments.full && chosen.iter().any(|case| case.id.starts_with('B')) {
        builds::print(arguments.seed)?;
    }
    ensure!(failed.is_empty(), "{} cases failed", failed.len());
    Ok(())
}

fn row(case: &Case, time: Duration, outcome: &Outcome) -> [String; 6] {
    let figures = outcome.figures.iter().map(|(name, value)| match value {
        _ if value.fract() == 0.0 && (0.0..1e15).contains(value) => format!("{name} {}", count(*value as u64)),
        _ => format!("{name} {value:.4}"),
    });
    [
        case.id.to_owned(),
        case.title.to_owned(),
        count(outcome.trials),
        count(outcome.failures),
        format!("{:.2}", time.as_secs_f64()),
        in_lines(figures),
    ]
}

/// Words, one behind the other, in lines that are not long.
fn in_lines(parts: impl Iterator<Item = String>) -> String {
    const WIDTH: usize = 70;
    let mut lines: Vec<String> = Vec::new();
    for part in parts {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 2 + part.chars().count() <= WIDTH => {
                line.push_str(", ");
                line.push_str(&part);
            }
            _ => lines.push(part),
        }
    }
    lines.join("\n")
}

fn verify_scene(arguments: &Arguments, source: &SceneSource) -> Result<()> {
    let rays = if arguments.full { 1 << 20 } else { 1 << 14 };
    let compiled = input::compile(source, arguments.split_method)?;
    let camera = input::camera(&compiled);
    let bounds = compiled.world().world_bound();
    let sets = RaySets::generate(compiled.world(), &bounds, &camera, rays, arguments.seed)?;
    let Some(truth) = Truth::new(&compiled, &sets.named(), rays) else {
        bail!("{}: too many instances for the oracle", source.name());
    };
    let subject = Subject::of_default(&compiled)?;
    let header =
        ["rays", "count", "missed", "false", "wrong", "t ulp p50", "p99.99", "max", "bound broken", "self-hits"];
    let mut rows = table(&header, 1);
    let mut faults = 0;
    for set in &truth.sets {
        let e = Errors::of(&*subject.world, set);
        faults += e.bound_violations + e.mismatches;
        if truth.is_of_one_mesh {
            faults += ErrorSummary::of(&e).wrong_answers();
        }
        let ulp = |q: f64| if e.t_ulps.is_empty() { "-".to_owned() } else { format!("{:.2}", quantile(&e.t_ulps, q)) };
        rows.add_row([
            set.kind.clone(),
            count(e.rays),
            per_million(e.missed, e.rays),
            per_million(e.false_hits, e.rays),
            per_million(e.wrong, e.rays),
            ulp(0.5),
            ulp(0.9999),
            ulp(1.0),
            per_million(e.bound_violations, e.tightness.len() as u64),
            per_million(e.self_hits, e.spawned),
        ]);
    }
    println!("{}: beside the exact answers; wrong answers are per million\n{rows}", source.name());
    let leaks = leaks(&subject.meshes, &truth.leak_tests);
    if leaks.is_empty() {
        println!("leaks: no mesh is closed or has a seam, so none can be told from a hole");
    }
    for (aim, leaked, rays) in leaks {
        println!("leaks of {} rays aimed at {aim}, a million: {}", count(rays), per_million(leaked, rays));
        faults += leaked;
    }
    ensure!(
        faults == 0,
        "{}: {faults} wrong answers, leaks, broken bounds or disagreements of any-hit and closest-hit",
        source.name()
    );
    Ok(())
}
