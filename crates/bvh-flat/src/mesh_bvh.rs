//! A triangle mesh with its tree.

use std::marker::PhantomData;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use geometry::glam::Vec3;
use geometry::{
    Bounds3, Hit, HitVisitor, Interval, Kernels, Shape, SurfacePoint, TraversalRay, TriangleMesh, Visit, Watertight,
    Work,
};

#[cfg(feature = "build")]
use bvh_build::Phase;

#[cfg(feature = "build")]
use crate::flatten::observed_collect;
#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError, BuildObserver};
use crate::{FlatBvh, InvalidBvh};

/// A triangle mesh with a tree over its triangles: a [`Shape`] whose primitives are the mesh's triangles, under their
/// own numbers. Every answer is the same, bit for bit, as that of the mesh alone, whatever the tree.
///
/// That holds for the default kernels. Others are for showing what they lose: [`with_kernels`](Self::with_kernels).
/// A clone shares mesh and tree.
#[derive(Clone, Debug)]
pub struct MeshBvh<K = Watertight> {
    tree: Arc<MeshTree>,
    kernels: PhantomData<K>,
}

#[derive(Debug)]
struct MeshTree {
    mesh: Arc<TriangleMesh>,
    bvh: FlatBvh,
    /// The vertices of the triangle at each place of the order, so that a leaf reads memory in one piece.
    ordered_vertices: Vec<[Vec3; 3]>,
}

impl MeshBvh {
    /// Builds a tree over `mesh`. Triangles with a coordinate that is NaN, infinite or beyond 2⁶⁰ are inactive: they
    /// keep their number and are never hit. Space is not split, whatever the configuration says.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration or a number of triangles that the builder refuses.
    #[cfg(feature = "build")]
    pub fn build(mesh: impl Into<Arc<TriangleMesh>>, config: &BuildConfig) -> Result<Self, BuildError> {
        Self::build_observed(mesh, config, &())
    }

    /// Builds a tree over `mesh`; `observer` is told how far it has come, and may cancel it.
    ///
    /// # Errors
    /// As [`build`](Self::build); and [`BuildError::Cancelled`].
    #[cfg(feature = "build")]
    pub fn build_observed(
        mesh: impl Into<Arc<TriangleMesh>>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        let mesh = mesh.into();
        let bounds = observed_collect(observer, Phase::Bounds, mesh.len(), |i| mesh.watertight_bounds(i))?;
        let bvh = FlatBvh::build(&bounds, config, observer)?;
        let order = bvh.order();
        let ordered_vertices =
            observed_collect(observer, Phase::Emission, order.len(), |place| mesh.vertices(order[place] as usize))?;
        Ok(Self::of(MeshTree { mesh, bvh, ordered_vertices }))
    }

    /// Joins a mesh and a tree over its triangles' [bounds](TriangleMesh::watertight_bounds).
    ///
    /// # Errors
    /// [`InvalidBvh::Geometry`] where the tree does not fit the mesh: not built over as many primitives, a leaf that
    /// does not contain its triangles, an active triangle that no leaf has, or space that was split.
    pub fn from_parts(mesh: impl Into<Arc<TriangleMesh>>, bvh: FlatBvh) -> Result<Self, InvalidBvh> {
        let mesh = mesh.into();
        bvh.validate_against(mesh.len(), |i| mesh.watertight_bounds(i))?;
        let ordered_vertices = bvh.order().iter().map(|&i| mesh.vertices(i as usize)).collect();
        Ok(Self::of(MeshTree { mesh, bvh, ordered_vertices }))
    }

    fn of(tree: MeshTree) -> Self {
        Self { tree: Arc::new(tree), kernels: PhantomData }
    }
}

impl<K: Kernels> MeshBvh<K> {
    /// The same mesh and tree, traversed with other kernels.
    pub fn with_kernels<L: Kernels>(&self) -> MeshBvh<L> {
        MeshBvh { tree: Arc::clone(&self.tree), kernels: PhantomData }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.tree.mesh
    }

    /// The tree.
    pub fn bvh(&self) -> &FlatBvh {
        &self.tree.bvh
    }

    /// What is kept beside the mesh itself, in bytes: nodes, order, and the vertices once more, leaf by leaf.
    pub fn memory(&self) -> usize {
        self.tree.bvh.memory() + size_of_val(self.tree.ordered_vertices.as_slice())
    }

    #[inline]
    fn intersect_place(&self, place: usize, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let h = K::intersect_triangle(ray, &self.tree.ordered_vertices[place], interval)?;
        Some(Hit { t: h.t, u: h.u, v: h.v, primitive: u64::from(self.tree.bvh.order()[place]) })
    }

    #[inline]
    fn intersect_range(&self, range: Range<usize>, ray: &TraversalRay, mut interval: Interval) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        for place in range {
            if let Some(hit) = self.intersect_place(place, ray, interval)
                && closest.as_ref().is_none_or(|best| hit.is_before(best))
            {
                interval = interval.with_t_max(hit.t_max_for_ties());
                closest = Some(hit);
            }
        }
        closest
    }
}

impl<K: Kernels> Shape for MeshBvh<K> {
    fn object_bound(&self) -> Bounds3 {
        self.tree.bvh.bounds()
    }

    fn primitive_count(&self) -> u64 {
        self.tree.mesh.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        let mut tested = 0_u64;
        let visit = self.tree.bvh.visit_hits::<K>(ray, interval, visitor, |range, mut interval, visitor| {
            for place in range {
                tested += 1;
                if let Some(hit) = self.intersect_place(place, ray, interval) {
                    interval = interval.with_t_max(visitor.hit(hit)?);
                }
            }
            ControlFlow::Continue(interval.t_max())
        });
        visitor.work(Work { nodes: 0, primitives: tested });
        visit
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        self.tree.bvh.intersect::<K>(ray, interval, |range, interval| self.intersect_range(range, ray, interval))
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.tree.bvh.intersect_p::<K>(ray, interval, |mut range, interval| {
            range.any(|place| self.intersect_place(place, ray, interval).is_some())
        })
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.tree.mesh.surface_point(ray, hit)
    }
}
