//! Doing two or many things, at the same time where the feature `parallel` allows it. Results never depend on it.

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

/// The result for each item, in the items' order.
#[cfg(feature = "parallel")]
pub(crate) fn map<T: Send, R: Send>(items: Vec<T>, f: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
    use rayon::iter::{IntoParallelIterator, ParallelIterator};
    items.into_par_iter().map(f).collect()
}

/// The result for each item, in the items' order.
#[cfg(not(feature = "parallel"))]
pub(crate) fn map<T: Send, R: Send>(items: Vec<T>, f: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
    items.into_iter().map(f).collect()
}

/// The result for each number below `count`, in order.
#[cfg(feature = "parallel")]
pub(crate) fn collect<R: Send>(count: usize, f: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
    (0..count).into_par_iter().with_min_len(SEQUENTIAL).map(f).collect()
}

/// The result for each number below `count`, in order.
#[cfg(not(feature = "parallel"))]
pub(crate) fn collect<R: Send>(count: usize, f: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    (0..count).map(f).collect()
}

/// Up to so many primitives, to wake a second thread takes longer than to look at them.
pub(crate) const SEQUENTIAL: usize = 1 << 13;

/// What `part` says of slices of `items`, united. Where they are cut does not depend on the number of threads.
pub(crate) fn fold<T: Sync, R: Send>(
    items: &[T],
    part: &(impl Fn(&[T]) -> R + Sync),
    unite: &(impl Fn(R, R) -> R + Sync),
) -> R {
    if items.len() <= SEQUENTIAL {
        return part(items);
    }
    let (a, b) = items.split_at(items.len() / 2);
    let (a, b) = join(|| fold(a, part, unite), || fold(b, part, unite));
    unite(a, b)
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
