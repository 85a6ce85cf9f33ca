//! The buckets of a few primitives, which are sorted instead.

use super::{Boundary, Projection};
use crate::prim_info::{Bounds3A, PrimInfo};

/// Sorts `prims`, at most `CAPACITY`, by their buckets, and finds the boundary of least weight;
/// [`Boundary::place`] counts primitives. The boundary is the same as that of the buckets: those
/// between the same primitives cost the same.
pub(super) fn cheapest_boundary<const CAPACITY: usize>(prims: &mut [PrimInfo], projection: Projection) -> Boundary {
    let mut bucket = [0; CAPACITY];
    for i in 0..prims.len() {
        let (p, b) = (prims[i], projection.bucket(&prims[i]));
        let mut place = i;
        while place > 0 && bucket[place - 1] > b {
            bucket[place] = bucket[place - 1];
            prims[place] = prims[place - 1];
            place -= 1;
        }
        (bucket[place], prims[place]) = (b, p);
    }
    let mut behind = [0.0; CAPACITY];
    let mut side = Bounds3A::EMPTY;
    for (i, p) in prims.iter().enumerate().skip(1).rev() {
        side = side.union(&p.bounds());
        behind[i] = (prims.len() - i) as f64 * side.surface_area();
    }
    let mut best = Boundary::NONE;
    let mut side = Bounds3A::EMPTY;
    for place in 1..prims.len() {
        side = side.union(&prims[place - 1].bounds());
        if bucket[place - 1] < bucket[place] {
            let weight = place as f64 * side.surface_area() + behind[place];
            if weight < best.weight {
                best = Boundary { place, weight };
            }
        }
    }
    best
}
