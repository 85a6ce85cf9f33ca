//! The same recursion for sets that fit the caches, by one thread and without a group for each node.

use geometry::Axis;

use super::{Group, cheapest, distribute};
use crate::Cancelled;
use crate::prim_info::{Extent, PrimInfo};
use crate::recursive::{Rules, finish};
use crate::split::sah::{Limit, Plane};
use crate::split::{Split, split};
use crate::subtree::Block;

/// A part that is still to be split.
struct Set {
    begin: usize,
    end: usize,
    /// Whether its primitives are in the second array.
    is_moved: bool,
    depth: u32,
    extent: Extent,
}

/// Appends the subtree of `group` to `block`, with its root at `depth`; the depth of its deepest node.
#[inline(never)] // Not on the stack of those who grow large parts.
pub(super) fn grow(group: &mut Group, depth: u32, block: &mut Block) -> Result<u32, Cancelled> {
    let Group { prims, other, extent, rules } = group;
    let mut deepest = depth;
    let mut set = Set { begin: 0, end: prims.len(), is_moved: false, depth, extent: *extent };
    // Second children, each with its parent.
    let mut pending: Vec<(Set, usize)> = Vec::new();
    loop {
        let Set { begin, end, is_moved, depth, .. } = set;
        deepest = deepest.max(depth);
        let (from, to) = if is_moved { (&mut *other, &mut *prims) } else { (&mut *prims, &mut *other) };
        let (from, to) = (&mut from[begin..end], &mut to[begin..end]);
        match step(from, to, &set, rules, block)? {
            Outcome::Split { axis, middle, extents: [a, b], is_moved } => {
                let (middle, depth) = (begin + middle, depth + 1);
                pending.push((Set { begin: middle, end, is_moved, depth, extent: b }, block.nodes.len()));
                set = Set { begin, end: middle, is_moved, depth, extent: a };
                block.push_interior(axis);
            }
            Outcome::Done(end_depth) => {
                deepest = deepest.max(end_depth);
                let Some((next, parent)) = pending.pop() else { return Ok(deepest) };
                block.begin_second_child(parent);
                set = next;
            }
        }
    }
}

/// What became of a set.
enum Outcome {
    /// Its subtree is appended, with the deepest node at this depth.
    Done(u32),
    /// Two sets, of which the first has so many primitives; in the other array if they were moved.
    Split { axis: Axis, middle: usize, extents: [Extent; 2], is_moved: bool },
}

#[inline(always)]
fn step(
    from: &mut [PrimInfo],
    to: &mut [PrimInfo],
    set: &Set,
    rules: &Rules,
    block: &mut Block,
) -> Result<Outcome, Cancelled> {
    let Set { is_moved, depth, extent, .. } = set;
    // Asked first: it is what ends most of the recursion.
    let is_leaf = Limit::is_cheap(from.len(), &rules.config);
    if !is_leaf {
        if let Some(deepest) = finish(from, rules, *depth, block) {
            return Ok(Outcome::Done(deepest));
        }
        if let Some(plane) = cheapest(from, extent, rules, *depth)? {
            let centroids = distribute(from, to.split_at_mut(plane.middle).into(), &plane, rules.progress)?;
            let Plane { axis, middle, .. } = plane;
            return Ok(Outcome::Split { axis, middle, extents: plane.extents(centroids), is_moved: !is_moved });
        }
        let is_free = rules.limit.allows_any_split(*depth, from.len());
        if let Some(Split { axis, middle, extents }) = split(from, extent, rules, is_free)? {
            return Ok(Outcome::Split { axis, middle, extents, is_moved: *is_moved });
        }
    }
    block.push_leaf(extent.bounds.to_bounds(), from.iter().map(PrimInfo::index));
    Ok(Outcome::Done(*depth))
}
