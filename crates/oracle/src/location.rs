//! On which side of a surface a point lies.

use std::cmp::Ordering;

use geometry::glam::Vec3;
use geometry::{Interval, Ray};

use crate::filter::Verdict;
use crate::mesh::MeshOracle;
use crate::oracle::{ExactHit, Tally};
use crate::segment::Segment;
use crate::triangle::{self, EdgeRule};
use crate::vector::vector;

/// Where a point lies, relative to a closed surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PointLocation {
    /// Within.
    Inside,
    /// On a triangle.
    OnSurface,
    /// Elsewhere.
    Outside,
}

/// A place where a ray goes through a surface, counted once however many triangles share it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurfaceCrossing {
    /// Where, and by which of the triangles.
    pub hit: ExactHit,
    /// Whether the ray runs along the triangle's normal: out of the surface where triangles are wound
    /// counter-clockwise as seen from outside.
    pub is_outward: bool,
}

impl MeshOracle {
    /// On which side of the plane through a triangle `p` lies, exactly: `Greater` where its normal points to (the side
    /// from which its vertices run counter-clockwise), `Equal` in the plane, and for every `p` where the triangle has
    /// no area. `None` where there is no such triangle or a coordinate is not finite.
    pub fn side_of_plane(&self, triangle: u32, p: Vec3, tally: &mut Tally) -> Option<Ordering> {
        let vertices = self.mesh().triangles().get(triangle as usize)?.map(|v| self.mesh().positions()[v as usize]);
        if !p.is_finite() || !vertices.iter().all(|v| v.is_finite()) {
            return None;
        }
        if let Some(side) = self.float_triangle(triangle).side_of_plane(p.as_dvec3()) {
            tally.filtered += 1;
            return Some(side);
        }
        tally.exact += 1;
        Some(triangle::side_of_plane(&self.exact_triangle(triangle), &vector(p.as_dvec3())))
    }

    /// Every crossing of the surface with `t_min < t < t_max`, in the order of (t, primitive), for parity and winding
    /// numbers: where the ray meets an edge or vertex, the triangles are those that the infinitesimally shifted ray
    /// crosses. So a ray crosses a closed mesh through a shared edge or vertex as often as a ray beside it, while a ray
    /// that only touches an edge may cross twice at one t, or not at all.
    pub fn crossings(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Vec<SurfaceCrossing> {
        let Some(ray) = Segment::new(ray, interval) else { return Vec::new() };
        let mut crossings = Vec::new();
        self.bvh().visit(&ray, &mut |i| {
            let verdict = self.float_triangle(i).intersect(&ray);
            match verdict {
                Verdict::Unsure => tally.exact += 1,
                _ => tally.filtered += 1,
            }
            if verdict != Verdict::Miss
                && let Some(crossing) = self.crossing(i, &ray, EdgeRule::Shifted)
            {
                let hit = ExactHit { t: crossing.t, primitive: i.into() };
                crossings.push(SurfaceCrossing { hit, is_outward: crossing.is_along_normal });
            }
            Some(ray.t_max)
        });
        crossings.sort_unstable_by(|a, b| a.hit.t.cmp(&b.hit.t).then(a.hit.primitive.cmp(&b.hit.primitive)));
        crossings
    }

    /// Whether `p` lies within the mesh, by the parity of the crossings of a ray from it: for a closed mesh the same
    /// for every ray. A point that is not finite is outside.
    pub fn locate(&self, p: Vec3, tally: &mut Tally) -> PointLocation {
        // Any direction does; this one is seldom parallel to anything.
        self.locate_along(p, Vec3::new(0.754_877_7, 0.569_840_3, 0.324_717_9), tally)
    }

    pub(crate) fn locate_along(&self, p: Vec3, direction: Vec3, tally: &mut Tally) -> PointLocation {
        let on_triangle = |i: u32, tally: &mut Tally| {
            self.side_of_plane(i, p, tally) == Some(Ordering::Equal)
                && triangle::contains_point(&self.exact_triangle(i), &vector(p.as_dvec3()))
        };
        if self.bvh().items_around(p.as_dvec3()).into_iter().any(|i| on_triangle(i, tally)) {
            return PointLocation::OnSurface;
        }
        let count = self.crossings(&Ray::new(p, direction), Interval::FULL, tally).len();
        if count % 2 == 1 { PointLocation::Inside } else { PointLocation::Outside }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, star};
    use geometry::TriangleMesh;

    /// The cube [0, 2]³, with corners numbered by their bits.
    fn cube() -> MeshOracle {
        let positions: Vec<Vec3> =
            (0..8).map(|i| 2.0 * Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        MeshOracle::new(&TriangleMesh::new(positions, triangles).expect("in range"))
    }

    /// Every lattice point around a cube, by rays along axes, edges, face diagonals and space diagonals.
    #[test]
    fn points_of_a_lattice() {
        let cube = cube();
        for i in 0..7 * 7 * 7 {
            let p = 0.5 * Vec3::new((i % 7) as f32, (i / 7 % 7) as f32, (i / 49) as f32) - 0.5;
            let inside = p.cmpgt(Vec3::ZERO).all() && p.cmplt(Vec3::splat(2.0)).all();
            let around = p.cmpge(Vec3::ZERO).all() && p.cmple(Vec3::splat(2.0)).all();
            let expected = match (inside, around) {
                (true, _) => PointLocation::Inside,
                (_, true) => PointLocation::OnSurface,
                _ => PointLocation::Outside,
            };
            assert_eq!(cube.locate(p, &mut Tally::default()), expected);
            for d in 0..27 {
                let d = Vec3::new((d % 3) as f32, (d / 3 % 3) as f32, (d / 9) as f32) - 1.0;
                if d == Vec3::ZERO {
                    continue;
                }
                assert_eq!(cube.locate_along(p, d, &mut Tally::default()), expected, "{p} {d}");
                let crossings = cube.crossings(&Ray::new(p, d), Interval::FULL, &mut Tally::default());
                let winding: i32 = crossings.iter().map(|c| if c.is_outward { 1 } else { -1 }).sum();
                if expected != PointLocation::OnSurface {
                    assert_eq!(winding, i32::from(inside), "{p} {d}");
                }
            }
        }
        assert_eq!(cube.locate(Vec3::NAN, &mut Tally::default()), PointLocation::Outside);
    }

    /// In a star-shaped mesh, the inside is what can be reached from the middle without a crossing; all directions,
    /// also those through vertices, agree.
    #[test]
    fn points_of_a_star() {
        let mut random = Random::new(23);
        for is_lattice in [true, false] {
            let mesh = star(&mut random, 9, 2.0, is_lattice);
            let oracle = MeshOracle::new(&mesh);
            let mut tally = Tally::default();
            let mut seen = [0, 0];
            for i in 0..150 {
                let p = random.vec3(|r| if i % 2 == 0 { 0.5 * r.lattice() } else { 3.0 * r.signed() });
                let location = oracle.locate(p, &mut tally);
                let vertex = mesh.positions()[random.below(mesh.positions().len() as u32) as usize];
                for d in [Vec3::X, Vec3::NEG_Y, Vec3::Z, vertex - p, p - vertex, -p] {
                    if d != Vec3::ZERO {
                        assert_eq!(oracle.locate_along(p, d, &mut tally), location, "{p} {d}");
                    }
                }
                if location != PointLocation::OnSurface {
                    seen[usize::from(location == PointLocation::Inside)] += 1;
                }
            }
            assert!(seen[0] > 20 && seen[1] > 20, "{seen:?}");
            for &p in mesh.positions() {
                assert_eq!(oracle.locate(p, &mut tally), PointLocation::OnSurface);
            }
        }
    }

    #[test]
    fn sides_of_a_plane_to_the_last_bit() {
        let cube = cube();
        let mut tally = Tally::default();
        let mut side = |x: f32| cube.side_of_plane(2, Vec3::new(x, 0.3, 77.7), &mut tally);
        assert_eq!(side(2.0), Some(Ordering::Equal));
        assert_eq!(side(2.0_f32.next_up()), Some(Ordering::Greater));
        assert_eq!(side(2.0_f32.next_down()), Some(Ordering::Less));
        assert_eq!(side(f32::NAN), None);
        assert_eq!(tally, Tally { filtered: 2, exact: 1 });
        assert_eq!(cube.side_of_plane(12, Vec3::ZERO, &mut tally), None);
    }
}
