//! A scene with its trees and a way to traverse them, ready to be asked.

use std::sync::Arc;

use anyhow::{Context, Result};
use bvh_flat::geometry::{Hit, MollerTrumboreTriangles, Naive, Shape, TraversalRay, UnpaddedBoxes};
use bvh_flat::primitive::Primitive;
use bvh_flat::{BuildError, BuildObserver, MeshBvh, RaySegment, SimdWidth, WideLayout, WideMesh};
use rayon::prelude::*;
use scene::{CompiledScene, MeshTree, Scene, SceneRay};

use super::configuration::{Calls, KernelName, Layout, Traversal, TreeName};

/// A thread that has none left takes as many or more from another.
const RAYS_OF_A_TASK: usize = 256;

/// A scene with its trees, of either kind.
pub enum Trees {
    Wide(CompiledScene),
    Binary(CompiledScene<MeshBvh>),
}

impl Trees {
    pub fn build(scene: &Arc<Scene>, name: &TreeName, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        let scene = Arc::clone(scene);
        let config = name.split_method.config();
        let config = name.max_primitives_in_leaf.map_or(config, |most| config.with_max_primitives_in_leaf(most));
        let wide = |scene, layout| {
            CompiledScene::build_by(scene, &config, observer, |mesh| {
                WideMesh::build_observed(mesh, &config, layout, observer)
            })
        };
        Ok(match name.layout {
            Layout::Wide => Self::Wide(wide(scene, WideLayout::Blocks)?),
            Layout::Compact => Self::Wide(wide(scene, WideLayout::Compact)?),
            Layout::Binary => Self::Binary(CompiledScene::build_with(scene, &config, observer)?),
        })
    }

    /// How long cache files with the trees over meshes are together, in bytes.
    pub fn file_length(&self) -> u64 {
        match self {
            Self::Wide(compiled) => compiled.meshes().iter().map(MeshTree::file_length).sum(),
            Self::Binary(compiled) => compiled.meshes().iter().map(MeshTree::file_length).sum(),
        }
    }

    /// What is kept beside the scene itself, in bytes.
    pub fn memory(&self) -> usize {
        match self {
            Self::Wide(compiled) => compiled.memory(),
            Self::Binary(compiled) => compiled.memory(),
        }
    }
}

/// A scene with its trees and one way to traverse them.
pub struct Subject {
    pub world: Arc<dyn Primitive>,
    /// Each mesh by itself, in its own space.
    pub meshes: Vec<Box<dyn Shape>>,
    /// The only mesh, to be asked many rays at once.
    batch: Option<WideMesh>,
    /// Whether the threads of the current pool share the rays.
    is_parallel: bool,
}

impl Subject {
    /// The library's default: wide trees at the widest.
    pub fn of_default(compiled: &CompiledScene) -> Result<Self> {
        Self::with_meshes(compiled, SimdWidth::widest(), WideMesh::clone)
    }

    pub fn new(trees: &Trees, traversal: Traversal) -> Result<Self> {
        match (trees, traversal) {
            (Trees::Wide(compiled), Traversal::Wide { simd_width, calls }) => {
                let width = simd_width.width().context("this processor does not have the SIMD width")?;
                let mut subject = Self::with_meshes(compiled, width, |mesh| mesh.with_simd_width(width))?;
                match calls {
                    Calls::Single => (),
                    Calls::Batch => subject.batch = compiled.meshes().first().map(|mesh| mesh.with_simd_width(width)),
                    Calls::Parallel => subject.is_parallel = true,
                }
                Ok(subject)
            }
            (Trees::Binary(compiled), Traversal::Binary { kernels }) => Self::of_kernels(compiled, kernels),
            _ => anyhow::bail!("the trees cannot be traversed in this way"),
        }
    }

    /// The trees over objects are wide, and the boxes of objects padded, whatever the kernels in meshes.
    fn of_kernels(compiled: &CompiledScene<MeshBvh>, kernels: KernelName) -> Result<Self> {
        let width = SimdWidth::widest();
        match kernels {
            KernelName::Exact => Self::with_meshes(compiled, width, MeshBvh::exact),
            KernelName::Watertight => Self::with_meshes(compiled, width, MeshBvh::clone),
            KernelName::UnpaddedBoxes => Self::with_meshes(compiled, width, MeshBvh::with_kernels::<UnpaddedBoxes>),
            KernelName::MollerTrumbore => {
                Self::with_meshes(compiled, width, MeshBvh::with_kernels::<MollerTrumboreTriangles>)
            }
            KernelName::Naive => Self::with_meshes(compiled, width, MeshBvh::with_kernels::<Naive>),
        }
    }

    fn with_meshes<M: MeshTree, N: MeshTree + Send + Sync + 'static>(
        compiled: &CompiledScene<M>,
        width: SimdWidth,
        shape: impl Fn(&M) -> N,
    ) -> Result<Self> {
        let compiled = compiled.with_meshes(width, shape)?;
        let boxed = |mesh: &N| Box::new(mesh.clone()) as Box<dyn Shape>;
        let meshes = compiled.meshes().iter().map(boxed).collect();
        Ok(Self { world: compiled.shared_world(), meshes, batch: None, is_parallel: false })
    }

    /// Whether rays are not just asked one by one.
    pub fn has_calls_of_its_own(&self) -> bool {
        self.batch.is_some() || self.is_parallel
    }

    /// The closest hits, as the calls are to be. Rays that make no sense are misses, as in a query by the user.
    pub fn closest(&self, rays: &[SceneRay], many: &[RaySegment], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        if let Some(mesh) = &self.batch {
            hits.resize(many.len(), None);
            mesh.intersect_many(many, hits);
        } else {
            self.ask(rays, hits, |r, ray| self.world.intersect(ray, r.interval));
        }
    }

    /// Whether each ray hits anything, likewise.
    pub fn any(&self, rays: &[SceneRay], many: &[RaySegment], hits: &mut Vec<bool>) {
        hits.clear();
        if let Some(mesh) = &self.batch {
            hits.resize(many.len(), false);
            mesh.intersect_p_many(many, hits);
        } else {
            self.ask(rays, hits, |r, ray| self.world.intersect_p(ray, r.interval));
        }
    }

    /// One by one, on this thread or on all.
    fn ask<T: Default + Send>(
        &self,
        rays: &[SceneRay],
        answers: &mut Vec<T>,
        query: impl Fn(&SceneRay, &TraversalRay) -> T + Sync,
    ) {
        let answer = |r: &SceneRay| TraversalRay::new(&r.ray).map_or_else(T::default, |ray| query(r, &ray));
        if self.is_parallel {
            rays.par_iter().with_min_len(RAYS_OF_A_TASK).map(answer).collect_into_vec(answers);
        } else {
            answers.extend(rays.iter().map(answer));
        }
    }
}
