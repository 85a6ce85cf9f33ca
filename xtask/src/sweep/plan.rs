//! The plan of a sweep: what is to be done, as data. The same options, scenes and program give the same plan
//! everywhere.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use bvh_flat::cache::GeometryKey;
use scene::{Scene, SceneShape};
use serde::{Deserialize, Serialize};

use super::configuration::{Calls, KernelName, Layout, Traversal, TreeName, WidthName};
use super::effort::PictureSizes;
use super::host::Program;
use super::settings::{RaySetName, Settings, WidthChoice};
use super::sweep_file::{Grid, Named};
use crate::input::{SEED, SceneSource, SplitMethodName, usage_error};

/// Results of another number are not read.
const FORMAT: u32 = 2;

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Of everything below. Results of different plans are never mixed.
    pub id: String,
    pub format: u32,
    pub program: Program,
    pub seed: u64,
    /// Of each generated set, at most.
    pub rays: u32,
    /// Of each set, at most.
    pub judged_rays: u32,
    pub ray_sets: Vec<RaySetName>,
    pub ray_files: Vec<RayFile>,
    /// What is other than in the scenes' own cameras, as [`scene::CameraSettings`] are written.
    pub camera: Option<String>,
    pub pictures: Option<PictureSizes>,
    pub scenes: Vec<PlannedScene>,
    pub jobs: Vec<Job>,
}

/// A file of rays.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayFile {
    pub path: PathBuf,
    pub fingerprint: String,
}

/// A scene of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedScene {
    pub name: String,
    /// As the command line names it.
    pub source: String,
    /// Of its geometry.
    pub fingerprint: String,
    /// Triangles and spheres in memory, each once.
    pub primitives: u64,
}

/// A part of the plan that is done as a whole, and has a file of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Of the scene, the settings that its results depend on, and the task.
    pub id: String,
    /// Its place in [`Plan::scenes`].
    pub scene: usize,
    pub task: Task,
}

impl Task {
    /// The trees that it needs, beside those that every job does.
    pub fn tree(&self) -> Option<TreeName> {
        match *self {
            Self::Trace { tree, .. } | Self::Picture { tree } | Self::Cache { tree } => Some(tree),
            Self::Leaks => None,
        }
    }
}

/// What is done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Task {
    /// Rays are traced, and their answers judged.
    Trace { tree: TreeName, traversal: Traversal },
    /// The scene is drawn: nodes visited, and ambient occlusion against time.
    Picture { tree: TreeName },
    /// Naive and watertight kernels are shown beside each other.
    Leaks,
    /// Trees are kept in files.
    Cache { tree: TreeName },
}

impl Plan {
    /// The plan of `settings`; loads every scene to look at it.
    pub fn new(settings: &Settings) -> Result<Self> {
        let mut plan = Self {
            id: String::new(),
            format: FORMAT,
            program: Program::this(),
            seed: SEED,
            rays: settings.rays,
            judged_rays: settings.judged_rays,
            ray_sets: settings.ray_sets.clone(),
            ray_files: Vec::new(),
            camera: settings.camera.clone(),
            pictures: settings.pictures,
            scenes: Vec::new(),
            jobs: Vec::new(),
        };
        for path in &settings.ray_files {
            let bytes = std::fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
            plan.ray_files.push(RayFile { path: path.clone(), fingerprint: hash_of(&bytes) });
        }
        ensure!(!(plan.ray_sets.is_empty() && plan.ray_files.is_empty()), usage_error("there are no rays to trace"));
        for source in &settings.scenes {
            plan.add_scene(source, settings)?;
        }
        ensure!(!plan.jobs.is_empty(), usage_error("no configuration is left to measure"));
        plan.id = hash_of(&serde_json::to_string(&plan)?);
        Ok(plan)
    }

    fn add_scene(&mut self, source: &SceneSource, settings: &Settings) -> Result<()> {
        let scene = source.load()?;
        let (number, is_one_mesh) = (self.scenes.len(), is_one_mesh(&scene));
        self.scenes.push(PlannedScene {
            name: source.name(),
            source: source.to_string(),
            fingerprint: fingerprint(&scene),
            primitives: scene.geometries().iter().map(|g| g.shape.primitive_count()).sum(),
        });
        let mut tasks = Vec::new();
        for grid in &settings.grids {
            add_grid(&mut tasks, grid, is_one_mesh)?;
        }
        // Wide trees of each split method, once.
        let mut builders: Vec<TreeName> = Vec::new();
        for task in &tasks {
            if let Task::Trace { tree, .. } = task
                && tree.layout == Layout::Wide
                && !builders.iter().any(|known| known.split_method == tree.split_method)
            {
                builders.push(*tree);
            }
        }
        let has_mesh = scene.geometries().iter().any(|g| matches!(g.shape, SceneShape::Mesh(_)));
        if settings.pictures.is_some() {
            tasks.extend(has_mesh.then_some(Task::Leaks));
            tasks.extend(builders.iter().map(|&tree| Task::Picture { tree }));
        }
        if settings.cache && has_mesh {
            tasks.extend(builders.iter().map(|&tree| Task::Cache { tree }));
        }
        let rays = (self.rays, self.judged_rays, &self.ray_sets, &self.ray_files, &self.camera);
        let shared = (&self.program, rays, self.pictures);
        let shared = serde_json::to_string(&(shared, &self.scenes[number]))?;
        for task in tasks {
            let id = hash_of(&format!("{shared}{}", serde_json::to_string(&task)?));
            self.jobs.push(Job { id, scene: number, task });
        }
        Ok(())
    }

    /// `jobs` of the plan as lines of JSON.
    pub fn list(&self, jobs: &[&Job]) -> String {
        #[derive(Serialize)]
        struct Line<'a> {
            id: &'a str,
            scene: &'a str,
            #[serde(flatten)]
            task: Task,
        }
        let line = |job: &Job| {
            serde_json::to_string(&Line { id: &job.id, scene: &self.scenes[job.scene].name, task: job.task })
        };
        jobs.iter().filter_map(|job| line(job).ok()).fold(String::new(), |text, line| text + &line + "\n")
    }

    /// The names of the ray sets, in order.
    pub fn ray_set_names(&self) -> Vec<String> {
        let generated = self.ray_sets.iter().map(|set| set.name().to_owned());
        generated.chain(self.ray_files.iter().map(RayFile::name)).collect()
    }
}

impl RayFile {
    /// Its name in tables.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }
}

/// The tasks of a grid that are not there already. What a layout knows nothing of, it ignores.
fn add_grid(tasks: &mut Vec<Task>, grid: &Grid, is_one_mesh: bool) -> Result<()> {
    let methods = or(&grid.split_method, SplitMethodName::Sah);
    let layouts = or(&grid.layout, Layout::Wide);
    let kernels = or(&grid.kernels, KernelName::Watertight);
    let mut calls = or(&grid.calls, Calls::Single);
    calls.retain(|calls| *calls != Calls::Batch || is_one_mesh);
    let mut widths: Vec<WidthName> = Vec::new();
    for choice in or(&grid.simd_width, WidthChoice::Widest) {
        widths.extend(choice.widths().map_err(usage_error)?);
    }
    let optional =
        |values: &[u32]| if values.is_empty() { vec![None] } else { values.iter().copied().map(Some).collect() };
    for &layout in &layouts {
        let (leaves, traversals): (Vec<Option<u32>>, Vec<Traversal>) = match layout {
            Layout::Binary => {
                let traversals = kernels.iter().map(|&kernels| Traversal::Binary { kernels });
                (optional(&grid.max_primitives_in_leaf), traversals.collect())
            }
            Layout::Wide | Layout::Compact => {
                let of_width = |&simd_width| calls.iter().map(move |&calls| Traversal::Wide { simd_width, calls });
                (vec![None], widths.iter().flat_map(of_width).collect())
            }
        };
        for &split_method in &methods {
            for &max_primitives_in_leaf in &leaves {
                for &threads in &optional(&grid.threads) {
                    let tree = TreeName { split_method, layout, max_primitives_in_leaf, threads };
                    for &traversal in &traversals {
                        let task = Task::Trace { tree, traversal };
                        if !tasks.contains(&task) {
                            tasks.push(task);
                        }
                    }
                }
            }
        }
    }
    Ok(())
}

fn or<T: clap::ValueEnum + Copy>(values: &[Named<T>], default: T) -> Vec<T> {
    if values.is_empty() { vec![default] } else { values.iter().map(|Named(value)| *value).collect() }
}

/// Whether the whole scene is one mesh in place, so that it can be asked as such.
fn is_one_mesh(scene: &Scene) -> bool {
    let [world, ..] = scene.objects() else { return false };
    let [only] = scene.geometries() else { return false };
    let is_mesh = matches!(only.shape, SceneShape::Mesh(_)) && only.surface.has_material();
    is_mesh && world.geometries.len() == 1 && world.instances.is_empty()
}

/// Of the geometry: each shape, and where it is.
fn fingerprint(scene: &Scene) -> String {
    let mut hasher = DefaultHasher::new();
    for geometry in scene.geometries() {
        match &geometry.shape {
            SceneShape::Mesh(mesh) => GeometryKey::of_mesh(mesh).to_string().hash(&mut hasher),
            SceneShape::Sphere(sphere) => format!("{sphere:?}").hash(&mut hasher),
        }
    }
    for object in scene.objects() {
        object.geometries.hash(&mut hasher);
        for instance in &object.instances {
            (instance.object.index(), format!("{:?}", instance.placement)).hash(&mut hasher);
        }
    }
    format!("{:016x}", hasher.finish())
}

/// A short name for content. SipHash with fixed keys: no defence against somebody who wants two contents to have one
/// name.
pub fn hash_of(content: &(impl Hash + ?Sized)) -> String {
    let mut hasher = DefaultHasher::new();
    content.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}
