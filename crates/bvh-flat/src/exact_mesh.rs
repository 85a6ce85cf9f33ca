//! A triangle mesh with its tree, decided about exactly.

use std::cell::LazyCell;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use geometry::exact::{Enclosure, ExactRay, TierCounts, TierObserver};
use geometry::glam::Vec3;
use geometry::{
    Bounds3, Hit, HitVisitor, Interval, Kernels, Shape, SurfacePoint, TraversalRay, TriangleHit, TriangleMesh, Visit,
    Watertight, Work, round_up,
};

use crate::{FlatBvh, MeshBvh};

/// A [`MeshBvh`] whose every decision is that of real arithmetic on the given numbers: which triangles a ray hits,
/// which hit is the closest, and of equal t* which triangle is the first. See [`geometry::exact`] for what that means,
/// and [`ExactRay::values`] for `t`, `u` and `v`. The answer is the same, bit for bit, for every tree.
///
/// Between this mesh and other shapes, and by visitors of its hits, the closer is decided by the rounded `t`, as
/// everywhere.
///
/// *No tree loses a hit.* The exact ray is in the triangle at t*, so in the box of every node above it. The padded test
/// gives an entry `fl(x)` with x <= t* and an exit `fl(y)` with y >= t*; as rounding is monotone, entry <= exit, and
/// the entry is at most t* rounded up. The closest hit so far bounds the search by a number that is at least its t*,
/// rounded up; so no node is passed by that has a hit as close. An entry beyond `f32::MAX` is that of no hit.
#[derive(Clone, Debug)]
pub struct ExactMesh {
    bvh: MeshBvh,
    /// The vertices of the triangle at each place of the order.
    ordered_vertices: Vec<[Vec3; 3]>,
}

impl<K: Kernels> MeshBvh<K> {
    /// The same mesh and tree, with exact decisions.
    pub fn exact(&self) -> ExactMesh {
        let vertices = |&i: &u32| self.mesh().vertices(i as usize);
        ExactMesh { bvh: self.with_kernels(), ordered_vertices: self.bvh().order().iter().map(vertices).collect() }
    }
}

/// The closest hit so far.
struct Closest {
    place: usize,
    enclosure: Enclosure,
}

impl ExactMesh {
    /// The mesh.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        self.bvh.mesh()
    }

    /// The tree.
    pub fn bvh(&self) -> &FlatBvh {
        self.bvh.bvh()
    }

    /// What is kept beside the mesh itself, in bytes.
    pub fn memory(&self) -> usize {
        self.bvh().memory() + size_of_val(self.ordered_vertices.as_slice())
    }

    /// The closest hit, as [`intersect`](Shape::intersect), and which tiers decided.
    pub fn intersect_counted(&self, ray: &TraversalRay, interval: Interval) -> (Option<Hit>, TierCounts) {
        let mut counts = TierCounts::default();
        let hit = self.closest(ray, interval, &mut counts);
        (hit, counts)
    }

    /// Whether there is any hit, as [`intersect_p`](Shape::intersect_p), and which tiers decided.
    pub fn intersect_p_counted(&self, ray: &TraversalRay, interval: Interval) -> (bool, TierCounts) {
        let mut counts = TierCounts::default();
        let is_hit = self.any(ray, interval, &mut counts);
        (is_hit, counts)
    }

    /// Prepared at the first leaf: many rays come to none.
    fn exact_ray(&self, ray: &TraversalRay) -> LazyCell<ExactRay, impl FnOnce() -> ExactRay> {
        LazyCell::new(|| ExactRay::new(ray, &self.bvh().bounds()))
    }

    #[inline]
    fn closest(&self, ray: &TraversalRay, interval: Interval, observer: &mut impl TierObserver) -> Option<Hit> {
        let exact = self.exact_ray(ray);
        let mut closest: Option<Closest> = None;
        // What is handed to the tree only bounds its search.
        let leaf = |range: Range<usize>, _: Interval| {
            let is_closer = self.closest_of(range, &exact, interval, &mut closest, observer);
            let bound = |best: &Closest| Hit { t: round_up(best.enclosure.high()), u: 0.0, v: 0.0, primitive: 0 };
            closest.as_ref().filter(|_| is_closer).map(bound)
        };
        let _ = self.bvh().intersect::<Watertight>(ray, interval, leaf);
        let Closest { place, enclosure } = closest?;
        Some(self.hit(place, &exact, &enclosure, observer))
    }

    /// Improves on the closest hit so far; whether it could.
    #[inline]
    fn closest_of(
        &self,
        range: Range<usize>,
        ray: &ExactRay,
        interval: Interval,
        closest: &mut Option<Closest>,
        observer: &mut impl TierObserver,
    ) -> bool {
        let mut is_closer = false;
        for place in range {
            let vertices = &self.ordered_vertices[place];
            let Some(enclosure) = ray.intersect_triangle(vertices, interval, observer) else { continue };
            let is_before = |best: &Closest, observer: &mut _| {
                let best_vertices = &self.ordered_vertices[best.place];
                let order = ray.compare((&enclosure, vertices), (&best.enclosure, best_vertices), observer);
                let order_of_index = || self.bvh().order()[place].cmp(&self.bvh().order()[best.place]);
                order.then_with(order_of_index).is_lt()
            };
            if closest.as_ref().is_none_or(|best| is_before(best, observer)) {
                *closest = Some(Closest { place, enclosure });
                is_closer = true;
            }
        }
        is_closer
    }

    #[inline]
    fn any(&self, ray: &TraversalRay, interval: Interval, observer: &mut impl TierObserver) -> bool {
        let exact = self.exact_ray(ray);
        let leaf = |mut range: Range<usize>, _: Interval| {
            range.any(|place| exact.intersect_triangle(&self.ordered_vertices[place], interval, observer).is_some())
        };
        self.bvh().intersect_p::<Watertight>(ray, interval, leaf)
    }

    fn hit(&self, place: usize, ray: &ExactRay, enclosure: &Enclosure, observer: &mut impl TierObserver) -> Hit {
        let TriangleHit { t, u, v } = ray.values(&self.ordered_vertices[place], enclosure, observer);
        Hit { t, u, v, primitive: u64::from(self.bvh().order()[place]) }
    }
}

impl Shape for ExactMesh {
    fn object_bound(&self) -> Bounds3 {
        self.bvh().bounds()
    }

    fn primitive_count(&self) -> u64 {
        self.bvh.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        let exact = self.exact_ray(ray);
        let mut tested = 0_u64;
        let leaf = |range: Range<usize>, mut interval: Interval, visitor: &mut dyn HitVisitor| {
            for place in range {
                tested += 1;
                if let Some(enclosure) = exact.intersect_triangle(&self.ordered_vertices[place], interval, &mut ()) {
                    let hit = self.hit(place, &exact, &enclosure, &mut ());
                    interval = interval.with_t_max(visitor.hit(hit)?);
                }
            }
            ControlFlow::Continue(interval.t_max())
        };
        let visit = self.bvh().visit_hits::<Watertight>(ray, interval, visitor, leaf);
        visitor.work(Work { nodes: 0, primitives: tested });
        visit
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        self.closest(ray, interval, &mut ())
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.any(ray, interval, &mut ())
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.bvh.surface_point(ray, hit)
    }
}

#[cfg(all(test, feature = "build"))]
mod tests {
    use super::*;
    use crate::{BuildConfig, SplitMethod};
    use geometry::Ray;
    use geometry::exact::intersect_triangle_exact;
    use geometry::glam::DVec3;

    /// A small generator: the crate has no random numbers.
    struct Random(u64);

    impl Random {
        fn signed(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 * 2.0_f64.powi(-52) - 1.0
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.signed(), self.signed(), self.signed())
        }
    }

    /// Rays of f64 and tiny triangles on their way, in places that no f32 ray passes.
    fn case(i: usize, random: &mut Random) -> (Vec<TraversalRay>, TriangleMesh) {
        let size = [1.0, 1e3, 1e6, 1e-9][i % 4];
        let mut rays = Vec::new();
        let mut positions = Vec::new();
        for j in 0..20 {
            let origin = size * random.vector();
            let mut direction = random.vector();
            match j % 5 {
                1 => direction.x = 1e-42 * random.signed(),
                2 => direction *= 4e-45,
                3 => direction = direction.with_y(1e-50).with_z(0.0),
                4 => direction *= [1.6e38, 1e-38][i % 2],
                _ => {}
            }
            rays.extend(TraversalRay::from_f64(origin, direction, 0.0));
            for k in [0, 1, 2, 3, 3, 3, 3, 3, 3, 3] {
                // Near the origin the padding, which grows with the distance, does not cover its rounding.
                let p = origin + 10.0_f64.powi(-2 * k) * size * direction.normalize() * random.signed();
                let extent = 1e-7 * size;
                positions.extend([0; 3].map(|_| (p + extent * random.vector()).as_vec3()));
            }
        }
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        (rays, TriangleMesh::new(positions, triangles).expect("indices are in range"))
    }

    #[test]
    fn rays_that_f32_does_not_hold_lose_nothing() {
        let mut random = Random(1);
        let (mut hits, mut lost_by_the_f32_box) = (0, 0);
        for i in 0..200 {
            let (rays, mesh) = case(i, &mut random);
            let method = SplitMethod::ALL[i / 4 % SplitMethod::ALL.len()];
            let config = BuildConfig::new(method).with_max_primitives_in_leaf(1);
            let exact = MeshBvh::build(mesh, &config).expect("the configuration is valid").exact();
            for ray in &rays {
                assert!(ray.is_rounded());
                let vertices = |i: usize| exact.mesh().vertices(i);
                let all = |i: usize| Some((i, intersect_triangle_exact(ray, &vertices(i), Interval::FULL)?));
                let naive: Vec<(usize, TriangleHit)> = (0..exact.mesh().len()).filter_map(all).collect();
                let mut found = Vec::new();
                let _ = exact.visit_hits(ray, Interval::FULL, &mut |hit: Hit| {
                    found.push(hit.primitive as usize);
                    ControlFlow::Continue(f32::INFINITY)
                });
                found.sort_unstable();
                assert_eq!(found, naive.iter().map(|(i, _)| *i).collect::<Vec<_>>(), "{ray:?}");
                assert_eq!(exact.intersect_p(ray, Interval::FULL), !naive.is_empty());
                let least = naive.iter().map(|(_, h)| h.t).min_by(f32::total_cmp);
                assert_eq!(exact.intersect(ray, Interval::FULL).map(|h| h.t), least, "{ray:?}");
                hits += naive.len();
                let f32_ray = TraversalRay::new(&ray.ray()).expect("what was rounded is valid");
                let is_lost = |i: usize| f32_ray.enter(&Bounds3::from_points(vertices(i)), Interval::FULL).is_none();
                lost_by_the_f32_box += naive.iter().filter(|(i, _)| is_lost(*i)).count();
            }
        }
        assert!(hits > 1_000 && lost_by_the_f32_box > 20, "{hits} {lost_by_the_f32_box}");
    }

    #[test]
    fn tiers_are_counted() {
        let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE], vec![[0, 1, 2], [1, 3, 2]]);
        let bvh = MeshBvh::build(mesh.expect("in range"), &BuildConfig::default()).expect("the default is valid");
        let exact = bvh.exact();
        let down = |x: f32, y: f32| TraversalRay::new(&Ray::new([x, y, 2.0], [0.0, 0.0, -1.0])).expect("valid");
        let (hit, counts) = exact.intersect_counted(&down(0.25, 0.25), Interval::FULL);
        assert_eq!((hit.map(|h| (h.t, h.primitive)), counts.exact), (Some((2.0, 0)), 0));
        assert!(counts.certificate > 0);
        // On the edge of both triangles, whose hits tie.
        let (hit, counts) = exact.intersect_counted(&down(0.5, 0.5), Interval::FULL);
        assert!(hit.is_some_and(|h| h.primitive == 0) && counts.exact > 0);
        assert!(!exact.intersect_p_counted(&down(0.5, 0.5), Interval::up_to(1.0)).0);
        assert_eq!((exact.primitive_count(), exact.object_bound()), (2, bvh.object_bound()));
    }
}
