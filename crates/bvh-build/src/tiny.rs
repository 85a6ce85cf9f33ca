//! Scenes of denormal numbers, with which arithmetic takes ten times as long: they are built at another scale.

use geometry::Bounds3;
use geometry::glam::Vec3;

use crate::prim_info::{ActivePrims, Bounds3A, Extent};
use crate::{ClippedBounds, Node};

/// By what tiny scenes are multiplied. From 2⁻¹⁴⁹ on all numbers and the products of two of them are normal then; and
/// as a power of two it changes no tree.
const SCALE: f32 = f32::from_bits((127 + 100) << 23);

/// Below that in magnitude coordinates are tiny: 2⁻⁶⁰.
const TINY: f32 = f32::from_bits((127 - 60) << 23);

/// Scales primitives all of whose coordinates are tiny, and says whether they are.
pub(crate) fn scale(active: &mut ActivePrims) -> bool {
    let Bounds3A { min, max } = active.extent.bounds;
    let are_tiny = min.abs().max(max.abs()).max_element() < TINY;
    if are_tiny {
        active.prims().iter_mut().for_each(|p| *p = p.scaled(SCALE));
        active.extent = Extent::of(active.prims());
    }
    are_tiny
}

/// Scales the bounds of `nodes` back: outward where they are of parts of primitives, which need not fit the old scale.
pub(crate) fn scale_back(nodes: &mut [Node]) {
    for node in nodes {
        node.bounds = before(&node.bounds);
    }
}

/// As `clipped` answers, at the other scale.
pub(crate) fn clipped(clipped: &ClippedBounds, index: u32, to: &Bounds3) -> Bounds3 {
    let part = clipped(index, &before(to));
    Bounds3::new((part.min * SCALE).max(to.min), (part.max * SCALE).min(to.max))
}

/// The bounds at the old scale, rounded outward.
fn before(bounds: &Bounds3) -> Bounds3 {
    let low = |x: f32| {
        let y = x / SCALE;
        if y * SCALE > x { y.next_down() } else { y }
    };
    let high = |x: f32| -low(-x);
    let Bounds3 { min, max } = bounds;
    Bounds3::new(Vec3::new(low(min.x), low(min.y), low(min.z)), Vec3::new(high(max.x), high(max.y), high(max.z)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ProgressReporter;

    #[test]
    fn tiny_bounds_come_back_as_they_were() {
        let mut all = Vec::new();
        for exponent in -149..-61 {
            let x = 2.0_f32.powi(-75) * 2.0_f32.powi(exponent + 75);
            let bounds = Bounds3::new(Vec3::new(-1.7 * x, 0.0, x), Vec3::new(-x, x, 1.9 * x));
            all.push(bounds);
        }
        let mut active = ActivePrims::new(all.len(), 0, |i| all[i as usize], &ProgressReporter::unobserved())
            .expect("nobody cancels");
        assert!(scale(&mut active));
        assert_eq!(Extent::of(active.prims()), active.extent);
        for ((p, bounds), i) in active.prims().iter().zip(&all).zip(0..) {
            let scaled = p.bounds().to_bounds();
            assert!(scaled.max.z >= f32::MIN_POSITIVE, "{scaled:?}");
            assert_eq!(p.index(), i);
            assert_eq!(before(&scaled), *bounds);
        }
        assert!(!scale(&mut active), "they are not tiny any more");
    }

    #[test]
    fn what_does_not_fit_the_old_scale_is_rounded_outward() {
        let step = f32::from_bits(1);
        let between = 1.5 * (step * SCALE);
        let bounds = Bounds3::new(Vec3::new(between, -between, 0.0), Vec3::new(between, -between, between));
        let old = before(&bounds);
        assert_eq!(old.min, Vec3::new(step, -2.0 * step, 0.0));
        assert_eq!(old.max, Vec3::new(2.0 * step, -step, 2.0 * step));
    }
}
