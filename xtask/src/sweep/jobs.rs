//! Jobs at work: each gives its answers once, and then a round of times, and another.

use std::hash::{DefaultHasher, Hasher};

use anyhow::{Context, Result, bail};
use bvh_flat::cache::{TreeLayout, TreeOptions};
use bvh_flat::geometry::{ClosestHit, FirstHit, Hit, TraversalRay, Work};
use bvh_flat::primitive::{HitKind, Primitive};
use bvh_flat::{WideLayout, WideMesh};
use rayon::prelude::*;

use super::configuration::{Calls, Promise, Traversal, TreeName};
use super::leak_maps::leak_maps;
use super::occlusion::{self, Occlusion};
use super::plan::Task;
use super::results::{Answers, CacheAnswers, PictureAnswers, SetAnswers, TraceAnswers};
use super::subject::{Subject, Trees};
use super::workshop::{RaySet, Workshop, own_pool};
use crate::errors::{self, ErrorSummary, Errors};
use crate::measure::{timed, timed_on_processor};

/// A job with what it works on.
pub enum Worker<'a> {
    Trace { tree: TreeName, traversal: Traversal, subject: Subject },
    Picture { occlusion: Occlusion<'a> },
    Leaks,
    Cache { tree: TreeName, folder: tempfile::TempDir },
}

impl<'a> Worker<'a> {
    pub fn new(workshop: &'a Workshop, task: &Task) -> Result<Self> {
        Ok(match *task {
            Task::Trace { tree, traversal } => {
                Self::Trace { tree, traversal, subject: Subject::new(&workshop.find(&tree)?.trees, traversal)? }
            }
            Task::Picture { tree } => {
                let Trees::Wide(compiled) = &workshop.find(&tree)?.trees else { bail!("pictures are of wide trees") };
                let sizes = workshop.plan.pictures.context("no pictures are planned")?;
                let bounds = workshop.default_trees()?.world().world_bound();
                Self::Picture { occlusion: Occlusion::new(compiled, &workshop.camera()?, &bounds, sizes)? }
            }
            Task::Leaks => Self::Leaks,
            Task::Cache { tree } => {
                Self::Cache { tree, folder: tempfile::tempdir().context("no directory for the files")? }
            }
        })
    }

    /// What does not depend on time.
    pub fn answers(&self, workshop: &Workshop) -> Result<Answers> {
        Ok(match self {
            Self::Trace { tree, traversal, subject } => {
                Answers::Trace(Box::new(trace_answers(workshop, tree, *traversal, subject)?))
            }
            Self::Picture { occlusion } => workshop.pool.install(|| {
                let images = occlusion.images();
                let reference = workshop.reference(occlusion);
                Answers::Picture(PictureAnswers {
                    size: occlusion.sizes.map,
                    visits: occlusion.visits(),
                    samples: occlusion.samples(),
                    rmse: images.iter().map(|image| occlusion::rmse(image, reference)).collect(),
                    hash: occlusion::hash(images.last().map_or(&[], Vec::as_slice)),
                })
            }),
            Self::Leaks => {
                let sizes = workshop.plan.pictures.context("no pictures are planned")?;
                Answers::Leaks(workshop.pool.install(|| leak_maps(&workshop.scene, sizes.leaks))?)
            }
            Self::Cache { tree, .. } => {
                Answers::Cache(CacheAnswers { bytes_on_disk: workshop.find(tree)?.figures.bytes_on_disk })
            }
        })
    }

    /// The time of each step, in seconds; nothing of a job that has none.
    pub fn round(&self, workshop: &Workshop) -> Result<Vec<f64>> {
        Ok(match self {
            Self::Trace { tree, traversal, subject } => {
                let own = own_pool(tree.threads)?;
                let pool = own.as_ref().unwrap_or(workshop.pool);
                let is_parallel = traversal.calls() == Calls::Parallel;
                let time = |query: &mut (dyn FnMut() + Send)| {
                    let (time, ()) =
                        if is_parallel { pool.install(|| timed(query)) } else { timed_on_processor(query) };
                    time.as_secs_f64()
                };
                let (mut hits, mut any) = (Vec::new(), Vec::new());
                let mut times = Vec::new();
                for RaySet { rays, batch, .. } in &workshop.sets {
                    times.push(time(&mut || subject.closest(rays, batch, &mut hits)));
                    times.push(time(&mut || subject.any(rays, batch, &mut any)));
                }
                times
            }
            Self::Picture { occlusion } => occlusion.times(),
            Self::Leaks => Vec::new(),
            Self::Cache { tree, folder } => cache_times(&workshop.find(tree)?.trees, tree, folder.path())?.to_vec(),
        })
    }
}

/// Saving, loading and mapping of all trees over meshes.
fn cache_times(trees: &Trees, name: &TreeName, folder: &std::path::Path) -> Result<[f64; 3]> {
    let Trees::Wide(compiled) = trees else { bail!("files are of wide trees") };
    let options = TreeOptions::new(&name.split_method.config(), TreeLayout::Wide(WideLayout::Blocks));
    let mut sums = [0.0; 3];
    for mesh in compiled.meshes() {
        let path = folder.join("tree.bvh");
        let (save, saved) = timed(|| mesh.save(&path, &options));
        saved?;
        let (load, loaded) = timed(|| WideMesh::load(&path, mesh.mesh().clone(), Some(&options)));
        drop(loaded?);
        let (map, mapped) = timed(|| WideMesh::map(&path, mesh.mesh().clone(), Some(&options)));
        drop(mapped?);
        sums.iter_mut().zip([save, load, map]).for_each(|(sum, time)| *sum += time.as_secs_f64());
    }
    Ok(sums)
}

fn trace_answers(
    workshop: &Workshop,
    tree: &TreeName,
    traversal: Traversal,
    subject: &Subject,
) -> Result<TraceAnswers> {
    let built = workshop.find(tree)?;
    let is_exact = traversal.promise() == Some(Promise::Exact);
    let mut sets: Vec<SetAnswers> =
        workshop.sets.iter().map(|set| workshop.pool.install(|| count(subject, set, is_exact))).collect();
    let (mut errors, mut leaks) = (None, Vec::new());
    if let Some(truth) = workshop.truth() {
        workshop.pool.install(|| {
            let judged: Vec<Errors> = truth.sets.iter().map(|set| Errors::of(&*subject.world, set)).collect();
            for (set, errors) in sets.iter_mut().zip(&judged) {
                set.errors = Some(ErrorSummary::of(errors));
            }
            errors = Some(ErrorSummary::of(&judged.into_iter().sum()));
            let counts = errors::leaks(&subject.meshes, &truth.leak_tests);
            leaks = counts.into_iter().map(|(aim, leaks, rays)| (aim.to_owned(), leaks, rays)).collect();
        });
    }
    Ok(TraceAnswers {
        instanced_primitives: subject.world.primitive_count(),
        trees: built.figures.clone(),
        sets,
        is_decidable: workshop.truth().is_some_and(|truth| truth.is_of_one_mesh),
        errors,
        leaks,
    })
}

/// So many rays have a hash of their own.
const CHUNK: usize = 1024;

/// Traces everything once without a clock: the answers and what they cost in steps.
///
/// A visitor of hits compares rounded t. So of an exact subject, which compares exact ones within a mesh, it agrees
/// about t and may name another primitive.
fn count(subject: &Subject, set: &RaySet, is_exact: bool) -> SetAnswers {
    let world = &*subject.world;
    let chunks: Vec<(SetAnswers, u64)> = set
        .rays
        .par_chunks(CHUNK)
        .zip(set.batch.par_chunks(CHUNK))
        .map(|(rays, batch)| {
            let mut answers = SetAnswers { rays: rays.len() as u64, ..no_answers(&set.name) };
            let mut hasher = DefaultHasher::new();
            let (mut many, mut any_many) = (Vec::new(), Vec::new());
            if subject.has_calls_of_its_own() {
                subject.closest(rays, batch, &mut many);
                subject.any(rays, batch, &mut any_many);
            }
            for (i, segment) in rays.iter().enumerate() {
                let Some(ray) = TraversalRay::new(&segment.ray) else { continue };
                let (mut closest, mut any) = (ClosestHit::new(segment.interval), FirstHit::default());
                let _ = world.visit_hits(&ray, segment.interval, HitKind::Material, &mut closest);
                let _ = world.visit_hits(&ray, segment.interval, HitKind::Material, &mut any);
                let (hit, visited) = (world.intersect(&ray, segment.interval), closest.hit());
                let (Work { nodes, primitives }, any_work) = (closest.work(), any.work());
                answers.closest_nodes += nodes;
                answers.closest_tests += primitives;
                answers.any_nodes += any_work.nodes;
                answers.any_tests += any_work.primitives;
                answers.hits += u64::from(hit.is_some());
                let agree = (hit == visited || (is_exact && hit.map(|h| h.t) == visited.map(|h| h.t)))
                    && any.hit().is_some() == hit.is_some()
                    && world.intersect_p(&ray, segment.interval) == hit.is_some()
                    && many.get(i).is_none_or(|h| *h == hit)
                    && any_many.get(i).is_none_or(|h| *h == hit.is_some());
                answers.disagreements += u64::from(!agree);
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
            (answers, hasher.finish())
        })
        .collect();
    let mut all = no_answers(&set.name);
    let mut hasher = DefaultHasher::new();
    for (part, hash) in chunks {
        hasher.write_u64(hash);
        all.rays += part.rays;
        all.hits += part.hits;
        all.closest_nodes += part.closest_nodes;
        all.closest_tests += part.closest_tests;
        all.any_nodes += part.any_nodes;
        all.any_tests += part.any_tests;
        all.disagreements += part.disagreements;
    }
    all.hash = format!("{:016x}", hasher.finish());
    all
}

fn no_answers(name: &str) -> SetAnswers {
    SetAnswers {
        name: name.to_owned(),
        rays: 0,
        hits: 0,
        closest_nodes: 0,
        closest_tests: 0,
        any_nodes: 0,
        any_tests: 0,
        hash: String::new(),
        disagreements: 0,
        errors: None,
    }
}
