//! Thin curled hairs on a ball: long triangles, overlapping boxes.

use geometry::TriangleMesh;
use geometry::glam::DVec3;

use super::kit::{Kit, camera};
use super::{BuiltInError, Random};
use crate::Scene;

/// A hair is an open tube of so many pieces with so many sides.
const PIECES: usize = 10;
const SIDES: usize = 3;
const TRIANGLES_PER_HAIR: u64 = 2 * (PIECES * SIDES) as u64;

const BALL_RADIUS: f64 = 0.3;
const ROOT_RADIUS: f64 = 0.005;
const TIP_RADIUS: f64 = 0.001;
/// Of a piece.
const LENGTH: f64 = 0.09;

/// Hairs of about `triangles` triangles in all around the origin, within a radius of about 1.2.
pub(super) fn scene(triangles: u64, seed: u64) -> Result<Scene, BuiltInError> {
    let hairs = ((triangles + TRIANGLES_PER_HAIR / 2) / TRIANGLES_PER_HAIR).max(1) as usize;
    let mut positions = Vec::with_capacity(hairs * (PIECES + 1) * SIDES);
    let mut indices = Vec::with_capacity(hairs * TRIANGLES_PER_HAIR as usize);
    let mut random = Random::new(seed, 0);
    for _ in 0..hairs {
        let first = positions.len() as u32;
        grow(&mut random, |p| positions.push(p.as_vec3()));
        for piece in 0..PIECES {
            let corner = |ring: usize, side: usize| first + ((piece + ring) * SIDES + side % SIDES) as u32;
            for side in 0..SIDES {
                let [a, b, c, d] = [corner(0, side), corner(0, side + 1), corner(1, side + 1), corner(1, side)];
                indices.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    let mut kit = Kit::new();
    kit.mesh(TriangleMesh::new(positions, indices), "hair")?;
    Ok(kit.finish(camera(DVec3::new(0.6, 0.9, 3.0), DVec3::ZERO, 38.0)))
}

/// The rings of one hair: a helix that leaves the ball in a random direction and whose axis of curling drifts.
fn grow(random: &mut Random, mut vertex: impl FnMut(DVec3)) {
    let root = random.direction();
    let mut point = BALL_RADIUS * root;
    let mut tangent = (root + 0.3 * random.in_ball()).normalize();
    let mut curl = 0.35 * random.in_ball();
    let mut across = tangent.any_orthonormal_vector();
    for piece in 0..=PIECES {
        let radius = ROOT_RADIUS + (TIP_RADIUS - ROOT_RADIUS) * piece as f64 / PIECES as f64;
        across = (across - across.dot(tangent) * tangent).normalize_or(tangent.any_orthonormal_vector());
        let other = tangent.cross(across);
        // The corners of an equilateral triangle: cosine -1/2 and sine ±√3/2.
        let sine = 0.75_f64.sqrt();
        for (x, y) in [(1.0, 0.0), (-0.5, sine), (-0.5, -sine)] {
            vertex(point + radius * (x * across + y * other));
        }
        point += LENGTH * tangent;
        curl += 0.12 * random.in_ball();
        tangent = (tangent + curl.cross(tangent)).normalize();
    }
}
