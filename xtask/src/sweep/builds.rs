//! Builds by every split method, and what they cost.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use bvh_flat::bvh_build::TreeStatistics;
use bvh_flat::{BuildConfig, SplitMethod};
use indicatif::ProgressBar;
use scene::Scene;

use super::configuration::{Layout, Trees};
use crate::measure::{BuildClock, timed};

/// A build, all trees of the scene together.
pub struct Build {
    pub layout: Layout,
    pub method: SplitMethod,
    /// The median of the timed rounds.
    pub time: Duration,
    /// How many they were.
    pub rounds: u32,
    /// Of the round of the median.
    pub phases: Vec<(String, Duration)>,
    /// Nodes, leaves, depth and cost are those of the builder's binary trees, to which wide ones are collapsed.
    pub nodes: u64,
    pub leaves: u64,
    /// Of the deepest tree.
    pub depth: u32,
    /// The mean over the trees, weighted by their primitives.
    pub sah_cost: f64,
    /// Of all that is kept beside the scene itself.
    pub bytes: u64,
    /// Of cache files with the trees over meshes.
    pub bytes_on_disk: u64,
}

/// The time of a build, and that of each phase.
type Timing = (Duration, Vec<(String, Duration)>);

/// Scenes with more primitives than these are built in one timed round: one takes seconds.
const LARGE: u64 = 3_000_000;

/// How many rounds of builds are timed, of so many that are asked for.
pub fn build_rounds(asked: u32, primitives: u64) -> u32 {
    if primitives > LARGE { 1 } else { asked }
}

/// Builds the scene in each of `ways`, first once without a clock, so that caches and pages are warm and none pays for
/// being the first, and then in timed rounds that each go through all of them.
pub fn build_all(
    scene: &Arc<Scene>,
    ways: &[(Layout, SplitMethod)],
    rounds: u32,
    pool: &rayon::ThreadPool,
    bar: &ProgressBar,
) -> Result<(Vec<Trees>, Vec<Build>)> {
    let build = |(layout, method): (Layout, SplitMethod), clock: &BuildClock| {
        bar.set_message(format!("build {}", method.name()));
        let build = || Trees::build(scene, layout, &BuildConfig::new(method), clock);
        let (time, built) = timed(|| pool.install(build));
        bar.inc(1);
        built.map(|built| (time, built))
    };
    let mut compiled = Vec::new();
    let mut trees = Vec::new();
    for &way in ways {
        let clock = BuildClock::default();
        compiled.push(build(way, &clock)?.1);
        trees.push(clock.trees());
    }
    let mut timings = vec![Vec::<Timing>::new(); ways.len()];
    for _ in 0..rounds {
        for (&way, timings) in ways.iter().zip(&mut timings) {
            let clock = BuildClock::default();
            let (time, _) = build(way, &clock)?;
            timings.push((time, clock.phases().into_iter().collect()));
        }
    }
    let builds = ways.iter().zip(timings).zip(trees.iter().zip(&compiled));
    let builds = builds.map(|((&way, timings), (trees, compiled))| figures(way, timings, trees, compiled)).collect();
    Ok((compiled, builds))
}

/// The figures of builds in one way; `timings` are the time and the phases of each timed one.
fn figures(
    (layout, method): (Layout, SplitMethod),
    mut timings: Vec<Timing>,
    trees: &[TreeStatistics],
    compiled: &Trees,
) -> Build {
    let sum = |f: fn(&TreeStatistics) -> u32| trees.iter().map(|t| u64::from(f(t))).sum::<u64>();
    let weighted_cost: f64 = trees.iter().map(|t| t.sah_cost * f64::from(t.active_count)).sum();
    let rounds = timings.len() as u32;
    timings.sort();
    let (time, phases) = timings.into_iter().nth(rounds as usize / 2).unwrap_or_default();
    Build {
        layout,
        method,
        time,
        rounds,
        phases,
        nodes: sum(|t| t.node_count),
        leaves: sum(|t| t.leaf_count),
        depth: trees.iter().map(|t| t.depth).max().unwrap_or(0),
        sah_cost: weighted_cost / sum(|t| t.active_count).max(1) as f64,
        bytes: compiled.memory() as u64,
        bytes_on_disk: compiled.file_length(),
    }
}
