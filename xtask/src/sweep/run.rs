//! Builds, traces and times.

use std::hash::{DefaultHasher, Hasher};
use std::time::Duration;

use anyhow::{Result, bail};
use bvh_flat::bvh_build::TreeStatistics;
use bvh_flat::geometry::{Hit, Interval, Ray, TraversalRay, Work};
use bvh_flat::primitive::{Primitive, intersect_counted, intersect_p_counted};
use bvh_flat::{BuildConfig, SplitMethod};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use scene::{CompiledScene, RaySegment, RaySets};

use super::Arguments;
use crate::input::{self, SEED, SceneSource, SplitMethodName};
use crate::measure::{BuildClock, median, timed};

/// What was measured on one scene.
pub struct Sweep {
    pub scene: String,
    /// Triangles and spheres in memory, each once.
    pub primitives: u64,
    /// The same, each as often as it is instanced.
    pub instanced_primitives: u64,
    pub configurations: Vec<Configuration>,
}

/// What was measured with one split method.
pub struct Configuration {
    pub method: SplitMethod,
    pub build: Build,
    pub traces: Vec<Trace>,
}

/// A build, all trees of the scene together.
pub struct Build {
    pub time: Duration,
    pub phases: Vec<(String, Duration)>,
    pub nodes: u64,
    pub leaves: u64,
    /// Of the deepest tree.
    pub depth: u32,
    /// The mean over the trees, weighted by their primitives.
    pub sah_cost: f64,
    /// Of all that is kept beside the scene itself.
    pub bytes: u64,
}

/// One kind of rays, traced for the closest and for any hit.
pub struct Trace {
    /// "primary", "shadow", "diffuse" or "random".
    pub kind: &'static str,
    pub rays: usize,
    pub hits: usize,
    pub closest: Duration,
    pub any: Duration,
    pub closest_work: Work,
    pub any_work: Work,
    /// Over all closest answers, bit for bit.
    pub hash: u64,
    /// Rays for which any-hit and closest-hit do not agree.
    pub disagreements: usize,
}

pub fn sweep(arguments: &Arguments, source: &SceneSource, pool: &rayon::ThreadPool) -> Result<Sweep> {
    let methods: Vec<SplitMethod> = match &arguments.split_method[..] {
        [] => SplitMethodName::value_variants().iter().map(|m| m.method()).collect(),
        chosen => chosen.iter().map(|m| m.method()).collect(),
    };
    let steps = 1 + methods.len() as u64 * (2 + u64::from(arguments.rounds));
    let bar = ProgressBar::new(steps);
    if let Ok(style) = ProgressStyle::with_template("{prefix}  {wide_bar} {pos}/{len}  {msg:<24} {eta:>4} left") {
        bar.set_style(style);
    }
    bar.set_prefix(source.name());

    bar.set_message("load");
    let scene = source.load()?;
    bar.inc(1);
    let mut built = Vec::new();
    for &method in &methods {
        bar.set_message(format!("build {}", method.name()));
        let clock = BuildClock::default();
        let (time, compiled) =
            timed(|| pool.install(|| CompiledScene::build(scene.clone(), &BuildConfig::new(method), &clock)));
        let compiled = compiled?;
        built.push((method, build_figures(time, &clock, &compiled), compiled));
        bar.inc(1);
    }

    let Some((_, _, first)) = built.first() else { bail!("no split method is left to measure") };
    bar.set_message("aim rays");
    let camera = input::camera(first, None)?;
    let bounds = first.world().world_bound();
    let sets = RaySets::generate(first.world(), &bounds, &camera, arguments.rays as usize, SEED)?;
    let mut traces: Vec<Vec<Trace>> = Vec::new();
    for (method, _, compiled) in &built {
        bar.set_message(format!("count {}", method.name()));
        traces.push(sets.named().into_iter().map(|(kind, rays)| count(compiled, kind, rays)).collect());
        bar.inc(1);
    }
    let mut times = vec![vec![(vec![], vec![]); sets.named().len()]; built.len()];
    for _ in 0..arguments.rounds {
        for ((method, _, compiled), times) in built.iter().zip(&mut times) {
            bar.set_message(format!("trace {}", method.name()));
            for ((_, rays), (closest, any)) in sets.named().into_iter().zip(times) {
                closest.push(timed(|| trace_closest(compiled, rays)).0);
                any.push(timed(|| trace_any(compiled, rays)).0);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();

    let instanced_primitives = built[0].2.world().primitive_count();
    let configurations = built.into_iter().zip(traces).zip(times).map(|(((method, build, _), mut traces), times)| {
        for (trace, (closest, any)) in traces.iter_mut().zip(times) {
            (trace.closest, trace.any) = (median(closest), median(any));
        }
        Configuration { method, build, traces }
    });
    Ok(Sweep {
        scene: source.name(),
        primitives: scene.geometries().iter().map(|g| g.shape.primitive_count()).sum(),
        instanced_primitives,
        configurations: configurations.collect(),
    })
}

fn build_figures(time: Duration, clock: &BuildClock, compiled: &CompiledScene) -> Build {
    let trees = clock.trees();
    let sum = |f: fn(&TreeStatistics) -> u64| trees.iter().map(f).sum::<u64>();
    let active = sum(|t| u64::from(t.active_count)).max(1) as f64;
    Build {
        time,
        phases: clock.phases().into_iter().collect(),
        nodes: sum(|t| u64::from(t.node_count)),
        leaves: sum(|t| u64::from(t.leaf_count)),
        depth: trees.iter().map(|t| t.depth).max().unwrap_or(0),
        sah_cost: trees.iter().map(|t| t.sah_cost * f64::from(t.active_count)).sum::<f64>() / active,
        bytes: compiled.memory() as u64,
    }
}

/// Rays that make no sense are misses, as in a query by the user.
fn closest(compiled: &CompiledScene, ray: &Ray, interval: Interval) -> Option<Hit> {
    TraversalRay::new(ray).and_then(|ray| compiled.world().intersect(&ray, interval))
}

fn trace_closest(compiled: &CompiledScene, rays: &[RaySegment]) -> usize {
    rays.iter().filter(|r| closest(compiled, &r.ray, r.interval).is_some()).count()
}

fn trace_any(compiled: &CompiledScene, rays: &[RaySegment]) -> usize {
    let any =
        |r: &&RaySegment| TraversalRay::new(&r.ray).is_some_and(|ray| compiled.world().intersect_p(&ray, r.interval));
    rays.iter().filter(any).count()
}

/// Traces everything once without a clock: the answers and what they cost in steps.
fn count(compiled: &CompiledScene, kind: &'static str, rays: &[RaySegment]) -> Trace {
    let mut trace = Trace {
        kind,
        rays: rays.len(),
        hits: 0,
        closest: Duration::ZERO,
        any: Duration::ZERO,
        closest_work: Work::default(),
        any_work: Work::default(),
        hash: 0,
        disagreements: 0,
    };
    let mut hasher = DefaultHasher::new();
    for segment in rays {
        let Some(ray) = TraversalRay::new(&segment.ray) else { continue };
        let (hit, work) = intersect_counted(compiled.world(), &ray, segment.interval);
        let (any, any_work) = intersect_p_counted(compiled.world(), &ray, segment.interval);
        let uncounted = compiled.world().intersect(&ray, segment.interval);
        let blocked = compiled.world().intersect_p(&ray, segment.interval);
        trace.closest_work += work;
        trace.any_work += any_work;
        trace.hits += usize::from(hit.is_some());
        let agree = hit == uncounted && any.is_some() == hit.is_some() && blocked == hit.is_some();
        trace.disagreements += usize::from(!agree);
        if let Some(Hit { t, u, v, primitive }) = hit {
            for x in [t, u, v] {
                hasher.write_u32(x.to_bits());
            }
            hasher.write_u64(primitive);
        } else {
            hasher.write_u8(0);
        }
    }
    trace.hash = hasher.finish();
    trace
}

/// The answers must not depend on the tree, nor on the kind of query.
pub fn check_agreement(sweeps: &[Sweep]) -> Result<()> {
    for sweep in sweeps {
        for configuration in &sweep.configurations {
            for (trace, first) in configuration.traces.iter().zip(&sweep.configurations[0].traces) {
                let (scene, method, kind) = (&sweep.scene, configuration.method.name(), trace.kind);
                if trace.hash != first.hash {
                    let other = sweep.configurations[0].method.name();
                    bail!("{scene}: {method} and {other} answer {kind} rays differently");
                }
                if trace.disagreements > 0 {
                    let n = trace.disagreements;
                    bail!("{scene}: {method}: closest-hit and any-hit disagree on {n} {kind} rays");
                }
            }
        }
    }
    Ok(())
}
