//! A fractal landscape: one regular grid.

use geometry::glam::{DVec2, DVec3};

use super::kit::{Kit, camera};
use super::random::{TWO_POW_32, scramble};
use super::{BuiltInError, meshes};
use crate::Scene;

/// Along x and z, centered at the origin.
const EXTENT: f64 = 100.0;
/// Of the first octave; all octaves together reach about twice as high.
const HEIGHT: f64 = 15.0;
/// How wide a hill of the first octave is.
const HILL: f64 = 34.0;
/// The last octave's hills are 34 / 2¹⁰ = 0.03 wide, finer than the quads of 10 million triangles.
const OCTAVES: u64 = 11;

/// A grid of about `triangles` triangles: of the nearly square ones, the one of the nearest number.
pub(super) fn scene(triangles: u64, seed: u64) -> Result<Scene, BuiltInError> {
    let quads = triangles.div_ceil(2);
    let columns = quads.isqrt().max(1);
    let rows = ((quads + columns / 2) / columns).max(1);
    let at = |x: f64, z: f64| {
        let [x, z] = [x, z].map(|t| EXTENT * (t - 0.5));
        DVec3::new(x, height(seed, DVec2::new(x, z)), z)
    };
    let mut kit = Kit::new();
    let mesh = meshes::grid(columns as usize, rows as usize, |column, row| {
        at(column as f64 / columns as f64, row as f64 / rows as f64)
    });
    kit.mesh(mesh, "rock")?;
    let (eye, look) = (at(0.5, 0.02), at(0.5, 0.4));
    Ok(kit.finish(camera(eye + 16.0 * DVec3::Y, look - 5.0 * DVec3::Y, 50.0)))
}

/// Octaves of value noise, each turned against the one before and damped where those before it are steep, so that
/// slopes are smooth and ridges rough, as erosion leaves them (Quílez, *Value Noise Derivatives*, 2008).
fn height(seed: u64, p: DVec2) -> f64 {
    let mut p = p / HILL;
    let (mut sum, mut slope, mut amplitude) = (0.0, DVec2::ZERO, HEIGHT);
    for octave in 0..OCTAVES {
        let (value, gradient) = value_noise(scramble(seed).wrapping_add(octave), p);
        slope += gradient;
        sum += amplitude * value / (1.0 + slope.length_squared());
        amplitude *= 0.5;
        p = 2.0 * DVec2::new(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y);
    }
    sum
}

/// Random values of [0, 1) at whole coordinates, and between them twice differentiable interpolation (Perlin 2002,
/// *Improving Noise*): the value and its gradient.
fn value_noise(seed: u64, p: DVec2) -> (f64, DVec2) {
    let cell = p.floor();
    let f = p - cell;
    let (x, y) = (cell.x as i64, cell.y as i64);
    let corner = |dx: i64, dy: i64| {
        let word = scramble(seed ^ scramble((x + dx) as u64 ^ ((y + dy) as u64).rotate_left(32)));
        (word >> 32) as f64 / TWO_POW_32
    };
    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let dw = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    let (bx, cy, twist) = (b - a, c - a, a - b - c + d);
    let value = a + bx * w.x + cy * w.y + twist * w.x * w.y;
    (value, dw * DVec2::new(bx + twist * w.y, cy + twist * w.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::Random;

    /// Against differences of the value, which is continuous over the cells' borders as well.
    #[test]
    fn the_gradient_is_that_of_the_value() {
        let mut random = Random::new(5, 0);
        for i in 0..1000 {
            let mut p = DVec2::new(random.between(-9.0, 9.0), random.between(-9.0, 9.0));
            if i % 4 == 0 {
                p.x = p.x.round();
            }
            let (value, gradient) = value_noise(3, p);
            assert!((0.0..=1.0).contains(&value));
            let h = 1e-5;
            for (axis, along) in [(DVec2::X, gradient.x), (DVec2::Y, gradient.y)] {
                let difference = value_noise(3, p + h * axis).0 - value_noise(3, p - h * axis).0;
                assert!((difference / (2.0 * h) - along).abs() < 1e-6, "{p}");
            }
        }
    }
}
