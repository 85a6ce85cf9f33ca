//! A triangle mesh with a wide tree: exact decisions, eight boxes or triangles at a time.

use std::marker::PhantomData;
use std::sync::Arc;

use geometry::{Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, TriangleMesh, Visit};

#[cfg(feature = "parallel")]
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
#[cfg(feature = "parallel")]
use rayon::slice::{ParallelSlice, ParallelSliceMut};

#[cfg(feature = "build")]
use geometry::clipped_triangle_bounds;

use crate::quality::Boxes;
use crate::refit::ratio;
#[cfg(feature = "build")]
use crate::simd::LANES;
use crate::simd::SimdWidth;
use crate::wide::{
    All, Answered, AnyQuery, BinaryTree, Blocks, ClosestQuery, Compact, CompactNode, FullNode, LARGE, NoWideTree,
    TriangleWriter, Triangles, Watch, answer, answer_many, boxes, collapse, leaf_cost, refit, with_small_leaves,
};
#[cfg(feature = "build")]
use crate::wide::{LEAF_COST, TRIANGLE_COST, prefetch_vertices};
#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError, BuildObserver};
use crate::{MeshBvh, RaySegment, RefitError};

/// How many rays a thread takes at once.
#[cfg(feature = "parallel")]
const PARALLEL_CHUNK: usize = 4096;

/// A triangle mesh with a wide tree over its triangles: nodes of eight children and leaves of up to eight triangles,
/// each tested at once. Its answers are those of [`ExactMesh`](crate::ExactMesh), bit for bit, on every [`SimdWidth`].
///
/// *How.* Eight boxes or triangles are tested in f32 with bounds on every error, so that nothing is lost. What f32
/// leaves open (a ray at an edge, two hits whose t are too close) is decided by an
/// [`ExactRay`](geometry::exact::ExactRay), and the values of the hit that is reported are computed by one. Since every
/// decision is that of real arithmetic, it cannot depend on a tree, a layout or the width of registers.
#[derive(Clone, Debug)]
pub struct WideMesh {
    pub(crate) triangles: Arc<Triangles>,
    layout: WideLayout,
    width: SimdWidth,
}

/// What a wide tree keeps of its triangles. The answers are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WideLayout {
    /// Nodes of 256 bytes, and in the leaves the vertices, as they are tested: about 58 bytes a triangle. The fastest.
    #[default]
    Blocks,
    /// Nodes of 128 bytes, whose boxes are quantised outward, and in the leaves numbers of triangles, whose vertices
    /// are read from the mesh: about 20 bytes a triangle. For scenes that should fit.
    Compact,
}

impl WideLayout {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Blocks, Self::Compact];

    /// Its name in tables and on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Blocks => "blocks",
            Self::Compact => "compact",
        }
    }
}

/// How the binary tree is built that is to be collapsed. As many primitives as the configuration allows are never
/// divided: testing them costs a leaf next to nothing, and the collapse merges leaves where that is cheaper. But where
/// leaves are merged before subtrees are moved, it is by what they cost in a wide tree. A node with eight children
/// costs 1, so a binary one about a third of that.
///
/// Moving the primitives one by one makes no better trees, takes a third of the build's time more, and leaves smaller
/// leaves behind: kitchen has 58.2 bytes a triangle instead of 55.8.
#[cfg(feature = "build")]
fn binary_config(config: &BuildConfig) -> BuildConfig {
    match config.reinsertion.filter(|options| options.merged_leaves) {
        None => config
            .with_max_primitives_in_leaf(config.max_primitives_in_leaf.min(LANES as u32))
            .with_costs(0.3, 0.0)
            .with_leaf_cost(0.0),
        Some(_) => config
            .with_max_primitives_in_leaf(LANES as u32)
            .with_costs(0.3, TRIANGLE_COST as f32)
            .with_leaf_cost(LEAF_COST as f32),
    }
}

/// How many triangles ahead of that whose bounds are asked for the memory is asked for vertices.
#[cfg(feature = "build")]
const BOUNDS_AHEAD: usize = 24;

impl WideMesh {
    /// Builds a tree over `mesh`. Sets of up to `config.max_primitives_in_leaf` triangles are not divided any more;
    /// leaves of up to eight are made of them by what these cost in a wide tree, whatever the costs of `config` are.
    /// With reinsertion and merged leaves, those sets are up to eight, whatever `config` says.
    ///
    /// Triangles with a coordinate that is NaN, infinite or beyond 2⁶⁰ are inactive: they keep their number and are
    /// never hit.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration that the builder refuses, or a mesh whose tree would be larger than 16 GiB.
    #[cfg(feature = "build")]
    pub fn build(mesh: impl Into<Arc<TriangleMesh>>, config: &BuildConfig) -> Result<Self, BuildError> {
        Self::build_observed(mesh, config, WideLayout::Blocks, &())
    }

    /// Builds a tree over `mesh` in a layout; `observer` is told how far it has come, and may cancel it.
    ///
    /// # Errors
    /// As [`build`](Self::build); and [`BuildError::Cancelled`].
    #[cfg(feature = "build")]
    pub fn build_observed(
        mesh: impl Into<Arc<TriangleMesh>>,
        config: &BuildConfig,
        layout: WideLayout,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        let mesh = mesh.into();
        let bounds = |i: u32| {
            // Neighbours in the order of triangles may have vertices anywhere.
            prefetch_vertices(&mesh, i as usize + BOUNDS_AHEAD);
            mesh.triangle_bounds(i as usize)
        };
        let clipped = |i: u32, to: &Bounds3| clipped_triangle_bounds(&mesh.vertices(i as usize), to);
        let tree = bvh_build::build_split(mesh.len(), bounds, &clipped, &binary_config(config), observer)?;
        let is_split = tree.statistics().reference_count > tree.statistics().active_count;
        Self::collapsed(&mesh, tree.nodes(), tree.order(), is_split, layout, &observer)
            .map_err(|why| why.of(mesh.len()))
    }

    /// Collapses the tree of a mesh: for a tree that was loaded or made elsewhere, and without the feature `build`.
    /// `None` where it does not fit the 16 GiB that its references can name.
    pub fn new(mesh: &MeshBvh, layout: WideLayout) -> Option<Self> {
        let bvh = mesh.bvh();
        let is_split = bvh.extra_references() > 0;
        Self::collapsed(mesh.mesh(), &*with_small_leaves(bvh), bvh.order(), is_split, layout, &()).ok()
    }

    fn collapsed(
        mesh: &Arc<TriangleMesh>,
        tree: &(impl BinaryTree + ?Sized),
        order: &[u32],
        is_split: bool,
        layout: WideLayout,
        watch: &impl Watch,
    ) -> Result<Self, NoWideTree> {
        let tree = match layout {
            WideLayout::Blocks => {
                collapse::<FullNode>(tree, is_split, &TriangleWriter::<Blocks>::new(mesh, order, is_split), watch)?
            }
            WideLayout::Compact => {
                collapse::<CompactNode>(tree, is_split, &TriangleWriter::<Compact>::new(mesh, order, is_split), watch)?
            }
        };
        let triangles = Arc::new(Triangles { mesh: Arc::clone(mesh), tree });
        Ok(Self { triangles, layout, width: SimdWidth::default() })
    }

    /// Adapts the tree to another mesh of as many triangles, whose places changed: the same triangles stay in the same
    /// leaves, and answers are those of `mesh`. In place, on all threads of the current rayon pool with the feature
    /// `parallel`, and with the same result on any number; linear in the number of triangles. Where a clone shares the
    /// tree, or it is mapped from a file, a copy is adapted.
    ///
    /// The result is the cost of the new tree by the surface area heuristic as a part of that of the one it was adapted
    /// from, at the costs of [`quality`](Self::quality): where the product since the build gets large (2, say), rays
    /// would gain by a new build. 1 where either has no area.
    ///
    /// # Errors
    /// [`RefitError`], and the tree is as it was: for another number of triangles, with spatial splits, and where a
    /// triangle became active or inactive.
    pub fn refit(&mut self, mesh: impl Into<Arc<TriangleMesh>>) -> Result<f64, RefitError> {
        let mesh = mesh.into();
        let Triangles { mesh: old, tree } = &*self.triangles;
        if mesh.len() != old.len() {
            return Err(RefitError::Count { expected: old.len(), found: mesh.len() });
        }
        if tree.is_split {
            return Err(RefitError::Split);
        }
        let is_active = |mesh: &TriangleMesh, i: usize| mesh.triangle_bounds(i).is_valid();
        if let Some(primitive) = (0..mesh.len()).find(|&i| is_active(old, i) != is_active(&mesh, i)) {
            return Err(RefitError::Activity { primitive });
        }
        let old_cost = tree.expected_steps;
        let triangles = Arc::make_mut(&mut self.triangles);
        let refitted = match self.layout {
            WideLayout::Blocks => refit::<Blocks>(&mut triangles.tree, &mesh, &leaf_cost),
            WideLayout::Compact => refit::<Compact>(&mut triangles.tree, &mesh, &leaf_cost),
        };
        debug_assert!(refitted.is_some(), "the references of a valid tree lead to lines");
        triangles.mesh = mesh;
        Ok(ratio([old_cost, triangles.tree.expected_steps]))
    }

    /// A mesh and a tree that has been validated, or made.
    #[cfg(feature = "cache")]
    pub(crate) fn from_triangles(triangles: Triangles, layout: WideLayout) -> Self {
        Self { triangles: Arc::new(triangles), layout, width: SimdWidth::default() }
    }

    /// The tree.
    #[cfg(feature = "cache")]
    pub(crate) fn tree(&self) -> &crate::wide::WideTree {
        &self.triangles.tree
    }

    /// The same mesh and tree, traversed with another width.
    #[must_use]
    pub fn with_simd_width(&self, width: SimdWidth) -> Self {
        Self { triangles: Arc::clone(&self.triangles), width, ..*self }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.triangles.mesh
    }

    /// What is kept of the triangles.
    pub fn layout(&self) -> WideLayout {
        self.layout
    }

    /// What is kept beside the mesh itself, in bytes: nodes and leaves. Clones share it.
    pub fn memory(&self) -> usize {
        self.triangles.tree.arena.memory()
    }

    pub(crate) fn boxes(&self) -> Boxes {
        match self.layout {
            WideLayout::Blocks => boxes::<Blocks>(&self.triangles.tree),
            WideLayout::Compact => boxes::<Compact>(&self.triangles.tree),
        }
    }

    /// The closest hit of each ray, as [`intersect`](Shape::intersect) finds it, bit for bit: `hits[i]` is that of
    /// `rays[i]`, and `None` for a ray or an interval that is not valid. Where one slice is longer, its rest is left
    /// alone.
    ///
    /// Several times as fast as a call for each where neighbours in the slice go the same way, as those of a tile of 8
    /// × 8 or 16 × 4 pixels do: they then go through the tree together. And faster where the tree is larger than the
    /// caches and the rays go apart: several are then on their way at once, and while one waits for the memory, others
    /// go on. Which way is taken depends on the rays and the tree, never on time.
    pub fn intersect_many(&self, rays: &[RaySegment], hits: &mut [Option<Hit>]) {
        match self.layout {
            WideLayout::Blocks => self.many::<ClosestQuery<Blocks>>(rays, hits),
            WideLayout::Compact => self.many::<ClosestQuery<Compact>>(rays, hits),
        }
    }

    /// Whether each ray hits anything, as [`intersect_p`](Shape::intersect_p) finds it; the slices are as those of
    /// [`intersect_many`](Self::intersect_many).
    pub fn intersect_p_many(&self, rays: &[RaySegment], hits: &mut [bool]) {
        match self.layout {
            WideLayout::Blocks => self.many::<AnyQuery<Blocks>>(rays, hits),
            WideLayout::Compact => self.many::<AnyQuery<Compact>>(rays, hits),
        }
    }

    /// [`intersect_many`](Self::intersect_many) on all threads of the current rayon pool.
    #[cfg(feature = "parallel")]
    pub fn par_intersect_many(&self, rays: &[RaySegment], hits: &mut [Option<Hit>]) {
        let chunks = rays.par_chunks(PARALLEL_CHUNK).zip(hits.par_chunks_mut(PARALLEL_CHUNK));
        chunks.for_each(|(rays, hits)| self.intersect_many(rays, hits));
    }

    /// [`intersect_p_many`](Self::intersect_p_many) on all threads of the current rayon pool.
    #[cfg(feature = "parallel")]
    pub fn par_intersect_p_many(&self, rays: &[RaySegment], hits: &mut [bool]) {
        let chunks = rays.par_chunks(PARALLEL_CHUNK).zip(hits.par_chunks_mut(PARALLEL_CHUNK));
        chunks.for_each(|(rays, hits)| self.intersect_p_many(rays, hits));
    }

    fn many<'a, Q: Answered<'a>>(&'a self, rays: &[RaySegment], answers: &mut [Q::Answer]) {
        answer_many::<Q>(&self.triangles, self.width, LARGE, rays, answers);
    }

    #[inline(always)]
    fn one<'a, Q: Answered<'a>>(&'a self, ray: &TraversalRay, interval: Interval) -> Q::Answer {
        answer::<Q>(&self.triangles, self.width, ray, interval)
    }
}

impl Shape for WideMesh {
    fn object_bound(&self) -> Bounds3 {
        self.triangles.tree.bounds
    }

    fn primitive_count(&self) -> u64 {
        self.triangles.mesh.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        let triangles = &*self.triangles;
        match self.layout {
            WideLayout::Blocks => {
                self.width.run(All { triangles, ray, interval, visitor, layout: PhantomData::<Blocks> })
            }
            WideLayout::Compact => {
                self.width.run(All { triangles, ray, interval, visitor, layout: PhantomData::<Compact> })
            }
        }
    }

    // Not inlined into other crates, nor the next: each would compile all kernels again, and by its own profile.
    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        match self.layout {
            WideLayout::Blocks => self.one::<ClosestQuery<Blocks>>(ray, interval),
            WideLayout::Compact => self.one::<ClosestQuery<Compact>>(ray, interval),
        }
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        match self.layout {
            WideLayout::Blocks => self.one::<AnyQuery<Blocks>>(ray, interval),
            WideLayout::Compact => self.one::<AnyQuery<Compact>>(ray, interval),
        }
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.triangles.mesh.surface_point(ray, hit)
    }
}
