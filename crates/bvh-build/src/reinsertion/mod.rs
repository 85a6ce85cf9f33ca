//! Moving subtrees to where they cost less: Meister and Bittner, *Parallel Reinsertion for Bounding Volume Hierarchy
//! Optimization* (Computer Graphics Forum 37, 2018), after Bittner, Hapala and Havran, *Fast Insertion-Based
//! Optimization of Bounding Volume Hierarchies* (2013).
//!
//! By the surface area heuristic, a tree with given leaves costs what the areas of its interior nodes come to. Taking a
//! subtree out and putting it back elsewhere changes the areas on two paths only, so what it gains is known at once,
//! and a search with a bound finds the best place. As in the paper, many searches run in parallel over a tree that
//! stands still, and moves are made after them. Beyond it:
//!
//! - Candidates are chosen by the most they could gain: what taking them out saves, less their own area, which their
//!   new parent has at least. Of a twentieth of all nodes, chosen by this bound, three passes take 15.8 % off the
//!   interior area of a tree by the heuristic over 32 buckets and all axes, in geometric mean over six scenes; chosen
//!   by area 14.8 %. How many are worth a search is said by their share of all gains: nine tenths are in 0.4 % of the
//!   nodes of kitchen and black-forest, and in 57 % of those of hairball-procedural, whose wide tree costs 0.96 of what
//!   it did with a tenth of the nodes.
//! - A search looks below a limited number of nodes, so that its time does not depend on how much they overlap.
//! - Moves are made by one thread, and each is weighed again in the tree as the ones before left it. So no two are in
//!   conflict, the cost never rises, and the depth of the tree is known before each.
//! - The most promising candidates come in small blocks, each searched in the tree that the one before left; later
//!   ones, which hardly meet, in large blocks.

mod block;
mod candidates;
mod emit;
mod moves;
mod options;
mod search;
#[cfg(test)]
mod tests;
mod topology;

use crate::subtree::Block;
use crate::{BuildObserver, Cancelled, Node, NodeKind, ProgressReporter};
use block::Mover;
use topology::{ROOT, Topology};

pub use options::{Reinsertion, ReinsertionProgress};

/// `tree` after reinsertion by `options`. Leaves stay as they are. Areas of interior nodes never add up to more than
/// before.
pub(crate) fn optimize(
    tree: Block,
    options: &Reinsertion,
    observer: &dyn BuildObserver,
    progress: &ProgressReporter,
) -> Result<Block, Cancelled> {
    let nodes = &tree.nodes;
    let root_area = nodes.first().map_or(0.0, |root| root.bounds.surface_area());
    if root_area == 0.0 || nodes.len() < 4 {
        return Ok(tree);
    }
    let mut mover = Mover::new(Topology::new(nodes, progress)?);
    run(&mut mover, options, observer, progress)?;
    if mover.moved() == 0 {
        return Ok(tree);
    }
    let optimized = emit::emit(mover.topology(), &tree, progress)?;
    // Moves gain more than rounding loses, but for sums of very many.
    Ok(if interior_area(&optimized.nodes) < interior_area(nodes) { optimized } else { tree })
}

/// How many slots all passes rate in a tree of so many nodes.
pub(crate) fn rated_slots(node_count: usize, options: &Reinsertion) -> usize {
    (options.passes as usize).saturating_mul(Topology::slots_of(node_count))
}

/// All passes, unless one moves nothing or the observer has enough.
fn run(
    mover: &mut Mover,
    options: &Reinsertion,
    observer: &dyn BuildObserver,
    progress: &ProgressReporter,
) -> Result<(), Cancelled> {
    for pass in 0..options.passes {
        let candidates = candidates::choose(mover.topology(), options.share, progress)?;
        progress.update(mover.topology().slot_count() - candidates.len())?;
        let moved_before = mover.moved();
        let mut examined = 0;
        while examined < candidates.len() {
            let end = candidates.len().min(examined + block::size(examined));
            mover.improve(&candidates[examined..end], progress)?;
            examined = end;
            let flow = observer.reinserted(&ReinsertionProgress {
                pass,
                examined: examined as u64,
                candidates: candidates.len() as u64,
                moved: mover.moved(),
                saved: mover.saved() / mover.topology().bounds(ROOT).surface_area(),
            });
            if flow.is_break() {
                return Ok(());
            }
        }
        if mover.moved() == moved_before {
            break;
        }
    }
    Ok(())
}

/// The areas of all interior nodes together.
fn interior_area(nodes: &[Node]) -> f64 {
    let is_interior = |node: &&Node| matches!(node.kind, NodeKind::Interior { .. });
    nodes.iter().filter(is_interior).map(|node| node.bounds.surface_area()).sum()
}
