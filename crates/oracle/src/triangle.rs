//! The exact tests of a ray, a point and a triangle.

use std::cmp::Ordering;

use crate::dyadic::Dyadic;
use crate::real::ExactReal;
use crate::segment::Segment;
use crate::vector::{Vector, cross, difference, dot, sum};

/// What an edge function of zero means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EdgeRule {
    /// Triangles are closed: a ray through a shared edge hits both neighbours.
    Closed,
    /// The ray is shifted by an infinitesimal amount, the same for all triangles: a ray through a shared edge or vertex
    /// crosses a surface once (Edelsbrunner and Mücke 1990, *Simulation of Simplicity*, ACM TOG 9(1)).
    Shifted,
}

/// Where the line of a ray meets a triangle.
pub(crate) struct Crossing {
    pub(crate) t: ExactReal,
    /// Whether the ray runs along the triangle's normal (vertices counter-clockwise as seen from where it goes to).
    pub(crate) is_along_normal: bool,
}

/// Where the ray meets the triangle within its interval, in real arithmetic.
///
/// With pᵢ = vᵢ − o the edge functions are e₀ = det[p₁, p₂, d] and so on cyclically; their sum is D = n·d for the
/// normal n = (v₁ − v₀) × (v₂ − v₀), and t = N / D with N = n·p₀. The triangle is met where the edge functions are of
/// one sign and D is not zero.
pub(crate) fn intersect(ray: &Segment, vertices: &[Vector; 3], rule: EdgeRule) -> Option<Crossing> {
    let (o, d) = (ray.exact_origin(), ray.exact_direction());
    let p = [0, 1, 2].map(|i| difference(&vertices[i], &o));
    let crosses = [cross(&p[1], &p[2]), cross(&p[2], &p[0]), cross(&p[0], &p[1])];
    let e = [0, 1, 2].map(|i| dot(&crosses[i], &d));
    let det = &(&e[0] + &e[1]) + &e[2];
    if det.is_zero() {
        return None;
    }
    let sign = det.signum();
    for i in 0..3 {
        let edge_sign = match (e[i].signum(), rule) {
            (0, EdgeRule::Closed) => sign,
            (0, EdgeRule::Shifted) => shifted_edge_sign(&d, &vertices[(i + 1) % 3], &vertices[(i + 2) % 3]),
            (edge_sign, _) => edge_sign,
        };
        if edge_sign != sign {
            return None;
        }
    }
    let normal = sum(&sum(&crosses[0], &crosses[1]), &crosses[2]);
    let t = ExactReal::ratio(dot(&normal, &p[0]), det);
    ray.contains(&t).then_some(Crossing { t, is_along_normal: sign > 0 })
}

/// The sign of the edge function det[v − o, w − o, d], which is zero, after o has moved by ε a + ε² b, where a and b
/// are the unit vectors of the axes after that of the first component of d that is not zero.
///
/// det[v − o − s, w − o − s, d] = det[v − o, w − o, d] + s·((v − w) × d). Zero for both a and b only where the edge is
/// parallel to d; then D is zero too.
fn shifted_edge_sign(d: &Vector, v: &Vector, w: &Vector) -> i32 {
    let edge = difference(v, w);
    let k = usize::from(d[0].is_zero()) + usize::from(d[0].is_zero() && d[1].is_zero());
    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
    let along = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (&(&edge[j] * &d[k]) - &(&edge[k] * &d[j])).signum()
    };
    match along(a) {
        0 => along(b),
        sign => sign,
    }
}

/// On which side of the plane through the triangle the point lies: `Greater` where its normal points to. `Equal` for
/// every point where the triangle has no area.
pub(crate) fn side_of_plane(vertices: &[Vector; 3], p: &Vector) -> Ordering {
    dot(&normal(vertices), &difference(p, &vertices[0])).signum().cmp(&0)
}

/// Whether the point lies on the closed triangle; false for a triangle without area.
pub(crate) fn contains_point(vertices: &[Vector; 3], p: &Vector) -> bool {
    let n = normal(vertices);
    let q = [0, 1, 2].map(|i| difference(&vertices[i], p));
    n.iter().any(|x| !x.is_zero())
        && dot(&n, &q[0]).is_zero()
        && (0..3).all(|i| dot(&cross(&q[i], &q[(i + 1) % 3]), &n) >= Dyadic::ZERO)
}

fn normal(vertices: &[Vector; 3]) -> Vector {
    cross(&difference(&vertices[1], &vertices[0]), &difference(&vertices[2], &vertices[0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::vector;
    use geometry::glam::{DVec3, Vec3};
    use geometry::{Interval, Ray};

    fn triangle(v: [[f32; 3]; 3]) -> [Vector; 3] {
        v.map(|v| vector(Vec3::from(v).as_dvec3()))
    }

    fn ray(o: [f32; 3], d: [f32; 3]) -> Segment {
        Segment::new(&Ray::new(o, d), Interval::FULL).expect("valid")
    }

    const UNIT: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn closed_triangles_include_edges_and_vertices_but_nothing_more() {
        let t = triangle(UNIT);
        for (x, y, hit) in [
            (0.25, 0.25, true),
            (0.0, 0.0, true),
            (1.0, 0.0, true),
            (0.5, 0.5, true),
            (0.5, 0.5_f32.next_up(), false),
            (-1e-45, 0.5, false),
            (0.5, -1e-45, false),
            (1.0_f32.next_up(), 0.0, false),
        ] {
            for z in [1.0, -2.0] {
                let found = intersect(&ray([x, y, z], [0.0, 0.0, -z]), &t, EdgeRule::Closed);
                assert_eq!(found.is_some(), hit, "{x} {y}");
                if let Some(c) = found {
                    assert_eq!(c.t, ExactReal::from_f64(1.0));
                    assert_eq!(c.is_along_normal, z < 0.0);
                }
            }
        }
    }

    #[test]
    fn coplanar_rays_and_flat_triangles_are_never_hit() {
        let in_plane = ray([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]);
        for rule in [EdgeRule::Closed, EdgeRule::Shifted] {
            assert!(intersect(&in_plane, &triangle(UNIT), rule).is_none());
            for flat in [[[1.0; 3]; 3], [[0.0; 3], [0.5; 3], [1.0; 3]], [[0.0; 3], [1.0; 3], [0.0; 3]]] {
                assert!(intersect(&ray([0.0; 3], [1.0; 3]), &triangle(flat), rule).is_none());
                assert!(intersect(&ray([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]), &triangle(flat), rule).is_none());
                assert!(!contains_point(&triangle(flat), &vector(DVec3::ZERO)));
            }
        }
    }

    /// A fan of triangles around the origin: a ray through its middle, or through any spoke, crosses it once.
    #[test]
    fn a_shifted_ray_crosses_a_fan_once() {
        let rim: Vec<[f32; 3]> =
            [[2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [-1.0, 2.0], [-2.0, 0.0], [-1.0, -1.0], [0.0, -3.0], [2.0, -2.0]]
                .map(|[x, y]| [x, y, x * 0.25 + y])
                .to_vec();
        let mut aims = vec![[0.0; 3]];
        for p in &rim {
            aims.push(p.map(|x| x * 0.5));
            aims.push([p[0] * 0.25, p[1] * 0.25, 0.0]);
        }
        for d in [[0.0, 0.0, -1.0], [0.0, -0.0, 1.0], [0.25, 0.5, 4.0], [-1.0, 0.0, 8.0]] {
            for aim in &aims {
                let o = [0, 1, 2].map(|i| aim[i] - 4.0 * d[i]);
                let count = (0..rim.len())
                    .filter(|&i| {
                        let t = triangle([[0.0; 3], rim[i], rim[(i + 1) % rim.len()]]);
                        intersect(&ray(o, d), &t, EdgeRule::Shifted).is_some()
                    })
                    .count();
                assert_eq!(count, 1, "{aim:?} {d:?}");
            }
        }
    }

    #[test]
    fn sides_and_points() {
        let t = triangle(UNIT);
        let at = |x: f64, y: f64, z: f64| vector(DVec3::new(x, y, z));
        assert_eq!(side_of_plane(&t, &at(9.0, 9.0, 5e-324)), Ordering::Greater);
        assert_eq!(side_of_plane(&t, &at(9.0, 9.0, 0.0)), Ordering::Equal);
        assert_eq!(side_of_plane(&t, &at(9.0, 9.0, -5e-324)), Ordering::Less);
        assert!(contains_point(&t, &at(0.5, 0.5, 0.0)) && contains_point(&t, &at(1.0, 0.0, 0.0)));
        assert!(!contains_point(&t, &at(0.5, 0.5_f64.next_up(), 0.0)) && !contains_point(&t, &at(0.1, 0.1, 5e-324)));
    }
}
