//! Jobs at work, scene by scene: answers first, then rounds of times that each go through all jobs in turn, so that a
//! drift of the machine falls on all alike. Everything is kept as soon as it is there.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Result, bail};
use bvh_flat::BuildError;
use indicatif::{ProgressBar, ProgressStyle};

use super::configuration::TreeName;
use super::effort::Rounds;
use super::host::{Host, Usage};
use super::jobs::Worker;
use super::plan::{Job, Plan};
use super::results::{Folder, JobResult, Timings};
use super::subject::Trees;
use super::workshop::{Workshop, own_pool};
use crate::measure::{BuildClock, Stopwatch, timed, timed_on_processor};

/// Whether somebody pressed Ctrl-C.
static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The first Ctrl-C ends the sweep in order; the second at once.
pub fn watch_for_interrupts() {
    // Where there is no handler, Ctrl-C ends the program, and what is done is kept all the same.
    let _ = ctrlc::set_handler(|| {
        if IS_INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(super::INTERRUPTED);
        }
        eprintln!("\ninterrupted: keeping what is done (again Ctrl-C: at once)");
    });
}

/// What Ctrl-C ends a sweep with.
#[derive(Debug)]
pub struct Interrupted;

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("interrupted")
    }
}

impl std::error::Error for Interrupted {}

/// Whether the sweep is to end.
pub fn is_interrupted() -> bool {
    IS_INTERRUPTED.load(Ordering::Relaxed)
}

fn check_interrupted() -> Result<()> {
    if is_interrupted() { bail!(Interrupted) } else { Ok(()) }
}

/// The error of a build that ends when the sweep does.
pub fn build_error(error: BuildError) -> anyhow::Error {
    if error == BuildError::Cancelled { Interrupted.into() } else { error.into() }
}

/// Scenes with more primitives than these are built in one timed round: one takes seconds.
const LARGE: u64 = 3_000_000;

/// Does those of `jobs` that `folder` does not have; all are complete then, unless interrupted.
pub fn run(plan: &Plan, jobs: &[&Job], rounds: Rounds, folder: &Folder, pool: &rayon::ThreadPool) -> Result<()> {
    let mut known = folder.results()?;
    known.retain(|_, result| result.plan == plan.id);
    let host = Host::this();
    for scene in 0..plan.scenes.len() {
        let is_open = |job: &&&Job| job.scene == scene && !known.get(&job.id).is_some_and(|result| result.is_complete);
        let open: Vec<&Job> = jobs.iter().filter(is_open).copied().collect();
        if !open.is_empty() {
            let mut session = Session { plan, scene, rounds, folder, pool, host: &host, watch: Stopwatch::start() };
            session.run(&open, &mut known)?;
        }
    }
    Ok(())
}

/// The jobs of one scene.
struct Session<'a> {
    plan: &'a Plan,
    scene: usize,
    rounds: Rounds,
    folder: &'a Folder,
    pool: &'a rayon::ThreadPool,
    host: &'a Host,
    watch: Stopwatch,
}

impl Session<'_> {
    fn run(&mut self, jobs: &[&Job], known: &mut BTreeMap<String, JobResult>) -> Result<()> {
        let mut trees: Vec<TreeName> = Vec::new();
        for tree in jobs.iter().filter_map(|job| job.task.tree()) {
            if !trees.contains(&tree) {
                trees.push(tree);
            }
        }
        let steps = jobs.len() + trees.len();
        let bar = self.progress_bar((2 + steps + self.rounds.least as usize * steps) as u64);
        let step = |message: &str| {
            bar.inc(1);
            bar.set_message(message.to_owned());
            check_interrupted()
        };
        let workshop = Workshop::open(self.plan, self.scene, &trees, self.pool, &step)?;
        let mut results = Vec::new();
        let mut workers = Vec::new();
        for job in jobs {
            step("judge")?;
            let worker = Worker::new(&workshop, &job.task)?;
            let mut result = match known.remove(&job.id) {
                Some(known) => known,
                None => {
                    let (plan, answers) = (self.plan.id.clone(), worker.answers(&workshop)?);
                    JobResult { plan, job: (*job).clone(), is_complete: false, answers, timings: Timings::default() }
                }
            };
            // Times of another machine are worth nothing here.
            if result.timings.host != *self.host {
                result.timings = Timings { host: self.host.clone(), ..Timings::default() };
            }
            self.folder.save(&result)?;
            results.push(result);
            workers.push(worker);
        }
        let before = Usage::now();
        for round in 0.. {
            let (time, is_long_enough) = (self.watch.elapsed(), round >= self.rounds.least);
            // As long as another round like those before fits.
            let fits = time + time / (round + 2) <= self.rounds.budget;
            if round >= self.rounds.most || (is_long_enough && !fits) {
                break;
            }
            if is_long_enough {
                bar.inc_length(steps as u64);
            }
            self.build_round(&workshop, &trees, &mut results, round, &step)?;
            for (worker, result) in workers.iter().zip(&mut results) {
                step(&format!("round {}", round + 1))?;
                if result.timings.rounds.len() <= round as usize {
                    result.timings.rounds.push(worker.round(&workshop)?);
                    self.folder.save(result)?;
                }
            }
        }
        let others = before.and_then(|before| Some(Usage::now()?.of_others(before)));
        for mut result in results {
            result.is_complete = true;
            result.timings.others = others;
            self.folder.save(&result)?;
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Builds everything once, against the clock.
    fn build_round(
        &self,
        workshop: &Workshop,
        trees: &[TreeName],
        results: &mut [JobResult],
        round: u32,
        step: &dyn Fn(&str) -> Result<()>,
    ) -> Result<()> {
        let is_large = self.plan.scenes[self.scene].primitives > LARGE;
        for tree in trees {
            step(&format!("build {}", tree.describe()))?;
            let is_asked = |result: &&mut JobResult| {
                result.job.task.tree() == Some(*tree) && result.timings.builds.len() <= round as usize
            };
            let mut asked: Vec<&mut JobResult> = results.iter_mut().filter(is_asked).collect();
            if asked.is_empty() || (is_large && round > 0) {
                continue;
            }
            let own = own_pool(tree.threads)?;
            let pool = own.as_ref().unwrap_or(self.pool);
            let clock = BuildClock::until(is_interrupted);
            let (time, built) = pool.install(|| {
                let build = || Trees::build(&workshop.scene, tree, &clock);
                // Of one thread, what others do on the machine counts less.
                if pool.current_num_threads() == 1 { timed_on_processor(build) } else { timed(build) }
            });
            drop(built.map_err(build_error)?);
            let phases: BTreeMap<String, f64> =
                clock.phases().into_iter().map(|(name, time)| (name, time.as_secs_f64())).collect();
            for result in &mut asked {
                result.timings.build_threads = pool.current_num_threads() as u32;
                result.timings.builds.push(time.as_secs_f64());
                result.timings.phases.push(phases.clone());
            }
        }
        Ok(())
    }

    fn progress_bar(&self, length: u64) -> ProgressBar {
        let bar = ProgressBar::new(length);
        if let Ok(style) = ProgressStyle::with_template("{prefix}  {wide_bar} {pos}/{len}  {msg:<20} {eta:>4} left") {
            bar.set_style(style);
        }
        bar.set_prefix(self.plan.scenes[self.scene].name.clone());
        bar
    }
}
