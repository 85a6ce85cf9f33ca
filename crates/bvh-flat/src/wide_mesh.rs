//! A triangle mesh with a wide tree: exact decisions, eight boxes or triangles at a time.

use std::sync::Arc;

use geometry::{Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, TriangleMesh, Visit};

use crate::simd::SimdWidth;
use crate::wide::{All, Any, Asked, Closest, TriangleBlocks, Values, WideTree, collapse};
use crate::{FlatBvh, MeshBvh};

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

    #[inline(always)]
    fn asked<'a>(&'a self, ray: &'a TraversalRay, interval: Interval) -> Asked<'a> {
        Asked { tree: &self.shared.tree, ray, interval }
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
        self.width.run(All { asked: self.asked(ray, interval), visitor })
    }

    #[inline]
    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let asked = self.asked(ray, interval);
        let found = self.width.run(Closest(asked))?;
        self.width.for_scalars().run(Values(asked, found))
    }

    #[inline]
    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.width.run(Any(self.asked(ray, interval)))
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.shared.mesh.surface_point(ray, hit)
    }
}
