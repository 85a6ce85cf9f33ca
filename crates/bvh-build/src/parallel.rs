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

/// Makes `all` the result for each number, in order; so many items are done then.
pub(crate) fn fill<R: Send>(
    all: &mut [R],
    progress: &ProgressReporter,
    f: impl Fn(usize) -> R + Send + Sync,
) -> Result<(), Cancelled> {
    let block = 8 * SEQUENTIAL * threads();
    for (part, begin) in all.chunks_mut(block).zip((0..).step_by(block)) {
        progress.update(part.len())?;
        fill_part(part, begin, &f);
    }
    Ok(())
}

#[cfg(feature = "parallel")]
fn fill_part<R: Send>(part: &mut [R], begin: usize, f: impl Fn(usize) -> R + Send + Sync) {
    use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
    part.par_iter_mut().with_min_len(SEQUENTIAL).enumerate().for_each(|(i, x)| *x = f(begin + i));
}

#[cfg(not(feature = "parallel"))]
fn fill_part<R: Send>(part: &mut [R], begin: usize, f: impl Fn(usize) -> R + Send + Sync) {
    part.iter_mut().zip(begin..).for_each(|(x, i)| *x = f(i));
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
