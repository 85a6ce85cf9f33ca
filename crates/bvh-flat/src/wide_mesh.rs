//! A triangle mesh with a wide tree: exact decisions, eight boxes or triangles at a time.

use std::marker::PhantomData;
use std::sync::Arc;

use geometry::{Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, TriangleMesh, Visit};

#[cfg(feature = "parallel")]
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
#[cfg(feature = "parallel")]
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use crate::RaySegment;
use crate::simd::SimdWidth;
use crate::wide::{
    All, Answered, AnyQuery, ClosestQuery, LARGE_FOR_ANY, LARGE_FOR_CLOSEST, Many, One, TriangleBlocks, WideTree,
    collapse,
};
#[cfg(feature = "build")]
use crate::wide::{MAX_LINES, NODE_LINES};
#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError, BuildObserver};
use crate::{FlatBvh, MeshBvh};

/// How many rays a thread takes at once.
#[cfg(feature = "parallel")]
const PARALLEL_CHUNK: usize = 4096;

/// A triangle mesh with a wide tree over its triangles: nodes of eight children and leaves of up to eight triangles, each
/// tested at once. Its answers are those of [`ExactMesh`](crate::ExactMesh), bit for bit, on every [`SimdWidth`].
///
/// *How.* Eight boxes or triangles are tested in f32 with bounds on every error, so that nothing is lost. What f32 leaves
/// open (a ray at an edge, two hits whose t are too close) is decided by an [`ExactRay`](geometry::exact::ExactRay), and
/// the values of the hit that is reported are computed by one. Since every decision is that of real arithmetic, it cannot
/// depend on a tree, a layout or the width of registers.
#[derive(Clone, Debug)]
pub struct WideMesh {
    shared: Arc<Shared>,
    width: SimdWidth,
}

#[derive(Debug)]
struct Shared {
    mesh: Arc<TriangleMesh>,
    tree: WideTree,
}

impl WideMesh {
    /// Builds a tree over `mesh`. The leaves are made by cost, of at most eight triangles, whatever
    /// `config.max_primitives_in_leaf` says.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration that the builder refuses, or a mesh whose tree would be larger than 16 GiB.
    #[cfg(feature = "build")]
    pub fn build(mesh: impl Into<Arc<TriangleMesh>>, config: &BuildConfig) -> Result<Self, BuildError> {
        Self::build_observed(mesh, config, &())
    }

    /// Builds a tree over `mesh`, telling `observer` of each phase.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    #[cfg(feature = "build")]
    pub fn build_observed(
        mesh: impl Into<Arc<TriangleMesh>>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        let mesh = mesh.into();
        let bounds: Vec<Bounds3> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
        let bvh = FlatBvh::build(&bounds, &config.with_max_primitives_in_leaf(1), observer)?;
        // At most a line for each triangle and a node for each but one always fit; most meshes need a fifth of that.
        let limit = MAX_LINES / (1 + NODE_LINES);
        Self::from_tree(&mesh, &bvh).ok_or(BuildError::TooManyPrimitives { count: mesh.len(), limit })
    }

    /// Collapses the tree of a mesh. `None` where it does not fit the 16 GiB that its references can name.
    pub fn new(mesh: &MeshBvh) -> Option<Self> {
        Self::from_tree(mesh.mesh(), mesh.bvh())
    }

    pub(crate) fn from_tree(mesh: &Arc<TriangleMesh>, bvh: &FlatBvh) -> Option<Self> {
        let tree = collapse(bvh, &TriangleBlocks { mesh, order: bvh.order() })?;
        Some(Self { shared: Arc::new(Shared { mesh: Arc::clone(mesh), tree }), width: SimdWidth::default() })
    }

    /// The same mesh and tree, traversed with another width.
    pub fn with_simd_width(&self, width: SimdWidth) -> Self {
        Self { shared: Arc::clone(&self.shared), width }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.shared.mesh
    }

    /// What is kept beside the mesh itself, in bytes.
    pub fn memory(&self) -> usize {
        self.shared.tree.arena.memory()
    }

    /// The closest hit of each ray, as [`intersect`](Shape::intersect) finds it, bit for bit; as many as there are of both.
    ///
    /// Faster than a call for each where the tree is larger than the caches and the rays go apart: several are then on
    /// their way at once, and while one waits for the memory, others go on.
    pub fn intersect_many(&self, rays: &[RaySegment], hits: &mut [Option<Hit>]) {
        self.many::<ClosestQuery>(rays, hits, LARGE_FOR_CLOSEST);
    }

    /// Whether each ray hits anything, as [`intersect_p`](Shape::intersect_p) finds it; as many as there are of both.
    pub fn intersect_p_many(&self, rays: &[RaySegment], hits: &mut [bool]) {
        self.many::<AnyQuery>(rays, hits, LARGE_FOR_ANY);
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

    fn many<'a, Q: Answered<'a>>(&'a self, rays: &[RaySegment], answers: &mut [Q::Answer], large: usize) {
        self.width.run(Many::<Q> { tree: &self.shared.tree, rays, answers, large, query: PhantomData });
    }

    #[inline(always)]
    fn one<'a, Q: Answered<'a>>(&'a self, ray: &'a TraversalRay, interval: Interval) -> Q::Answer {
        self.width.run(One::<Q> { tree: &self.shared.tree, ray, interval, query: PhantomData })
    }
}

impl Shape for WideMesh {
    fn object_bound(&self) -> Bounds3 {
        self.shared.tree.bounds
    }

    fn primitive_count(&self) -> u64 {
        self.shared.mesh.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.width.run(All { tree: &self.shared.tree, ray, interval, visitor })
    }

    #[inline]
    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        self.one::<ClosestQuery>(ray, interval)
    }

    #[inline]
    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.one::<AnyQuery>(ray, interval)
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.shared.mesh.surface_point(ray, hit)
    }
}
