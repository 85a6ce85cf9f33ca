//! A triangle mesh with a wide tree: exact decisions, eight boxes or triangles at a time.

use std::cmp::Ordering;
use std::ops::ControlFlow;
use std::sync::Arc;

use geometry::exact::{Enclosure, ExactRay};
use geometry::{
    Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, TriangleHit, TriangleMesh, Visit, Work,
    round_up,
};

use crate::simd::{Lanes, SimdWidth};
use crate::wide::{Candidates, Child, Query, Traversal, TriangleBlocks, TriangleLeaf, TriangleRay, WideTree, collapse};
use crate::{FlatBvh, MeshBvh};

/// A triangle mesh with a wide tree over its triangles: nodes of eight children and leaves of up to eight triangles, each
/// tested at once. Its answers are those of [`ExactMesh`](crate::ExactMesh), bit for bit, on every [`SimdWidth`].
///
/// *How.* Eight boxes or triangles are tested in f32 with bounds on every error, so that nothing is lost. What f32 leaves
/// open (a ray at an edge, two hits whose t are too close) is decided by an [`ExactRay`], and the values of the hit that
/// is reported are computed by one. Since every decision is that of real arithmetic, it cannot depend on a tree, a layout
/// or the width of registers.
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

    #[inline]
    fn query<Q: Query>(&self, ray: &TraversalRay, interval: Interval, query: &mut Q) {
        let tree = &self.shared.tree;
        self.width.run(Traversal { arena: &tree.arena, root: tree.root, ray, interval, query });
    }

    fn common<'a>(&'a self, ray: &'a TraversalRay, interval: Interval) -> Common<'a> {
        Common { tree: &self.shared.tree, ray, triangles: TriangleRay::new(ray), interval, exact: None }
    }
}

/// What all queries have.
struct Common<'a> {
    tree: &'a WideTree,
    ray: &'a TraversalRay,
    triangles: TriangleRay,
    interval: Interval,
    /// Prepared when it is needed.
    exact: Option<ExactRay>,
}

impl<'a> Common<'a> {
    #[inline(always)]
    fn candidates<L: Lanes>(&self, leaf: Child, t_max: f32) -> Option<(TriangleLeaf<'a>, Candidates)> {
        let leaf = TriangleLeaf::new(&self.tree.arena, leaf)?;
        Some((leaf, self.triangles.candidates::<L>(leaf.numbers(), leaf.count(), [self.interval.t_min(), t_max])?))
    }

    /// Whether t* is in the interval for certain.
    #[inline(always)]
    fn is_inside(&self, low: f32, high: f32) -> bool {
        self.interval.t_min() < low && high < self.interval.t_max().min(f32::MAX)
    }

    fn exact(&mut self) -> &ExactRay {
        self.exact.get_or_insert_with(|| ExactRay::unfiltered(self.ray))
    }
}

/// A triangle that is hit, and what is known of its t*.
#[derive(Clone, Copy)]
struct Found {
    leaf: Child,
    lane: usize,
    low: f32,
    /// Narrower bounds of t*, once there was a need for them.
    enclosure: Option<Enclosure>,
}

struct ClosestQuery<'a> {
    common: Common<'a>,
    closest: Option<Found>,
    t_max: f32,
}

impl Query for ClosestQuery<'_> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32> {
        let Some((_, Candidates { mut maybe, sure, low, high })) = self.common.candidates::<L>(leaf, self.t_max) else {
            return ControlFlow::Continue(self.t_max);
        };
        while maybe != 0 {
            let lane = maybe.trailing_zeros() as usize & 7;
            maybe &= maybe - 1;
            let (low, high) = (low[lane], high[lane]);
            let is_sure = sure >> lane & 1 == 1;
            if is_sure && low > self.t_max {
                continue;
            }
            let is_first = self.closest.as_ref().is_none_or(|closest| high < closest.low);
            if is_sure && is_first && self.common.is_inside(low, high) {
                self.closest = Some(Found { leaf, lane, low, enclosure: None });
                self.t_max = high;
            } else {
                self.decide(leaf, lane);
            }
        }
        ControlFlow::Continue(self.t_max)
    }
}

impl ClosestQuery<'_> {
    /// Takes a triangle of which f32 says too little.
    #[cold]
    #[inline(never)]
    fn decide(&mut self, leaf: Child, lane: usize) {
        let arena = &self.common.tree.arena;
        let Some(triangle) = TriangleLeaf::new(arena, leaf) else { return };
        let vertices = triangle.vertices(lane);
        let interval = self.common.interval;
        let exact = *self.common.exact();
        let Some(enclosure) = exact.intersect_triangle(&vertices, interval, &mut ()) else { return };
        if let Some(best) = &mut self.closest {
            let Some(best_triangle) = TriangleLeaf::new(arena, best.leaf) else { return };
            let best_vertices = best_triangle.vertices(best.lane);
            let best_enclosure = best.enclosure.get_or_insert_with(|| exact.enclose(&best_vertices));
            let order = exact.compare((&enclosure, &vertices), (best_enclosure, &best_vertices), &mut ());
            let is_before = match order {
                Ordering::Less => true,
                Ordering::Equal => triangle.primitive(lane) < best_triangle.primitive(best.lane),
                Ordering::Greater => false,
            };
            if !is_before {
                return;
            }
        }
        let (low, high) = (geometry::round_down(enclosure.low()), round_up(enclosure.high()));
        self.closest = Some(Found { leaf, lane, low, enclosure: Some(enclosure) });
        self.t_max = high;
    }

    fn hit(mut self) -> Option<Hit> {
        let found = self.closest?;
        let triangle = TriangleLeaf::new(&self.common.tree.arena, found.leaf)?;
        let vertices = triangle.vertices(found.lane);
        let exact = self.common.exact();
        let TriangleHit { t, u, v } = exact.values_of_hit(&vertices);
        Some(Hit { t, u, v, primitive: u64::from(triangle.primitive(found.lane)) })
    }
}

struct AnyQuery<'a> {
    common: Common<'a>,
    is_hit: bool,
}

impl Query for AnyQuery<'_> {
    const ORDERED: bool = false;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32> {
        let Some((_, Candidates { mut maybe, sure, low, high })) = self.common.candidates::<L>(leaf, self.common.interval.t_max()) else {
            return ControlFlow::Continue(f32::INFINITY);
        };
        while maybe != 0 {
            let lane = maybe.trailing_zeros() as usize & 7;
            maybe &= maybe - 1;
            let (low, high) = (low[lane], high[lane]);
            let is_sure = sure >> lane & 1 == 1;
            if is_sure && self.common.is_inside(low, high) || self.decide(leaf, lane) {
                self.is_hit = true;
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(f32::INFINITY)
    }
}

impl AnyQuery<'_> {
    #[cold]
    #[inline(never)]
    fn decide(&mut self, leaf: Child, lane: usize) -> bool {
        let Some(triangle) = TriangleLeaf::new(&self.common.tree.arena, leaf) else { return false };
        let vertices = triangle.vertices(lane);
        let interval = self.common.interval;
        self.common.exact().intersect_triangle(&vertices, interval, &mut ()).is_some()
    }
}

struct AllQuery<'a, 'v> {
    common: Common<'a>,
    visitor: &'v mut dyn HitVisitor,
    work: Work,
    visit: Visit,
}

impl Query for AllQuery<'_, '_> {
    const ORDERED: bool = true;

    #[inline(always)]
    fn leaf<L: Lanes>(&mut self, leaf: Child) -> ControlFlow<(), f32> {
        self.work.primitives += leaf.count() as u64;
        if let Some((_, Candidates { maybe, .. })) = self.common.candidates::<L>(leaf, self.common.interval.t_max()) {
            self.tell(leaf, maybe);
        }
        self.visit
    }

    #[inline(always)]
    fn node(&mut self) {
        self.work.nodes += 1;
    }
}

impl AllQuery<'_, '_> {
    fn tell(&mut self, leaf: Child, mut maybe: u32) {
        let Some(triangle) = TriangleLeaf::new(&self.common.tree.arena, leaf) else { return };
        while maybe != 0 {
            let lane = maybe.trailing_zeros() as usize & 7;
            maybe &= maybe - 1;
            let ControlFlow::Continue(t_max) = self.visit else { return };
            let vertices = triangle.vertices(lane);
            let interval = self.common.interval.with_t_max(t_max);
            let exact = self.common.exact();
            let Some(enclosure) = exact.intersect_triangle(&vertices, interval, &mut ()) else { continue };
            let TriangleHit { t, u, v } = exact.values(&vertices, &enclosure, &mut ());
            self.visit = self.visitor.hit(Hit { t, u, v, primitive: u64::from(triangle.primitive(lane)) });
        }
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
        let visit = ControlFlow::Continue(interval.t_max());
        let mut query = AllQuery { common: self.common(ray, interval), visitor, work: Work::default(), visit };
        self.query(ray, interval, &mut query);
        let AllQuery { visitor, work, visit, .. } = query;
        visitor.work(work);
        visit
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let mut query = ClosestQuery { common: self.common(ray, interval), closest: None, t_max: interval.t_max() };
        self.query(ray, interval, &mut query);
        query.hit()
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        let mut query = AnyQuery { common: self.common(ray, interval), is_hit: false };
        self.query(ray, interval, &mut query);
        query.is_hit
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.shared.mesh.surface_point(ray, hit)
    }
}
