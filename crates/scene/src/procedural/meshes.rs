//! Generators of meshes: what tests and procedural scenes are made of.
//!
//! All are right-handed, with y up, in the caller's unit. What is called *closed* is a closed manifold, oriented
//! outward, wherever its vertices are distinct: each edge belongs to two triangles, which run through it in opposite
//! directions ([`is_closed`]). Positions are computed in f64 and rounded once; angles come from `libm`, the same on
//! every platform. Numbers of segments and sides below 3 count as 3. A coordinate that the caller makes NaN or infinite
//! stands in the mesh as it is.
//!
//! Every generator fails with [`MeshError::TooLarge`], before it allocates, where the vertices or triangles would be
//! more than 32-bit indices can name. Below that, memory is the caller's care: 12 bytes a vertex and 12 a triangle.

mod icosphere;
mod loft;

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use geometry::glam::{DVec2, DVec3, Vec3};
use geometry::{MeshError, TriangleMesh};

pub use self::icosphere::icosphere;
use self::loft::{Ends, around_y, circle, loft};

/// A closed sphere of longitudes and latitudes whose distance from the center is `radius(direction)`: `rings` circles
/// of `segments` vertices each, between two poles on the y axis; 2 · `rings` · `segments` triangles. With random radii
/// it is the spiky sphere of pbrt's watertightness test. `radius` is asked for the lower pole, the upper pole, and then
/// ring by ring from below.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn uv_sphere(
    rings: usize,
    segments: usize,
    mut radius: impl FnMut(DVec3) -> f64,
) -> Result<TriangleMesh, MeshError> {
    let (rings, segments) = (rings.max(1), segments.max(3));
    let poles = [DVec3::NEG_Y, DVec3::Y].map(|d| d * radius(d));
    loft(rings, segments, &Ends::Closed(poles), |ring, segment| {
        let (sin, cos) = libm::sincos(PI * (ring + 1) as f64 / (rings + 1) as f64);
        let direction = around_y(DVec2::new(sin, -cos), segment, segments);
        direction * radius(direction)
    })
}

/// A closed box between two corners, of 12 triangles; inside out where an odd number of axes run backwards.
///
/// # Errors
/// None; it is a result like those of its neighbours.
pub fn cuboid(min: DVec3, max: DVec3) -> Result<TriangleMesh, MeshError> {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { max[a] } else { min[a] });
    let positions: Vec<Vec3> = (0..8).map(|i| DVec3::from_array(corner(i)).as_vec3()).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new(positions, triangles)
}

/// A closed surface of revolution around the y axis. `profile` is its (radius, height) from the lower end on the axis
/// over the outside to the upper end; ends that are not on the axis are capped by flat discs. It may run up and down:
/// a cup is the profile of its outside and then its inside. Points of radius 0 between the ends pinch the surface.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn revolution(profile: &[DVec2], segments: usize) -> Result<TriangleMesh, MeshError> {
    let segments = segments.max(3);
    let (Some(first), Some(last)) = (profile.first(), profile.last()) else {
        return TriangleMesh::new([Vec3::ZERO; 0], Vec::new());
    };
    let poles = [first, last].map(|p| DVec3::new(0.0, p.y, 0.0));
    let from = usize::from(first.x == 0.0);
    let to = (profile.len() - usize::from(last.x == 0.0)).max(from);
    let rings = &profile[from..to];
    loft(rings.len(), segments, &Ends::Closed(poles), |ring, segment| around_y(rings[ring], segment, segments))
}

/// A closed ring around the y axis, which it does not touch: `profile` is a closed curve of (radius, height),
/// counter-clockwise with the radius to the right and the height up.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn revolution_ring(profile: &[DVec2], segments: usize) -> Result<TriangleMesh, MeshError> {
    let segments = segments.max(3);
    loft(profile.len(), segments, &Ends::Joined, |ring, segment| around_y(profile[ring], segment, segments))
}

/// A closed tube with flat caps along `path`, with the radius `radius(i)` at its point `i`: a cylinder for two points,
/// a cone for a radius that runs towards 0. Its frame turns no more than the path does (parallel transport).
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn tube(path: &[DVec3], sides: usize, radius: impl Fn(usize) -> f64) -> Result<TriangleMesh, MeshError> {
    let (Some(&first), Some(&last)) = (path.first(), path.last()) else {
        return TriangleMesh::new([Vec3::ZERO; 0], Vec::new());
    };
    let sides = sides.max(3);
    let frames = transported_frames(path);
    loft(path.len(), sides, &Ends::Closed([first, last]), |ring, side| {
        path[ring] + circle(frames[ring], side, sides) * radius(ring)
    })
}

/// A closed tube along the torus knot that winds `turns[0]` times around the y axis and `turns[1]` times through the
/// hole, on a torus of the radii `torus[0]` (to the middle of the tube) and `torus[1]`; `radius` is that of the knot's
/// own tube. With `turns` of a common divisor the tube lies on itself.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn torus_knot(
    turns: [u32; 2],
    torus: [f64; 2],
    radius: f64,
    segments: usize,
    sides: usize,
) -> Result<TriangleMesh, MeshError> {
    let (segments, sides) = (segments.max(3), sides.max(3));
    loft(segments, sides, &Ends::Joined, |ring, side| {
        let angle = TAU * ring as f64 / segments as f64;
        let [(sin_p, cos_p), (sin_q, cos_q)] = turns.map(|n| libm::sincos(f64::from(n) * angle));
        let [p, q] = turns.map(f64::from);
        let axis = DVec3::new(cos_p, 0.0, -sin_p);
        let along = DVec3::new(-sin_p, 0.0, -cos_p);
        // The torus's own normal is never along the knot, which runs within the torus.
        let normal = cos_q * axis + sin_q * DVec3::Y;
        let point = torus[0] * axis + torus[1] * normal;
        let tangent = p * (torus[0] + torus[1] * cos_q) * along + q * torus[1] * (cos_q * DVec3::Y - sin_q * axis);
        point + circle([normal, tangent.normalize_or_zero().cross(normal)], side, sides) * radius
    })
}

/// An open sheet of `columns` × `rows` quads, two triangles each, with a vertex at every `point(column, row)` from
/// (0, 0) to (`columns`, `rows`), asked row by row. It faces upward where columns run along x and rows along z.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn grid(
    columns: usize,
    rows: usize,
    mut point: impl FnMut(usize, usize) -> DVec3,
) -> Result<TriangleMesh, MeshError> {
    let count = columns.saturating_add(1).checked_mul(rows.saturating_add(1));
    check_count("vertices", count)?;
    check_count("triangles", columns.checked_mul(rows).and_then(|quads| quads.checked_mul(2)))?;
    let points = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
    let positions: Vec<Vec3> = points.map(|(column, row)| point(column, row).as_vec3()).collect();
    let mut triangles = Vec::with_capacity(2 * columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let a = (row * (columns + 1) + column) as u32;
            let d = a + columns as u32 + 1;
            triangles.extend([[a, d + 1, a + 1], [a, d, d + 1]]);
        }
    }
    TriangleMesh::new(positions, triangles)
}

/// All triangles of several meshes in one, in order; without texture coordinates.
///
/// # Errors
/// [`MeshError::TooLarge`].
pub fn merge<'a>(meshes: impl IntoIterator<Item = &'a TriangleMesh>) -> Result<TriangleMesh, MeshError> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for mesh in meshes {
        check_count("vertices", Some(positions.len() + mesh.positions().len()))?;
        let first = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        triangles.extend(mesh.triangles().iter().map(|t| t.map(|index| first + index)));
    }
    TriangleMesh::new(positions, triangles)
}

/// Whether the mesh is a closed manifold of one orientation: each directed edge is there once, and so is its reverse.
/// Vertices of equal position count as one (−0 equals 0; NaN equals nothing), so a seam that is only there in the
/// indices is none. True for a mesh without triangles.
pub fn is_closed(mesh: &TriangleMesh) -> bool {
    let mut at_position = HashMap::new();
    let welded: Vec<u32> =
        (0_u32..)
            .zip(mesh.positions())
            .map(|(i, p)| {
                if p.is_nan() { i } else { *at_position.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert(i) }
            })
            .collect();
    let edges = || {
        mesh.triangles()
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (welded[a as usize], welded[b as usize]))
    };
    let mut counts: HashMap<(u32, u32), u32> = HashMap::new();
    edges().for_each(|edge| *counts.entry(edge).or_default() += 1);
    edges().all(|(a, b)| a != b && counts[&(a, b)] == 1 && counts.get(&(b, a)) == Some(&1))
}

/// The Catmull–Rom curve through `points` in `steps` pieces between neighbours; the ends are as if repeated.
pub fn smooth_path(points: &[DVec3], steps: usize) -> Vec<DVec3> {
    let at = |i: usize, k: isize| points[i.saturating_add_signed(k).min(points.len() - 1)];
    let mut path = Vec::new();
    for i in 0..points.len().saturating_sub(1) {
        let [a, b, c, d] = [-1, 0, 1, 2].map(|k| at(i, k));
        path.extend((0..steps).map(|step| {
            let s = step as f64 / steps as f64;
            b + 0.5 * s * ((c - a) + s * ((2.0 * a - 5.0 * b + 4.0 * c - d) + s * (3.0 * (b - c) + d - a)))
        }));
    }
    path.extend(points.last());
    path
}

/// At each point of the path two unit vectors across it; each frame is the one before, turned with the path.
fn transported_frames(path: &[DVec3]) -> Vec<[DVec3; 2]> {
    let mut tangent = DVec3::Y;
    let mut across = DVec3::ZERO;
    let frames = (0..path.len()).map(|i| {
        let step = path[(i + 1).min(path.len() - 1)] - path[i.saturating_sub(1)];
        tangent = step.normalize_or(tangent);
        across = (across - across.dot(tangent) * tangent).normalize_or(tangent.any_orthonormal_vector());
        [across, tangent.cross(across)]
    });
    frames.collect()
}

/// `None` is a count that overflowed.
fn check_count(what: &'static str, count: Option<usize>) -> Result<(), MeshError> {
    match count {
        Some(count) if u32::try_from(count).is_ok() => Ok(()),
        count => Err(MeshError::TooLarge { what, count: count.unwrap_or(usize::MAX) }),
    }
}

#[cfg(test)]
mod tests;
