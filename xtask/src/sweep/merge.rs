//! `xtask merge`: the results of shards, put together.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;

use super::Incomplete;
use super::plan::Plan;
use super::results::{Folder, JobResult};

#[derive(Args)]
pub struct Arguments {
    /// Directories that `sweep --out` wrote; one of all shards, or one of each
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Where the results go; the first DIR by default
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let mut plans: Vec<(Plan, &PathBuf)> = Vec::new();
    let mut all: BTreeMap<String, Vec<JobResult>> = BTreeMap::new();
    for path in &arguments.folders {
        let folder = Folder(path.clone());
        let Some(plan) = folder.plan()? else { bail!("{}: there is no plan in it", path.display()) };
        for result in folder.results()?.into_values() {
            if result.plan != plan.id {
                bail!("{}: results of several plans, {} and {}", path.display(), plan.id, result.plan);
            }
            all.entry(result.job.id.clone()).or_default().push(result);
        }
        plans.push((plan, path));
    }
    let (plan, first) = &plans[0];
    if let Some((other, path)) = plans.iter().find(|(other, _)| other.id != plan.id) {
        bail!(
            "{} and {} are of different plans, {} and {}: {}",
            first.display(),
            path.display(),
            plan.id,
            other.id,
            difference(plan, other)
        );
    }
    let results: BTreeMap<String, JobResult> =
        all.into_iter().filter_map(|(id, of_job)| Some((id, best(of_job)?))).collect();
    let folder = Folder(arguments.out.clone().unwrap_or_else(|| arguments.folders[0].clone()));
    folder.begin(plan)?;
    for result in results.values() {
        folder.save(result)?;
    }
    super::publish(plan, &results, &folder)?;
    let is_missing = |id: &&String| !results.get(*id).is_some_and(|result| result.is_complete);
    let missing: Vec<String> = plan.jobs.iter().map(|job| &job.id).filter(is_missing).cloned().collect();
    if missing.is_empty() { Ok(()) } else { bail!(Incomplete { missing, of: plan.jobs.len() }) }
}

/// Of a job that was done more than once: a complete one before others, the most rounds, and of equal ones that of the
/// machine whose name is first. Rounds of two machines are never put together.
fn best(mut results: Vec<JobResult>) -> Option<JobResult> {
    results.sort_by_key(|r| {
        (std::cmp::Reverse((r.is_complete, r.timings.rounds.len())), r.timings.host.fingerprint.clone())
    });
    results.into_iter().next()
}

/// What makes two plans different, in words.
fn difference(a: &Plan, b: &Plan) -> String {
    let mut words = Vec::new();
    if a.program.fingerprint != b.program.fingerprint {
        words.push("another build of the program (copy one file to all machines)");
    }
    if a.scenes != b.scenes {
        words.push("other scenes");
    }
    fn rays(plan: &Plan) -> impl PartialEq + '_ {
        (plan.rays, plan.judged_rays, &plan.ray_sets, &plan.ray_files, &plan.camera)
    }
    if rays(a) != rays(b) {
        words.push("other rays");
    }
    let tasks = |plan: &Plan| plan.jobs.iter().map(|job| job.task).collect::<Vec<_>>();
    if tasks(a) != tasks(b) {
        words.push("other configurations (name --simd-width where processors differ)");
    }
    if words.is_empty() { "other settings".to_owned() } else { words.join(", ") }
}
