//! Many trials, in parallel, with the worst of what they measure.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::{Outcome, Random, Run, Tries};

/// Trials to a chunk at most: each chunk has a stream of random numbers of its own.
const CHUNK: u64 = 4096;

/// What some trials came to: counts, and the largest of each figure.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trials {
    tries: Tries,
    largest: Vec<(&'static str, f64)>,
    sums: Vec<(&'static str, f64)>,
}

impl Trials {
    /// Takes a trial: whether the condition holds, and what to say where it does not.
    pub(crate) fn check(&mut self, holds: bool, failure: impl FnOnce() -> String) {
        self.tries.check(holds, failure);
    }

    /// Keeps the largest value of a figure; NaN counts as infinite.
    pub(crate) fn largest(&mut self, name: &'static str, value: f64) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        merge(&mut self.largest, name, value, f64::max);
    }

    /// Adds to a figure.
    pub(crate) fn count(&mut self, name: &'static str, value: u64) {
        merge(&mut self.sums, name, value as f64, |a, b| a + b);
    }

    fn and(mut self, other: Self) -> Self {
        self.tries = self.tries.and(other.tries);
        for (name, value) in other.largest {
            self.largest(name, value);
        }
        for (name, value) in other.sums {
            merge(&mut self.sums, name, value, |a, b| a + b);
        }
        self
    }

    /// What came of it.
    pub(crate) fn outcome(mut self) -> Outcome {
        for (name, value) in self.largest.into_iter().chain(self.sums) {
            self.tries.figure(name, value);
        }
        self.tries.outcome()
    }
}

fn merge(figures: &mut Vec<(&'static str, f64)>, name: &'static str, value: f64, join: impl Fn(f64, f64) -> f64) {
    match figures.iter_mut().find(|(n, _)| *n == name) {
        Some((_, mine)) => *mine = join(*mine, value),
        None => figures.push((name, value)),
    }
}

/// Makes `trials` trials in parallel. `trial` is given its number and a stream of random numbers that depends on the
/// seed, on `stream` and on its chunk alone, so that the outcome does not depend on the number of threads.
pub(crate) fn in_parallel(
    run: &Run,
    stream: u32,
    trials: u64,
    trial: impl Fn(u64, &mut Random, &mut Trials) + Sync,
) -> Outcome {
    let done = AtomicU64::new(0);
    // Small runs are spread over the threads too.
    let chunk = (trials / 64).clamp(1, CHUNK);
    let chunks: Vec<Trials> = (0..trials.div_ceil(chunk))
        .into_par_iter()
        .map(|i| {
            let mut random = Random::new(run.seed, u64::from(stream) << 32 | i);
            let mut all = Trials::default();
            let range = i * chunk..trials.min((i + 1) * chunk);
            let count = range.end - range.start;
            for number in range {
                trial(number, &mut random, &mut all);
            }
            (run.progress)((done.fetch_add(count, Ordering::Relaxed) + count) as f64 / trials as f64);
            all
        })
        .collect();
    chunks.into_iter().fold(Trials::default(), Trials::and).outcome()
}
