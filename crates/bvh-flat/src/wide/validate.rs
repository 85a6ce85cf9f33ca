//! What makes lines a wide tree over a mesh: linear in their number, front to back, and never trusts a reference.
//!
//! A subtree is one run of lines (see [`collapse`](super::collapse())), so it is enough to see that every node and leaf
//! begins where the one before it ended: then no line has two owners and none is without, there is no cycle, and
//! subtrees can be looked through in parallel.

mod batch;
mod error;
mod walk;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU8, Ordering};

use geometry::TriangleMesh;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use super::arena::LEAF_LINES;
use super::collapse::WideTree;
use super::triangles::CheckedLayout;
use crate::simd::{SimdWidth, prefetch};
use batch::See;
pub use error::InvalidWideTree;
pub(crate) use walk::WideCounts;
use walk::{Checker, Subtree, Walk};

/// Checks everything that FORMAT.md says of a wide tree over `mesh`, and counts. A tree that passes has every triangle
/// that can be hit in one leaf, as it is in the mesh, and in every box above that: whoever made it, no ray gets another
/// answer than from the mesh itself.
///
/// With spatial splits a triangle is in several leaves, and a part of it in the boxes of each. That it meets these
/// boxes is seen, and that it is in one leaf at least; that its parts are together all of it is not, and rests on the
/// checksum.
pub(crate) fn validate<Y: CheckedLayout>(tree: &WideTree, mesh: &TriangleMesh) -> Result<WideCounts, InvalidWideTree> {
    let mut seen: Vec<AtomicU8> = (0..mesh.len()).map(|_| AtomicU8::new(0)).collect();
    let mut counts = whole_tree::<Y>(tree, Some(mesh), &Marks { seen: &seen, is_split: tree.is_split })?;
    let distinct: u64 = seen.iter_mut().map(|seen| u64::from(*seen.get_mut())).sum();
    counts.repeats = repeats(tree, &counts, distinct)?;
    if distinct != mesh.len() as u64 {
        let is_missing = |i: usize, seen: &mut AtomicU8| *seen.get_mut() == 0 && mesh.triangle_bounds(i).is_valid();
        if let Some(primitive) = seen.iter_mut().enumerate().position(|(i, seen)| is_missing(i, seen)) {
            return Err(InvalidWideTree::Missing { primitive });
        }
    }
    Ok(counts)
}

/// A byte for each primitive, 1 where it was seen.
struct Marks<'a> {
    seen: &'a [AtomicU8],
    is_split: bool,
}

impl See for Marks<'_> {
    #[inline(always)]
    fn prefetch(&self, primitive: u32) {
        if let Some(seen) = self.seen.get(primitive as usize) {
            prefetch(seen);
        }
    }

    /// Threads that see the same primitive at once may both find it new; then more references are counted than
    /// primitives.
    #[inline(always)]
    fn see(&self, primitive: u32) -> bool {
        let is_new = |seen: &AtomicU8| seen.load(Ordering::Relaxed) == 0;
        let seen = self.seen.get(primitive as usize).filter(|seen| self.is_split || is_new(seen));
        seen.map(|seen| seen.store(1, Ordering::Relaxed)).is_some()
    }
}

/// All that were seen, of primitives of which nothing but their number is known.
struct Listed {
    seen: Mutex<Vec<u32>>,
    primitive_count: u64,
}

impl See for Listed {
    fn prefetch(&self, _: u32) {}

    fn see(&self, primitive: u32) -> bool {
        let exists = u64::from(primitive) < self.primitive_count;
        exists && self.seen.lock().map(|mut seen| seen.push(primitive)).is_ok()
    }
}

/// The same without the mesh, as far as it goes: compact leaves have no vertices then, and nobody knows which of the
/// `primitive_count` primitives can be hit.
pub(crate) fn validate_alone<Y: CheckedLayout>(
    tree: &WideTree,
    primitive_count: u64,
) -> Result<WideCounts, InvalidWideTree> {
    let listed = Listed { seen: Mutex::default(), primitive_count };
    let mut counts = whole_tree::<Y>(tree, None, &listed)?;
    let mut seen: Vec<u32> = listed.seen.into_inner().unwrap_or_default();
    seen.sort_unstable();
    seen.dedup();
    counts.repeats = repeats(tree, &counts, seen.len() as u64)?;
    Ok(counts)
}

/// How many references are not the first to their primitive: none but in trees with spatial splits.
fn repeats(tree: &WideTree, counts: &WideCounts, primitives: u64) -> Result<u64, InvalidWideTree> {
    let references = counts.references;
    match references - primitives {
        repeats if repeats == 0 || tree.is_split => Ok(repeats),
        _ => Err(InvalidWideTree::Repeated { references, primitives }),
    }
}

/// Walks through all lines; where there are several threads, to subtrees by one and through them by all.
fn whole_tree<Y: CheckedLayout>(
    tree: &WideTree,
    mesh: Option<&TriangleMesh>,
    see: &(impl See + Sync),
) -> Result<WideCounts, InvalidWideTree> {
    let lines = tree.arena.all();
    let Some((lines, tail)) = lines.split_last_chunk::<LEAF_LINES>() else { return Err(InvalidWideTree::Tail) };
    if tail.iter().any(|line| line.0 != [0; 16]) {
        return Err(InvalidWideTree::Tail);
    }
    let end = lines.len();
    let Some(root) = tree.root else {
        let is_nothing = end == 0 && tree.bounds == geometry::Bounds3::EMPTY;
        return if is_nothing { Ok(WideCounts::default()) } else { Err(InvalidWideTree::Tail) };
    };
    if !tree.bounds.is_valid() {
        return Err(InvalidWideTree::Bounds { node: 0 });
    }
    let checker = Checker::<Y, _>::new(tree, mesh, see);
    let width = SimdWidth::default();
    let walk = |at: Subtree, leave| width.run(Walk { checker: &checker, pending: vec![at], leave });
    let root = Subtree::root(root, end, &tree.bounds);
    #[cfg(feature = "parallel")]
    if rayon::current_num_threads() > 1 {
        let (counts, subtrees) = walk(root, end / (16 * rayon::current_num_threads()))?;
        let parts: Vec<_> = subtrees.into_par_iter().map(|subtree| walk(subtree, 0)).collect();
        // The first fault in the order of the lines, whatever the threads.
        return parts.into_iter().try_fold(counts, |counts, part| Ok(counts.and(part?.0)));
    }
    Ok(walk(root, 0)?.0)
}
