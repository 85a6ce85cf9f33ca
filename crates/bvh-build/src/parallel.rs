//! Doing two or many things, at the same time where the feature `parallel` allows it. Results never depend on it.

use crate::{Cancelled, ProgressReporter};

/// Both results.
#[cfg(feature = "parallel")]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

/// Both results.
#[cfg(not(feature = "parallel"))]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    (a(), b())
}

/// Both results, if neither is cancelled.
pub(crate) fn try_join<A: Send, B: Send>(
    a: impl FnOnce() -> Result<A, Cancelled> + Send,
    b: impl FnOnce() -> Result<B, Cancelled> + Send,
) -> Result<(A, B), Cancelled> {
    let (a, b) = join(a, b);
    Ok((a?, b?))
}

/// The result for each item, in the items' order, if none is cancelled.
pub(crate) fn map<T: Send, R: Send>(
    items: Vec<T>,
    f: impl Fn(T) -> Result<R, Cancelled> + Send + Sync,
) -> Result<Vec<R>, Cancelled> {
    #[cfg(feature = "parallel")]
    let results: Vec<_> = {
        use rayon::iter::{IntoParallelIterator, ParallelIterator};
        items.into_par_iter().map(f).collect()
    };
    #[cfg(not(feature = "parallel"))]
    let results = items.into_iter().map(f);
    results.into_iter().collect()
}

/// Has `part` write slices of `items`, the first of which is number `begin`, and unites what it says of them; so many
/// items are done then.
pub(crate) fn fold_mut<T: Send, R: Send>(
    items: &mut [T],
    begin: usize,
    progress: &ProgressReporter,
    part: &(impl Fn(&mut [T], usize) -> R + Sync),
    unite: &(impl Fn(R, R) -> R + Sync),
) -> Result<R, Cancelled> {
    if items.len() <= SEQUENTIAL {
        progress.update(items.len())?;
        return Ok(part(items, begin));
    }
    let (a, b) = items.split_at_mut(items.len() / 2);
    let middle = begin + a.len();
    let (a, b) = try_join(|| fold_mut(a, begin, progress, part, unite), || fold_mut(b, middle, progress, part, unite))?;
    Ok(unite(a, b))
}

/// Up to so many primitives, to wake a second thread takes longer than to look at them.
pub(crate) const SEQUENTIAL: usize = 1 << 13;

/// What `part` says of slices of `items`, united. Where they are cut does not depend on the number of threads.
pub(crate) fn fold<T: Sync, R: Send>(
    items: &[T],
    progress: &ProgressReporter,
    part: &(impl Fn(&[T]) -> R + Sync),
    unite: &(impl Fn(R, R) -> R + Sync),
) -> Result<R, Cancelled> {
    if items.len() <= SEQUENTIAL {
        return Ok(part(items));
    }
    progress.check()?;
    let (a, b) = items.split_at(items.len() / 2);
    let (a, b) = try_join(|| fold(a, progress, part, unite), || fold(b, progress, part, unite))?;
    Ok(unite(a, b))
}

/// How many threads there are.
#[cfg(feature = "parallel")]
pub(crate) fn threads() -> usize {
    rayon::current_num_threads()
}

/// How many threads there are.
#[cfg(not(feature = "parallel"))]
pub(crate) fn threads() -> usize {
    1
}
