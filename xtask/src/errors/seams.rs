//! Rays at the seams of a mesh with a border: at edges and vertices around which the surface goes on to all sides, as
//! its indices and positions say without any arithmetic. Nothing may pass there.

use std::collections::HashMap;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Ray, Shape, TriangleMesh};
use hard_cases::{Aim, Random};

/// Up to here, a ray aimed at a seam has hit it or something before it. The seam is at t = 1, but for
/// rounding.
pub const REACH: f32 = 1.01;

/// Triangles are looked at by rays that make at least this cosine with their normals: at an outline, and nearly so,
/// kernels may differ about where the surface ends, and none leaks.
const FACING: f32 = 0.1;

/// Triangles that are not so high, as a part of the largest coordinate, are left out: rounding a target, or an edge,
/// reaches across them.
const HEIGHT: f32 = 4e-6;

/// A place where a mesh has a seam, with the triangles that meet there.
struct Seam {
    target: Vec3,
    around: Vec<[Vec3; 3]>,
}

/// About `count` rays at edges, and as many at vertices; fewer where the mesh has few seams.
pub fn rays_at_seams(mesh: &TriangleMesh, count: usize, random: &mut Random) -> [(Aim, Vec<Ray>); 2] {
    let corner = |random: &mut Random| {
        let (triangle, first) = (random.below(mesh.len()), random.below(3));
        let [a, b, _] = from_corner(mesh.vertices(triangle), first);
        (a, b)
    };
    let corners: Vec<(Vec3, Vec3)> = (0..2 * count).map(|_| corner(random)).collect();
    let fans = fans(mesh, corners.iter().map(|(a, _)| *a));
    let bounds = mesh.object_bound();
    let [edges, vertices] = [Aim::Edge, Aim::Vertex].map(|aim| {
        let seam = |(a, b): &(Vec3, Vec3), random: &mut Random| match aim {
            Aim::Edge => edge(&fans[&key(*a)], *a, *b, 0.1 + 0.8 * random.unit()),
            _ => vertex(&fans[&key(*a)], *a),
        };
        let ray = |corners: &(Vec3, Vec3)| {
            let seam = seam(corners, random)?;
            let away = bounds.diagonal().length() * (0.02 + 0.2 * random.unit());
            seam.ray(seam.target + away * random.direction())
        };
        let rays: Vec<Ray> = corners.iter().filter_map(ray).take(count).collect();
        (aim, rays)
    });
    [edges, vertices]
}

/// A position; −0 is 0.
fn key(p: Vec3) -> [u32; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// A triangle as it goes from one of its corners on.
fn from_corner([a, b, c]: [Vec3; 3], first: usize) -> [Vec3; 3] {
    [[a, b, c], [b, c, a], [c, a, b]][first]
}

/// All triangles that meet at `places`, each from there on.
fn fans(mesh: &TriangleMesh, places: impl Iterator<Item = Vec3>) -> HashMap<[u32; 3], Vec<[Vec3; 3]>> {
    let mut fans: HashMap<[u32; 3], Vec<[Vec3; 3]>> = places.map(|p| (key(p), Vec::new())).collect();
    for triangle in 0..mesh.len() {
        for first in 0..3 {
            let turned = from_corner(mesh.vertices(triangle), first);
            if let Some(fan) = fans.get_mut(&key(turned[0])) {
                fan.push(turned);
            }
        }
    }
    fans
}

/// A point of the edge from `a` to `b`, where two triangles of one orientation meet and no other.
fn edge(fan: &[[Vec3; 3]], a: Vec3, b: Vec3, part: f32) -> Option<Seam> {
    let with = |corner: usize| fan.iter().filter(move |triangle| key(triangle[corner]) == key(b)).copied();
    let (mut left, mut right) = (with(1), with(2));
    let around = vec![left.next()?, right.next()?];
    (left.next().is_none() && right.next().is_none()).then(|| Seam { target: a + part * (b - a), around })
}

/// A vertex that has triangles of one orientation all around: each spoke ends one and begins one.
fn vertex(fan: &[[Vec3; 3]], a: Vec3) -> Option<Seam> {
    let spokes = |corner: usize| {
        let mut ends: Vec<[u32; 3]> = fan.iter().map(|triangle| key(triangle[corner])).collect();
        ends.sort_unstable();
        ends
    };
    let (begin, end) = (spokes(1), spokes(2));
    let is_once = begin.windows(2).all(|pair| pair[0] != pair[1]);
    (is_once && begin == end).then(|| Seam { target: a, around: fan.to_vec() })
}

impl Seam {
    /// The ray from `origin`, where it sees one side of all triangles.
    fn ray(&self, origin: Vec3) -> Option<Ray> {
        let direction = self.target - origin;
        let largest = origin.abs().max(self.target.abs()).max_element();
        let facing = |[a, b, c]: &[Vec3; 3]| {
            let (n, longest) = ((b - a).cross(c - a), (b - a).length().max((c - a).length()).max((c - b).length()));
            let is_high = n.length() >= HEIGHT * largest * longest;
            is_high.then(|| n.dot(direction) / (n.length() * direction.length()))
        };
        let facing: Vec<f32> = self.around.iter().map(facing).collect::<Option<_>>()?;
        let is_seen = |side: f32| facing.iter().all(|cosine| side * cosine > FACING);
        (is_seen(1.0) || is_seen(-1.0)).then(|| Ray::new(origin, direction))
    }
}

#[cfg(test)]
mod tests {
    use bvh_flat::geometry::{Interval, Naive, TraversalRay};
    use bvh_flat::{BuildConfig, MeshBvh, WideMesh};

    use super::*;

    /// A hilly square: seams within, and a border around.
    fn hills() -> TriangleMesh {
        let n = 40_u32;
        let point = |i: u32| {
            let [x, y] = [i % n, i / n].map(|k| 0.037 * k as f32);
            Vec3::new(x, y, (9.0 * x).sin() * (7.0 * y).cos() * 0.1)
        };
        let squares = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| y * n + x));
        let triangles: Vec<[u32; 3]> = squares.flat_map(|i| [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]).collect();
        TriangleMesh::new((0..n * n).map(point).collect::<Vec<_>>(), triangles).expect("a mesh")
    }

    #[test]
    fn rays_at_seams_pass_naive_kernels_alone() {
        let mesh = std::sync::Arc::new(hills());
        let sets = rays_at_seams(&mesh, 4096, &mut Random::new(1, 0));
        let wide = WideMesh::build(mesh.clone(), &BuildConfig::default()).expect("built");
        let watertight = MeshBvh::build(mesh, &BuildConfig::default()).expect("built");
        let naive = watertight.with_kernels::<Naive>();
        for (aim, rays) in &sets {
            assert!(rays.len() > 2048, "{aim:?}: {}", rays.len());
            let passed = |shape: &dyn Shape| {
                let passes = |ray: &&Ray| {
                    shape.intersect(&TraversalRay::new(ray).expect("a valid ray"), Interval::up_to(REACH)).is_none()
                };
                rays.iter().filter(passes).count()
            };
            assert_eq!([passed(&wide), passed(&watertight)], [0, 0], "{aim:?}");
            assert!(passed(&naive) > 0, "{aim:?}");
        }
    }

    /// A single triangle has no seam, and neither have two that turn against each other.
    #[test]
    fn borders_are_no_seams() {
        let mesh = |triangles: &[[u32; 3]]| {
            let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
            TriangleMesh::new(corners, triangles.to_vec()).expect("a mesh")
        };
        let found = |triangles: &[[u32; 3]]| {
            rays_at_seams(&mesh(triangles), 64, &mut Random::new(1, 0)).map(|(_, rays)| rays.len())
        };
        assert_eq!(found(&[[0, 1, 2]]), [0, 0]);
        assert_eq!(found(&[[0, 1, 2], [1, 2, 3]]), [0, 0]);
        let [edges, vertices] = found(&[[0, 1, 2], [1, 3, 2]]);
        assert!(edges > 0 && vertices == 0);
    }
}
