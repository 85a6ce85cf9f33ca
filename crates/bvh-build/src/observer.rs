//! What a build tells about its progress.

use std::ops::ControlFlow;

use crate::{ReinsertionProgress, TreeStatistics};

/// A part of a build. Phases do not overlap; which of them take place, and in what order, depends on the split method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Phase {
    /// Checking and copying the bounds of all active primitives.
    Bounds,
    /// The recursion from the root down ([`Sah`](crate::SplitMethod::Sah), [`Middle`](crate::SplitMethod::Middle),
    /// [`EqualCounts`](crate::SplitMethod::EqualCounts)).
    Recursion,
    /// Computing Morton codes ([`Hlbvh`](crate::SplitMethod::Hlbvh), as the next three).
    MortonCodes,
    /// Sorting the primitives along the Morton curve.
    Sort,
    /// Building the treelets.
    Treelets,
    /// Building the tree above the treelets.
    UpperTree,
    /// Putting all nodes into one array, depth first.
    Assembly,
    /// Merging leaves, and then moving subtrees to better places ([`Reinsertion`](crate::Reinsertion)).
    Reinsertion,
    /// Computing the statistics.
    Statistics,
}

/// Is told where each phase of a build begins and ends, always on the thread that called
/// [`build_observed`](crate::build_observed) or [`Tree::optimized`](crate::Tree::optimized). The library reads no clock; an observer may.
pub trait BuildObserver: Sync {
    /// `phase` begins now.
    fn begin(&self, phase: Phase) {
        let _ = phase;
    }

    /// `phase` has ended.
    fn end(&self, phase: Phase) {
        let _ = phase;
    }

    /// Reinsertion has come so far: many times in a pass, after a part of its candidates that does not depend on the
    /// number of threads. The answer `Break` ends it with the tree as it is then, which is valid at any time. An
    /// observer with a deadline answers by its clock.
    fn reinserted(&self, progress: &ReinsertionProgress) -> ControlFlow<()> {
        let _ = progress;
        ControlFlow::Continue(())
    }

    /// A tree is complete.
    fn built(&self, statistics: &TreeStatistics) {
        let _ = statistics;
    }
}

/// Nobody observes.
impl BuildObserver for () {}

/// The result of `work`, which is `phase`.
pub(crate) fn observed<T>(observer: &dyn BuildObserver, phase: Phase, work: impl FnOnce() -> T) -> T {
    observer.begin(phase);
    let result = work();
    observer.end(phase);
    result
}
