//! The recursion by the surface area heuristic along all axes: each level moves primitives from one array to another,
//! which is faster than moving them within one, and can be done by many threads.
//!
//! Rejected: to divide clusters of up to 16 neighbours along the Morton curve instead of primitives, in nodes of more
//! than 128 (after Hendrich, Meister and Bittner, *Parallel BVH Construction using Progressive Hierarchical
//! Refinement*, 2017). Builds take 0.76 to 0.85 of the time, but rays visit 2 % more nodes on dragon and 18 % more on
//! black-forest, where large triangles lie among small ones; with clusters only of triangles of like size that lie
//! close together 2 and 5 % more, for 0.8 to 0.95 of the time.

use crate::parallel::{self, try_join};
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::recursive::{Rules, finish};
use crate::split::sah::{Limit, Plane, cheapest_plane};
use crate::split::{Split, split};
use crate::subtree::{Part, Step, Subtree};
use crate::{BuildConfig, Cancelled, Node, ProgressReporter, SplitAxes, SplitMethod};

/// Whether trees are grown here.
pub(crate) fn is_for(config: &BuildConfig) -> bool {
    config.split_method == SplitMethod::Sah && config.axes == SplitAxes::All
}

/// The subtree of `prims`, with no node deeper than `limit`, and their indices in the order of its leaves.
pub(crate) fn grow(prims: &mut [PrimInfo], rules: &Rules) -> Result<(Subtree, Vec<u32>), Cancelled> {
    let mut other = vec![PrimInfo::ZERO; prims.len()];
    let mut order = vec![0; prims.len()];
    let extent = Extent::of_many(prims, rules.progress)?;
    let group = Group { prims, other: &mut other, order: &mut order, first: 0, extent, rules };
    Ok((Subtree::grow(group, 1, rules.progress)?, order))
}

/// A set of primitives to split.
struct Group<'a> {
    prims: &'a mut [PrimInfo],
    /// Where they are moved to: as much room.
    other: &'a mut [PrimInfo],
    /// Where their indices go.
    order: &'a mut [u32],
    first: usize,
    extent: Extent,
    rules: &'a Rules<'a>,
}

impl Group<'_> {
    /// The plane that the heuristic finds; `None` where the set is a leaf, or must be split without one.
    fn plane(&self, depth: u32) -> Result<Option<Plane>, Cancelled> {
        let Rules { config, progress, .. } = self.rules;
        let is_weighed = self.prims.len() > config.full_sweep as usize
            && self.rules.limit.allows_any_split(depth, self.prims.len())
            && self.extent.centroid_interval().is_some()
            && self.extent.bounds.surface_area() > 0.0;
        let limit = Limit::of(self.prims.len(), &self.extent, config);
        if is_weighed && limit.is_any() {
            cheapest_plane(self.prims, &self.extent, config, limit, progress)
        } else {
            Ok(None)
        }
    }

    fn write_order(&mut self) {
        for (to, p) in self.order.iter_mut().zip(&*self.prims) {
            *to = p.index();
        }
    }
}

impl Part for Group<'_> {
    fn len(&self) -> usize {
        self.prims.len()
    }

    fn first(&self) -> usize {
        self.first
    }

    fn split(mut self, depth: u32) -> Result<Step<Self>, Cancelled> {
        let plane = self.plane(depth)?;
        let Rules { limit, progress, .. } = self.rules;
        let (axis, middle, extents) = match plane {
            Some(plane) => {
                let sides = self.other.split_at_mut(plane.middle).into();
                let centroids = distribute(self.prims, sides, &plane, progress)?;
                std::mem::swap(&mut self.prims, &mut self.other);
                let extent = |side: usize| Extent { bounds: plane.bounds[side], centroids2: centroids[side] };
                (plane.axis, plane.middle, [extent(0), extent(1)])
            }
            None => {
                let is_free = limit.allows_any_split(depth, self.prims.len());
                let Some(Split { axis, middle, extents }) = split(self.prims, &self.extent, self.rules, is_free)?
                else {
                    self.write_order();
                    return Ok(Step::Leaf(self.extent.bounds.to_bounds()));
                };
                (axis, middle, extents)
            }
        };
        let Self { prims, other, order, first, rules, .. } = self;
        let (a, b) = prims.split_at_mut(middle);
        let (a_other, b_other) = other.split_at_mut(middle);
        let (a_order, b_order) = order.split_at_mut(middle);
        Ok(Step::Interior(
            axis,
            Self { prims: a, other: a_other, order: a_order, first, extent: extents[0], rules },
            Self { prims: b, other: b_other, order: b_order, first: first + middle, extent: extents[1], rules },
        ))
    }

    fn finish(&mut self, depth: u32, nodes: &mut Vec<Node>) -> Option<u32> {
        let deepest = finish(self.prims, self.first, self.rules, depth, nodes)?;
        self.write_order();
        Some(deepest)
    }
}

/// Copies `prims` to the side of the plane where each is; the bounds of the doubled centroids on each.
fn distribute(
    prims: &[PrimInfo],
    sides: [&mut [PrimInfo]; 2],
    plane: &Plane,
    progress: &ProgressReporter,
) -> Result<[Bounds3A; 2], Cancelled> {
    /// Above this, a second thread is worth waking.
    const SEQUENTIAL: usize = 1 << 15;
    if prims.len() > SEQUENTIAL {
        let (a, b) = prims.split_at(prims.len() / 2);
        let count_behind = |part: &[PrimInfo]| part.iter().filter(|p| plane.is_behind(p.centroid2())).count();
        let behind = parallel::fold(a, progress, &count_behind, &|a, b| a + b)?;
        let [before, after] = sides;
        let ((a_before, b_before), (a_after, b_after)) =
            (before.split_at_mut(a.len() - behind), after.split_at_mut(behind));
        let (a, b) = try_join(
            || distribute(a, [a_before, a_after], plane, progress),
            || distribute(b, [b_before, b_after], plane, progress),
        )?;
        return Ok([0, 1].map(|side| a[side].union(&b[side])));
    }
    // Without a branch: half of all would be mispredicted.
    let mut centroids = [Bounds3A::EMPTY; 2];
    let mut next = [0; 2];
    for p in prims {
        let centroid2 = p.centroid2();
        let side = usize::from(plane.is_behind(centroid2));
        sides[side][next[side]] = *p;
        next[side] += 1;
        centroids[side] = centroids[side].union_point(centroid2);
    }
    Ok(centroids)
}
