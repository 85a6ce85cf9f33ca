//! How far a phase has come, and whether it is to go on.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::{BuildError, BuildObserver, Phase};

/// A loop tells its progress after so many steps.
const STRIDE: usize = 1 << 13;

/// How far a phase has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PhaseProgress {
    /// The phase.
    pub phase: Phase,
    /// How many of its items are done. Never more than `total`.
    pub done: u64,
    /// How many items it has; [`Phase`] says what these are. May be 0.
    pub total: u64,
}

/// The build is not wanted any more: what is left of a phase has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

impl From<Cancelled> for BuildError {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Tells an observer how far a phase has come, from any thread; and the phase, whether to go on.
pub struct ProgressReporter<'a> {
    observer: &'a dyn BuildObserver,
    phase: Phase,
    total: u64,
    done: AtomicU64,
    is_cancelled: AtomicBool,
}

impl fmt::Debug for ProgressReporter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { phase, total, done, .. } = self;
        f.debug_struct("ProgressReporter")
            .field("phase", phase)
            .field("done", done)
            .field("total", total)
            .finish_non_exhaustive()
    }
}

impl<'a> ProgressReporter<'a> {
    /// The result of `work`, which is `phase` and has `total` items, as `observer` is told: that it begins and ends,
    /// and what `work` reports. For those who make something of a tree, as a part of the build.
    ///
    /// # Errors
    /// [`Cancelled`], where the observer has said so, or `work`.
    pub fn observe<T>(
        observer: &'a dyn BuildObserver,
        phase: Phase,
        total: usize,
        work: impl FnOnce(&Self) -> Result<T, Cancelled>,
    ) -> Result<T, Cancelled> {
        let (done, is_cancelled) = (AtomicU64::new(0), AtomicBool::new(false));
        let reporter = Self { observer, phase, total: total as u64, done, is_cancelled };
        observer.begin(phase);
        let result = reporter.check().and_then(|()| work(&reporter));
        observer.end(phase);
        result
    }

    /// Of a phase that nobody observes.
    #[cfg(test)]
    pub(crate) const fn unobserved() -> ProgressReporter<'static> {
        let (done, is_cancelled) = (AtomicU64::new(0), AtomicBool::new(false));
        ProgressReporter { observer: &(), phase: Phase::Recursion, total: u64::MAX, done, is_cancelled }
    }

    /// So many more items are done. More than there are in all are told as all.
    ///
    /// # Errors
    /// [`Cancelled`], from the moment on when the observer has said so to anyone.
    pub fn update(&self, count: usize) -> Result<(), Cancelled> {
        // A thread that sees the flag late does a little more for nothing.
        if self.is_cancelled.load(Ordering::Relaxed) {
            return Err(Cancelled);
        }
        let done = self.done.fetch_add(count as u64, Ordering::Relaxed) + count as u64;
        let progress = PhaseProgress { phase: self.phase, done: done.min(self.total), total: self.total };
        if self.observer.progressed(&progress).is_break() {
            self.is_cancelled.store(true, Ordering::Relaxed);
            return Err(Cancelled);
        }
        Ok(())
    }

    /// Nothing more is done, but time has passed.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn check(&self) -> Result<(), Cancelled> {
        self.update(0)
    }

    /// Step `i`, below the total, begins of a loop over all items: of 8192 such steps the first is told, with the items
    /// of all.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    #[inline]
    pub fn step(&self, i: usize) -> Result<(), Cancelled> {
        if i.is_multiple_of(STRIDE) { self.update(STRIDE.min((self.total as usize).saturating_sub(i))) } else { Ok(()) }
    }

    /// As [`step`](Self::step), of a loop that is not what the items count.
    pub(crate) fn check_step(&self, i: usize) -> Result<(), Cancelled> {
        if i.is_multiple_of(STRIDE) { self.check() } else { Ok(()) }
    }
}
