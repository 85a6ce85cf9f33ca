//! What a build tells about its progress.

use std::ops::ControlFlow;

use crate::{PhaseProgress, ReinsertionProgress, TreeStatistics};

/// A part of a build. Phases do not overlap; which of them take place, and in what order, depends on the split method
/// and on what is built. What a phase counts as its items stands in brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Phase {
    /// Asking for the bounds of all primitives, and what they take up together (primitives).
    Bounds,
    /// The recursion from the root down: [`Sah`](crate::SplitMethod::Sah), [`Middle`](crate::SplitMethod::Middle),
    /// [`EqualCounts`](crate::SplitMethod::EqualCounts) (primitives; with [`SpatialSplits`](crate::SpatialSplits)
    /// references, of which there may be fewer in the end than there is room for).
    Recursion,
    /// Computing Morton codes: [`Hlbvh`](crate::SplitMethod::Hlbvh), as the next three (primitives).
    MortonCodes,
    /// Sorting the primitives along the Morton curve (primitives).
    Sort,
    /// Building the treelets (primitives).
    Treelets,
    /// Building the tree above the treelets (treelets).
    UpperTree,
    /// Putting all nodes into one array, depth first (nodes).
    Assembly,
    /// Merging leaves, and then moving subtrees to better places: [`Reinsertion`](crate::Reinsertion) (nodes of all
    /// passes, of which the last ones may not take place; those that are no candidates are done at the beginning).
    Reinsertion,
    /// Computing the statistics (nodes).
    Statistics,
    /// Deciding which nodes become nodes of a wide tree, as `bvh-flat` does (nodes).
    Collapse,
    /// Writing nodes and leaves in the form in which they are traversed, as `bvh-flat` does (cache lines of a wide
    /// tree; nodes and primitives of a binary one).
    Emission,
}

/// Watches a build; [`build_observed`](crate::build_observed), [`Tree::optimized`](crate::Tree::optimized) and the
/// builders of `bvh-flat` take one. The library reads no clock; an observer may.
///
/// ```
/// use std::ops::ControlFlow;
/// use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
///
/// use bvh_build::{BuildObserver, PhaseProgress};
///
/// /// A counter and a flag, which other threads read and set.
/// #[derive(Default)]
/// struct Watched {
///     per_mille: AtomicU64,
///     is_cancelled: AtomicBool,
/// }
///
/// impl BuildObserver for Watched {
///     fn progressed(&self, progress: &PhaseProgress) -> ControlFlow<()> {
///         self.per_mille.store(1000 * progress.done / progress.total.max(1), Ordering::Relaxed);
///         if self.is_cancelled.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
///     }
/// }
/// ```
pub trait BuildObserver: Sync {
    /// `phase` begins now. Always on the thread that called the builder, as the end.
    fn begin(&self, phase: Phase) {
        let _ = phase;
    }

    /// `phase` has ended, or was cancelled. Comes once for each [`begin`](Self::begin).
    fn end(&self, phase: Phase) {
        let _ = phase;
    }

    /// The phase has come so far. The answer `Break` ends the build with
    /// [`BuildError::Cancelled`](crate::BuildError::Cancelled), within milliseconds on all threads, and nobody is asked
    /// again. (Selecting the median of all primitives is not interrupted, as
    /// [`EqualCounts`](crate::SplitMethod::EqualCounts) does at the root, nor sorting the candidates of reinsertion:
    /// tens of milliseconds for a million.)
    ///
    /// Called from any thread of the build, from several at once, so that an earlier progress may come after a later
    /// one; once at least in every phase; and so often (each thread in every millisecond or so) that it should not take
    /// long.
    fn progressed(&self, progress: &PhaseProgress) -> ControlFlow<()> {
        let _ = progress;
        ControlFlow::Continue(())
    }

    /// Reinsertion has come so far: many times in a pass, after a part of its candidates that does not depend on the
    /// number of threads; on the thread that called the builder. The answer `Break` ends it with the tree as it is
    /// then, which is valid at any time. An observer with a deadline answers by its clock.
    fn reinserted(&self, progress: &ReinsertionProgress) -> ControlFlow<()> {
        let _ = progress;
        ControlFlow::Continue(())
    }

    /// A binary tree is complete, with its statistics; on the thread that called the builder. What `bvh-flat` makes of
    /// it, a flat or a wide one, is still to come ([`Phase::Collapse`], [`Phase::Emission`]).
    fn built(&self, statistics: &TreeStatistics) {
        let _ = statistics;
    }
}

/// Nobody observes.
impl BuildObserver for () {}
