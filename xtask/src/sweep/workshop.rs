//! What the jobs of one scene have in common: the scene, trees, rays, and the exact answers.

use std::sync::Arc;
use std::sync::OnceLock;

use anyhow::{Context, Result};
use bvh_flat::RaySegment;
use bvh_flat::bvh_build::TreeStatistics;
use bvh_flat::primitive::Primitive;
use scene::{Camera, CompiledScene, RaySets, Scene, SceneRay};

use super::configuration::{Layout, TreeName};
use super::occlusion::Occlusion;
use super::plan::Plan;
use super::quality::quality;
use super::results::TreeFigures;
use super::run::{build_error, is_interrupted};
use super::subject::Trees;
use crate::errors::Truth;
use crate::input::{self, SEED, SceneSource, SplitMethodName};
use crate::measure::BuildClock;
use crate::trace::read_rays;

/// A scene, ready for its jobs.
pub struct Workshop<'a> {
    pub plan: &'a Plan,
    pub pool: &'a rayon::ThreadPool,
    pub scene: Arc<Scene>,
    pub trees: Vec<BuiltTrees>,
    pub sets: Vec<RaySet>,
    /// Where the library's default is not among `trees`.
    own: Option<CompiledScene>,
    truth: OnceLock<Option<Truth>>,
    reference: OnceLock<Vec<f32>>,
}

/// Trees that jobs ask for by name.
pub struct BuiltTrees {
    pub name: TreeName,
    pub trees: Trees,
    pub figures: TreeFigures,
}

/// A set of rays, for calls one by one and for many.
pub struct RaySet {
    pub name: String,
    pub rays: Vec<SceneRay>,
    pub batch: Vec<RaySegment>,
}

/// A pool of so many threads, where a number is said.
pub fn own_pool(threads: Option<u32>) -> Result<Option<rayon::ThreadPool>> {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build();
    Ok(threads.map(pool).transpose()?)
}

impl<'a> Workshop<'a> {
    /// A scene of the plan with the trees of `names`; `progress` is told of each step.
    pub fn open(
        plan: &'a Plan,
        scene: usize,
        names: &[TreeName],
        pool: &'a rayon::ThreadPool,
        progress: &dyn Fn(&str) -> Result<()>,
    ) -> Result<Self> {
        progress("load")?;
        let source = SceneSource::parse(&plan.scenes[scene].source).map_err(anyhow::Error::msg)?;
        let scene = Arc::new(source.load()?);
        let mut trees = Vec::new();
        for &name in names {
            progress(&format!("build {}", name.describe()))?;
            trees.push(build(&scene, name, pool)?);
        }
        let mut workshop = Self {
            plan,
            pool,
            scene,
            trees,
            sets: Vec::new(),
            own: None,
            truth: OnceLock::new(),
            reference: OnceLock::new(),
        };
        if workshop.default_among_trees().is_none() {
            let clock = BuildClock::until(is_interrupted);
            let build = || CompiledScene::build(Arc::clone(&workshop.scene), &SplitMethodName::Sah.config(), &clock);
            workshop.own = Some(pool.install(build).map_err(build_error)?);
        }
        progress("aim rays")?;
        workshop.sets = workshop.aim()?;
        Ok(workshop)
    }

    fn aim(&self) -> Result<Vec<RaySet>> {
        let compiled = self.default_trees()?;
        let (camera, bounds) = (self.camera()?, compiled.world().world_bound());
        let count = if self.plan.ray_sets.is_empty() { 0 } else { self.plan.rays as usize };
        let generated = RaySets::generate(compiled.world(), &bounds, &camera, count, SEED)?;
        let mut sets: Vec<(String, Vec<SceneRay>)> = Vec::new();
        for name in &self.plan.ray_sets {
            let (_, rays) =
                generated.named().into_iter().find(|(known, _)| *known == name.name()).context("no such set")?;
            sets.push((name.name().to_owned(), rays.to_vec()));
        }
        for file in &self.plan.ray_files {
            sets.push((file.name(), read_rays(&file.path)?));
        }
        let set = |(name, rays): (String, Vec<SceneRay>)| RaySet {
            name,
            batch: rays.iter().map(RaySegment::from).collect(),
            rays,
        };
        Ok(sets.into_iter().map(set).collect())
    }

    /// The scene's camera, with what was asked for.
    pub fn camera(&self) -> Result<Camera> {
        let own = input::camera(self.default_trees()?);
        let Some(text) = &self.plan.camera else { return Ok(own) };
        own.with_settings(&text.parse()?).map_err(input::usage_error)
    }

    /// The trees that rays and exact answers are made with: the library's default, whatever is measured.
    pub fn default_trees(&self) -> Result<&CompiledScene> {
        self.own.as_ref().or_else(|| self.default_among_trees()).context("no trees of the default")
    }

    fn default_among_trees(&self) -> Option<&CompiledScene> {
        let is_default = |name: &TreeName| (name.split_method, name.layout) == (SplitMethodName::Sah, Layout::Wide);
        self.trees.iter().find_map(|built| match &built.trees {
            Trees::Wide(compiled) if is_default(&built.name) => Some(compiled),
            _ => None,
        })
    }

    /// The trees of a name.
    pub fn find(&self, name: &TreeName) -> Result<&BuiltTrees> {
        self.trees.iter().find(|built| built.name == *name).context("trees that were not built")
    }

    /// The exact answers; `None` where they are not asked for, or the scene is too large.
    pub fn truth(&self) -> Option<&Truth> {
        let truth = || match self.plan.judged_rays {
            0 => None,
            count => {
                let sets: Vec<(&str, &[SceneRay])> = self.sets.iter().map(|s| (s.name.as_str(), &s.rays[..])).collect();
                self.pool.install(|| Truth::new(self.default_trees().ok()?, &sets, count as usize))
            }
        };
        self.truth.get_or_init(truth).as_ref()
    }

    /// The image that others of ambient occlusion are compared with.
    pub fn reference(&self, occlusion: &Occlusion) -> &[f32] {
        self.reference.get_or_init(|| self.pool.install(|| occlusion.reference()))
    }
}

/// Builds trees without a clock: caches and pages are warm then, and none pays for being the first.
fn build(scene: &Arc<Scene>, name: TreeName, pool: &rayon::ThreadPool) -> Result<BuiltTrees> {
    let clock = BuildClock::until(is_interrupted);
    let trees = pool.install(|| Trees::build(scene, &name, &clock)).map_err(build_error)?;
    let statistics = clock.trees();
    let sum = |f: fn(&TreeStatistics) -> u32| statistics.iter().map(|t| u64::from(f(t))).sum::<u64>();
    let weighted_cost: f64 = statistics.iter().map(|t| t.sah_cost * f64::from(t.active_count)).sum();
    let figures = TreeFigures {
        nodes: sum(|t| t.node_count),
        leaves: sum(|t| t.leaf_count),
        depth: statistics.iter().map(|t| t.depth).max().unwrap_or(0),
        sah_cost: weighted_cost / sum(|t| t.active_count).max(1) as f64,
        bytes: trees.memory() as u64,
        bytes_on_disk: trees.file_length(),
        quality: pool.install(|| quality(&trees)),
    };
    Ok(BuiltTrees { name, trees, figures })
}
