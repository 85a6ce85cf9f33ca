//! Traces, judges and times.

use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, bail};
use bvh_flat::geometry::{ClosestHit, FirstHit, Hit, TraversalRay, Work};
use bvh_flat::primitive::{HitKind, Primitive};
use bvh_flat::{BuildConfig, SimdWidth, SplitMethod};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use scene::{CompiledScene, RaySegment, RaySets};

use super::Arguments;
use super::builds::{Build, build_all, build_rounds};
use super::configuration::{Layout, Promise, Subject, Traversal, Trees, WidthName};
use crate::errors::{self, Errors, Truth};
use crate::input::{self, SEED, SceneSource, SplitMethodName};
use crate::measure::{median, timed_on_processor};

/// What was measured on one scene.
pub struct Sweep {
    pub scene: String,
    /// Triangles and spheres in memory, each once.
    pub primitives: u64,
    /// The same, each as often as it is instanced.
    pub instanced_primitives: u64,
    pub builds: Vec<Build>,
    pub configurations: Vec<Configuration>,
}

/// What was measured with one build and one way to traverse its trees.
pub struct Configuration {
    /// Its place in [`Sweep::builds`].
    pub build: usize,
    pub traversal: Traversal,
    pub traces: Vec<Trace>,
    /// By what was aimed at: leaks, and rays.
    pub leaks: Vec<(&'static str, u64, u64)>,
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
    pub disagreements: u64,
    /// Beside the oracle; `None` where it was not asked.
    pub errors: Option<Errors>,
}

/// The durations of each round, closest and any, of one kind of rays.
type Rounds = (Vec<Duration>, Vec<Duration>);

pub fn sweep(arguments: &Arguments, source: &SceneSource, pool: &rayon::ThreadPool) -> Result<Sweep> {
    let methods: Vec<SplitMethod> = chosen(&arguments.split_method).into_iter().map(SplitMethodName::method).collect();
    let (layouts, kernels) = (chosen(&arguments.layout), chosen(&arguments.kernels));
    let widths = widths(&arguments.simd_width)?;
    // The default comes first.
    let ways: Vec<(Layout, SplitMethod)> =
        layouts.iter().flat_map(|&layout| methods.iter().map(move |&method| (layout, method))).collect();
    let traversals = |layout: &Layout| match layout {
        Layout::Wide => widths.len(),
        Layout::Binary => kernels.len(),
    };
    let configurations = (methods.len() * layouts.iter().map(traversals).sum::<usize>()) as u64;
    let bar = progress_bar(source);

    bar.set_message("load");
    let scene = Arc::new(source.load()?);
    let primitives = scene.geometries().iter().map(|g| g.shape.primitive_count()).sum();
    let rounds = build_rounds(arguments.rounds, primitives);
    let build_steps = ways.len() as u64 * u64::from(1 + rounds);
    bar.set_length(2 + build_steps + configurations * (2 + u64::from(arguments.rounds)));
    let (compiled, builds) = build_all(&scene, &ways, rounds, pool, &bar)?;

    // Rays and exact answers are those of the default trees, whatever is measured.
    let own = match compiled.first() {
        Some(Trees::Wide(_)) => None,
        _ => Some(CompiledScene::build(Arc::clone(&scene), &BuildConfig::default(), &())?),
    };
    let first = match (compiled.first(), &own) {
        (Some(Trees::Wide(first)), _) | (_, Some(first)) => first,
        _ => bail!("no layout is left to measure"),
    };
    bar.set_message("aim rays");
    let camera = input::camera(first);
    let bounds = first.world().world_bound();
    let sets = RaySets::generate(first.world(), &bounds, &camera, arguments.rays as usize, SEED)?;
    bar.set_message("ask the oracle");
    let truth = match arguments.judged_rays {
        0 => None,
        count => pool.install(|| Truth::new(first, &sets, count as usize)),
    };
    bar.inc(1);

    let mut subjects = Vec::new();
    let mut measured = Vec::new();
    for (build, compiled) in compiled.iter().enumerate() {
        for (traversal, subject) in Subject::all(compiled, &widths, &kernels)? {
            bar.set_message(format!("judge {}", ways[build].1.name()));
            let world = &*subject.world;
            let is_exact = traversal.promise() == Some(Promise::Exact);
            let mut traces: Vec<Trace> = sets.named().map(|(kind, rays)| count(world, kind, rays, is_exact)).into();
            bar.inc(1);
            let mut leaks = Vec::new();
            if let Some(truth) = &truth {
                pool.install(|| {
                    for (trace, set) in traces.iter_mut().zip(&truth.sets) {
                        trace.errors = Some(Errors::of(world, set));
                    }
                    leaks = errors::leaks(&subject.meshes, &truth.leak_tests);
                });
            }
            measured.push(Configuration { build, traversal, traces, leaks });
            subjects.push(subject);
            bar.inc(1);
        }
    }
    let mut times: Vec<[Rounds; 4]> = vec![Default::default(); subjects.len()];
    for _ in 0..arguments.rounds {
        for (subject, times) in subjects.iter().zip(&mut times) {
            bar.set_message("trace");
            for ((_, rays), (closest, any)) in sets.named().into_iter().zip(times) {
                closest.push(timed_on_processor(|| trace_closest(&*subject.world, rays)).0);
                any.push(timed_on_processor(|| trace_any(&*subject.world, rays)).0);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();

    for (configuration, times) in measured.iter_mut().zip(times) {
        for (trace, (closest, any)) in configuration.traces.iter_mut().zip(times) {
            (trace.closest, trace.any) = (median(closest), median(any));
        }
    }
    Ok(Sweep {
        scene: source.name(),
        primitives,
        instanced_primitives: first.world().primitive_count(),
        builds,
        configurations: measured,
    })
}

/// What the command line chooses; all where it chooses nothing.
fn chosen<T: ValueEnum + Copy>(names: &[T]) -> Vec<T> {
    if names.is_empty() { T::value_variants().to_vec() } else { names.to_vec() }
}

/// The widths that the command line chooses; all that the processor has where it chooses none.
fn widths(names: &[WidthName]) -> Result<Vec<SimdWidth>> {
    if names.is_empty() {
        return Ok(SimdWidth::available());
    }
    let mut widths = Vec::new();
    for name in names {
        let Some(width) = name.width() else { bail!("this processor does not have {name:?}") };
        widths.push(width);
    }
    Ok(widths)
}

fn progress_bar(source: &SceneSource) -> ProgressBar {
    let bar = ProgressBar::no_length();
    if let Ok(style) = ProgressStyle::with_template("{prefix}  {wide_bar} {pos}/{len}  {msg:<20} {eta:>4} left") {
        bar.set_style(style);
    }
    bar.set_prefix(source.name());
    bar
}

/// Rays that make no sense are misses, as in a query by the user.
fn trace_closest(world: &dyn Primitive, rays: &[RaySegment]) -> usize {
    let hits =
        |r: &&RaySegment| TraversalRay::new(&r.ray).is_some_and(|ray| world.intersect(&ray, r.interval).is_some());
    rays.iter().filter(hits).count()
}

fn trace_any(world: &dyn Primitive, rays: &[RaySegment]) -> usize {
    let blocked = |r: &&RaySegment| TraversalRay::new(&r.ray).is_some_and(|ray| world.intersect_p(&ray, r.interval));
    rays.iter().filter(blocked).count()
}

/// Traces everything once without a clock: the answers and what they cost in steps.
///
/// A visitor of hits compares rounded t. So of an exact subject, which compares exact ones within a mesh, it agrees about t
/// and may name another primitive.
fn count(world: &dyn Primitive, kind: &'static str, rays: &[RaySegment], is_exact: bool) -> Trace {
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
        errors: None,
    };
    let mut hasher = DefaultHasher::new();
    for segment in rays {
        let Some(ray) = TraversalRay::new(&segment.ray) else { continue };
        let (mut closest, mut any) = (ClosestHit::new(segment.interval), FirstHit::default());
        let _ = world.visit_hits(&ray, segment.interval, HitKind::Material, &mut closest);
        let _ = world.visit_hits(&ray, segment.interval, HitKind::Material, &mut any);
        let (hit, visited) = (world.intersect(&ray, segment.interval), closest.hit());
        trace.closest_work += closest.work();
        trace.any_work += any.work();
        trace.hits += usize::from(hit.is_some());
        let agree = (hit == visited || (is_exact && hit.map(|h| h.t) == visited.map(|h| h.t)))
            && any.hit().is_some() == hit.is_some()
            && world.intersect_p(&ray, segment.interval) == hit.is_some();
        trace.disagreements += u64::from(!agree);
        match hit {
            Some(Hit { t, u, v, primitive }) => {
                for x in [t, u, v] {
                    hasher.write_u32(x.to_bits());
                }
                hasher.write_u64(primitive);
            }
            None => hasher.write_u8(0),
        }
    }
    trace.hash = hasher.finish();
    trace
}

impl Sweep {
    /// The split method of a configuration.
    pub fn method(&self, configuration: &Configuration) -> SplitMethod {
        self.builds[configuration.build].method
    }

    /// What must hold of all that promise something: the answers depend on the promise alone, neither on the tree, the
    /// layout, the width nor the kind of query; no ray leaks, and no bound on an error is violated.
    pub fn check(&self) -> Result<()> {
        for (i, configuration) in self.configurations.iter().enumerate() {
            let Some(promise) = configuration.traversal.promise() else { continue };
            let describe = |c: &Configuration| {
                let Configuration { traversal, .. } = c;
                let [_, triangles] = traversal.tests();
                let (layout, width) = (traversal.layout().name(), traversal.width());
                format!("{} {layout} {width}, {triangles}", self.method(c).name())
            };
            let (scene, what) = (&self.scene, describe(configuration));
            let first = self.configurations[..i].iter().find(|c| c.traversal.promise() == Some(promise));
            for (k, trace) in configuration.traces.iter().enumerate() {
                let kind = trace.kind;
                if let Some(first) = first
                    && first.traces[k].hash != trace.hash
                {
                    bail!("{scene}: {what} and {} answer {kind} rays differently", describe(first));
                }
                let mismatches = trace.disagreements + trace.errors.as_ref().map_or(0, |e| e.mismatches);
                if mismatches > 0 {
                    bail!("{scene}: {what}: closest-hit, any-hit and all hits disagree on {mismatches} {kind} rays");
                }
                let violations = trace.errors.as_ref().map_or(0, |e| e.bound_violations);
                if violations > 0 {
                    bail!("{scene}: {what}: {violations} {kind} hits lie outside of their error bound");
                }
            }
            if let Some((aim, leaks, rays)) = configuration.leaks.iter().find(|(_, leaks, _)| *leaks > 0) {
                bail!("{scene}: {what}: {leaks} of {rays} rays aimed at {aim} leak out of closed meshes");
            }
        }
        Ok(())
    }
}
