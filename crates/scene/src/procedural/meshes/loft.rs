//! Surfaces of one polygon after the other.

use std::f64::consts::TAU;

use geometry::glam::{DVec2, DVec3};
use geometry::{MeshError, TriangleMesh};

use super::check_count;

/// What lies before the first and after the last ring of a [`loft`].
pub(super) enum Ends {
    /// The first ring follows the last.
    Joined,
    /// A fan around a point at each end.
    Closed([DVec3; 2]),
}

/// A surface of `rings` closed polygons of `sides` vertices, with two triangles for each quad between neighbours. The
/// outside is where the sides run counter-clockwise around the direction in which the rings follow each other.
pub(super) fn loft(
    rings: usize,
    sides: usize,
    ends: &Ends,
    mut point: impl FnMut(usize, usize) -> DVec3,
) -> Result<TriangleMesh, MeshError> {
    check_count("vertices", rings.checked_mul(sides).and_then(|n| n.checked_add(2)))?;
    check_count("triangles", rings.checked_mul(sides).and_then(|n| n.checked_mul(2)))?;
    let mut positions = Vec::with_capacity(rings * sides + 2);
    for ring in 0..rings {
        positions.extend((0..sides).map(|side| point(ring, side).as_vec3()));
    }
    let index = |ring: usize, side: usize| (ring % rings * sides + side % sides) as u32;
    let mut triangles = Vec::with_capacity(2 * rings * sides);
    let bands = if matches!(ends, Ends::Joined) { rings } else { rings.saturating_sub(1) };
    for ring in 0..bands {
        for side in 0..sides {
            let [a, b] = [side, side + 1].map(|side| index(ring, side));
            let [d, c] = [side, side + 1].map(|side| index(ring + 1, side));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if let Ends::Closed(poles) = ends
        && rings > 0
    {
        let lower = positions.len() as u32;
        positions.extend(poles.map(|p| p.as_vec3()));
        triangles.extend((0..sides).map(|side| [lower, index(0, side + 1), index(0, side)]));
        triangles.extend((0..sides).map(|side| [lower + 1, index(rings - 1, side), index(rings - 1, side + 1)]));
    }
    TriangleMesh::new(positions, triangles)
}

/// The point of (radius, height) at `segment` of `segments` around the y axis, counter-clockwise as seen from above.
pub(super) fn around_y(at: DVec2, segment: usize, segments: usize) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * segment as f64 / segments as f64);
    DVec3::new(at.x * cos, at.y, -at.x * sin)
}

/// Point `side` of `sides` on the unit circle of a frame's two axes.
pub(super) fn circle([x, y]: [DVec3; 2], side: usize, sides: usize) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * side as f64 / sides as f64);
    cos * x + sin * y
}
