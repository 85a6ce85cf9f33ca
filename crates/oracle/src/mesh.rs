//! The exact answers about a triangle mesh.

use geometry::glam::{DVec3, Vec3};
use geometry::{Interval, MAX_COORDINATE, Ray, TriangleMesh};

use crate::bvh::{Box64, Bvh};
use crate::filter::{FloatTriangle, Verdict};
use crate::oracle::{Closest, ExactHit, Oracle, Tally, sort};
use crate::real::ExactReal;
use crate::segment::Segment;
use crate::triangle::{self, Crossing, EdgeRule};
use crate::vector::{ExactTransform, Vector, vector};

/// Who knows the exact answer to every query about a mesh, at its own place or at that of an instance.
///
/// Every decision about a ray and a triangle is taken in f64 where an error bound certifies it, and in exact integers
/// elsewhere. A box tree of its own, outward in every rounding, keeps triangles away that cannot be hit.
#[derive(Clone, Debug)]
pub struct MeshOracle {
    mesh: TriangleMesh,
    /// From the mesh's space to that of the rays; `None` for the identity.
    object_to_world: Option<ExactTransform>,
    /// The vertices in the space of the rays: exact for the identity, else rounded.
    vertices: Vec<DVec3>,
    bvh: Bvh,
}

/// A hit with a range that contains its t, and with t itself where that was needed to be sure of the hit.
#[derive(Clone, Debug)]
struct Candidate {
    triangle: u32,
    range: [f64; 2],
    t: Option<ExactReal>,
}

impl MeshOracle {
    /// The oracle of a mesh at its own place.
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self::at(mesh, None)
    }

    /// The oracle of an instance of the mesh. Its vertices are transformed forward, exactly: no inverse is involved.
    /// Whether a triangle is active is decided in the mesh's space.
    pub fn instance(mesh: &TriangleMesh, object_to_world: ExactTransform) -> Self {
        Self::at(mesh, Some(object_to_world))
    }

    fn at(mesh: &TriangleMesh, object_to_world: Option<ExactTransform>) -> Self {
        let place = |p: &Vec3| match &object_to_world {
            Some(map) if p.is_finite() => map.point(&vector(p.as_dvec3())).each_ref().map(|x| x.to_f64()).into(),
            _ => p.as_dvec3(),
        };
        let vertices: Vec<DVec3> = mesh.positions().iter().map(place).collect();
        let is_active = |i: &u32| {
            let is_in_domain = |v: Vec3| v.abs().cmple(Vec3::splat(MAX_COORDINATE)).all();
            mesh.vertices(*i as usize).into_iter().all(is_in_domain)
        };
        let bounds = |i: u32| {
            let around = Box64::around(&mesh.triangles()[i as usize].map(|v| vertices[v as usize]));
            if object_to_world.is_some() { around.grown() } else { around }
        };
        let bvh = Bvh::new((0..mesh.len() as u32).filter(is_active).collect(), &bounds);
        Self { mesh: mesh.clone(), object_to_world, vertices, bvh }
    }

    /// The mesh.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The triangle in f64.
    pub(crate) fn float_triangle(&self, i: u32) -> FloatTriangle {
        let vertices = self.mesh.triangles()[i as usize].map(|v| self.vertices[v as usize]);
        FloatTriangle { vertices, is_rounded: self.object_to_world.is_some() }
    }

    /// The triangle in the space of the rays, exactly.
    pub(crate) fn exact_triangle(&self, i: u32) -> [Vector; 3] {
        self.mesh.vertices(i as usize).map(|p| {
            let p = vector(p.as_dvec3());
            match &self.object_to_world {
                Some(map) => map.point(&p),
                None => p,
            }
        })
    }

    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Where the ray meets the triangle, in exact integers.
    pub(crate) fn crossing(&self, i: u32, ray: &Segment, rule: EdgeRule) -> Option<Crossing> {
        triangle::intersect(ray, &self.exact_triangle(i), rule)
    }

    /// Whether the ray hits the closed triangle, by the cheapest tier that can tell.
    fn candidate(&self, triangle: u32, ray: &Segment, tally: &mut Tally) -> Option<Candidate> {
        match self.float_triangle(triangle).intersect(ray) {
            Verdict::Miss => {
                tally.filtered += 1;
                None
            }
            Verdict::Hit(range) => {
                tally.filtered += 1;
                Some(Candidate { triangle, range, t: None })
            }
            Verdict::Unsure => {
                tally.exact += 1;
                let t = self.crossing(triangle, ray, EdgeRule::Closed)?.t;
                Some(Candidate { triangle, range: t.range(), t: Some(t) })
            }
        }
    }

    /// The hit with its exact t: `Some` for every candidate, since the certificate holds.
    fn exact_hit(&self, candidate: Candidate, ray: &Segment) -> Option<ExactHit> {
        let t = match candidate.t {
            Some(t) => t,
            None => self.crossing(candidate.triangle, ray, EdgeRule::Closed)?.t,
        };
        Some(ExactHit { t, primitive: candidate.triangle.into() })
    }
}

impl Oracle for MeshOracle {
    fn primitive_count(&self) -> u64 {
        self.mesh.len() as u64
    }

    fn all_hits(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Vec<ExactHit> {
        let Some(ray) = Segment::new(ray, interval) else { return Vec::new() };
        let mut hits = Vec::new();
        self.bvh.visit(&ray, &mut |i| {
            hits.extend(self.candidate(i, &ray, tally).and_then(|candidate| self.exact_hit(candidate, &ray)));
            Some(ray.t_max)
        });
        sort(&mut hits);
        hits
    }

    fn closest(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Option<Closest> {
        let ray = Segment::new(ray, interval)?;
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut least_high = ray.t_max;
        self.bvh.visit(&ray, &mut |i| {
            if let Some(candidate) = self.candidate(i, &ray, tally).filter(|c| c.range[0] <= least_high) {
                least_high = least_high.min(candidate.range[1]);
                candidates.push(candidate);
            }
            Some(least_high)
        });
        // Those that are certainly not the closest are out; among the rest, t decides exactly.
        candidates.retain(|candidate| candidate.range[0] <= least_high);
        let hits = candidates.into_iter().filter_map(|candidate| self.exact_hit(candidate, &ray));
        let single = |hit: ExactHit| Closest { t: hit.t, primitives: vec![hit.primitive] };
        hits.map(single).reduce(Closest::merge)
    }

    fn any(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> bool {
        let Some(ray) = Segment::new(ray, interval) else { return false };
        let mut any = false;
        self.bvh.visit(&ray, &mut |i| {
            any = self.candidate(i, &ray, tally).is_some();
            (!any).then_some(ray.t_max)
        });
        any
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, aimed, star};
    use geometry::glam::{DAffine3, DMat3};

    /// Every triangle, exactly: no tree, no filter.
    fn naive(oracle: &MeshOracle, ray: &Ray, interval: Interval) -> Vec<ExactHit> {
        let Some(segment) = Segment::new(ray, interval) else { return Vec::new() };
        let hit = |i: u32| {
            let t = oracle.crossing(i, &segment, EdgeRule::Closed)?.t;
            Some(ExactHit { t, primitive: i.into() })
        };
        let mut hits: Vec<ExactHit> = (0..oracle.mesh.len() as u32).filter_map(hit).collect();
        sort(&mut hits);
        hits
    }

    fn check(oracle: &MeshOracle, ray: &Ray, interval: Interval, tally: &mut Tally) -> usize {
        let hits = naive(oracle, ray, interval);
        assert_eq!(oracle.all_hits(ray, interval, tally), hits, "{ray:?}");
        assert_eq!(oracle.any(ray, interval, tally), !hits.is_empty(), "{ray:?}");
        let closest = oracle.closest(ray, interval, tally);
        let least = hits.first().map(|first| first.t.clone());
        assert_eq!(closest.as_ref().map(|c| c.t.clone()), least, "{ray:?}");
        let primitives = hits.iter().filter(|hit| Some(&hit.t) == least.as_ref()).map(|hit| hit.primitive);
        assert_eq!(closest.map_or(Vec::new(), |c| c.primitives), primitives.collect::<Vec<_>>(), "{ray:?}");
        hits.len()
    }

    #[test]
    fn tree_and_filter_change_nothing() {
        let mut random = Random::new(3);
        for (n, is_lattice) in [(3, true), (9, true), (9, false), (12, false)] {
            let mesh = star(&mut random, n, 2.0, is_lattice);
            let oracle = MeshOracle::new(&mesh);
            let (mut tally, mut hits) = (Tally::default(), 0);
            for i in 0..100 {
                let origin = random.vec3(|r| if i % 2 == 0 { r.lattice() } else { 9.0 * r.signed() });
                let interval = [Interval::FULL, Interval::new(0.5, 1.0), Interval::new(1.0, 1.5)][i % 3];
                let mut ray = aimed(&mut random, &mesh, origin);
                if i % 7 == 0 {
                    ray.direction = Vec3::AXES[i % 3] * if i % 2 == 0 { -0.25 } else { 3.0 };
                }
                hits += check(&oracle, &ray, interval, &mut tally);
            }
            assert!(hits > 50 && tally.exact > if is_lattice { 100 } else { 0 }, "{hits} {tally:?}");
        }
    }

    #[test]
    fn instances_are_transformed_exactly() {
        let mut random = Random::new(5);
        let mesh = star(&mut random, 6, 1.0, true);
        for scale in [1.0, 1e-6, 1e18, 1e-70, 1e70] {
            let m = DMat3::from_cols(DVec3::new(0.3, 0.1, -2.0), DVec3::new(0.7, -1.1, 0.2), DVec3::new(0.1, 0.9, 0.4));
            let map = DAffine3::from_mat3_translation(m * scale, DVec3::new(0.1, 0.2, 0.3));
            let oracle = MeshOracle::instance(&mesh, ExactTransform::new(&map).expect("finite"));
            for i in 0..mesh.len() as u32 {
                let bounds = Box64::around(&oracle.float_triangle(i).vertices).grown();
                let (min, max) = (vector(bounds.min), vector(bounds.max));
                assert!(oracle.exact_triangle(i).iter().all(|p| (0..3).all(|i| min[i] < p[i] && p[i] < max[i])));
            }
            let mut tally = Tally::default();
            let mut hits = 0;
            for _ in 0..40 {
                let p = oracle.vertices[random.below(oracle.vertices.len() as u32) as usize];
                let origin = random.vec3(|r| scale.min(1e18) * 5.0 * r.signed());
                let ray = Ray::new(origin, p.as_vec3() - origin);
                hits += check(&oracle, &ray, Interval::FULL, &mut tally);
            }
            assert!(hits > 0 || !(1e-6..=1e18).contains(&scale), "{scale}");
        }
    }

    /// A power-of-two scale moves no bit: the instance is the mesh, with t scaled.
    #[test]
    fn scaling_by_powers_of_two_changes_nothing() {
        let mut random = Random::new(7);
        let mesh = star(&mut random, 8, 3.0, false);
        let plain = MeshOracle::new(&mesh);
        let map = ExactTransform::new(&DAffine3::from_scale(DVec3::splat(4.0))).expect("finite");
        let scaled = MeshOracle::instance(&mesh, map.then_inside(&map));
        for _ in 0..200 {
            let origin = random.vec3(|r| 5.0 * r.signed());
            let ray = aimed(&mut random, &mesh, origin);
            let a = plain.closest(&ray, Interval::FULL, &mut Tally::default());
            let far = Ray::new(16.0 * ray.origin, ray.direction);
            let b = scaled.closest(&far, Interval::FULL, &mut Tally::default());
            assert_eq!(a.map(|c| (c.primitives, c.t.along(0.0, 16.0))), b.map(|c| (c.primitives, c.t)));
        }
    }

    #[test]
    fn what_is_inactive_or_invalid_is_never_hit() {
        let good = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let down = Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, MAX_COORDINATE.next_up(), f32::MAX] {
            let positions = [good.to_vec(), vec![Vec3::new(bad, 0.0, 0.0), Vec3::new(0.0, bad, 0.0)]].concat();
            let mesh = TriangleMesh::new(positions, vec![[0, 3, 2], [0, 1, 4], [0, 1, 2]]).expect("in range");
            for oracle in [
                MeshOracle::new(&mesh),
                MeshOracle::instance(&mesh, ExactTransform::new(&DAffine3::IDENTITY).expect("finite")),
            ] {
                let found = oracle.closest(&down, Interval::FULL, &mut Tally::default()).expect("the third");
                assert_eq!((found.primitives, found.t.to_f32()), (vec![2], 1.0));
                for i in 0..7 {
                    let mut c = [0.25, 0.25, 1.0, 0.0, 0.0, -1.0, 0.0];
                    c[i] = if bad == f32::MAX { f32::NAN } else { bad };
                    let ray = Ray::new([c[0], c[1], c[2]], [c[3], c[4], c[5]]).at_time(c[6]);
                    assert!(c[i].is_finite() || !oracle.any(&ray, Interval::FULL, &mut Tally::default()));
                }
            }
        }
        let mesh = TriangleMesh::new(good.to_vec(), vec![[0, 1, 2]]).expect("in range");
        let zero = Ray::new([0.0; 3], [0.0, -0.0, 0.0]);
        assert!(!MeshOracle::new(&mesh).any(&zero, Interval::FULL, &mut Tally::default()));
        assert!(!MeshOracle::new(&mesh).any(&down, Interval::EMPTY, &mut Tally::default()));
        let flat = ExactTransform::new(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).expect("finite");
        assert!(!MeshOracle::instance(&mesh, flat).any(&down, Interval::FULL, &mut Tally::default()));
        let empty = MeshOracle::new(&TriangleMesh::new([Vec3::ZERO; 0], Vec::new()).expect("in range"));
        assert!(empty.closest(&down, Interval::FULL, &mut Tally::default()).is_none());
    }
}
