//! What a case finds on its way: checks, counts, and the distributions of errors.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::{Outcome, Random, Run, Tries};

/// Something measured often, of which a case reports a quantile and the largest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// The error of t, in units of the spacing of f32 at the exact t, where the ray is not grazing (kappa <= 10).
    TError,
    /// The same over kappa = |d| |n| / |d·n|, where the ray is grazing.
    TErrorByKappa,
    /// The error of the hit point in f32, in units of the spacing of f32 at its largest coordinate.
    PointError,
    /// Its bound, in the same units.
    PointBound,
    /// The bound over the error, or over half the spacing where the error is less.
    PointTightness,
    /// How far the origin of a spawned ray is from the exact hit point, in units of the spacing of f32 at its largest
    /// coordinate.
    Detachment,
}

impl Quantity {
    /// Its figures: their names and quantiles.
    fn figures(self) -> [(&'static str, f64); 2] {
        match self {
            Self::TError => [("t error p99.99 [ulp]", 0.9999), ("t error max [ulp]", 1.0)],
            Self::TErrorByKappa => [("t error / kappa p99.99 [ulp]", 0.9999), ("t error / kappa max [ulp]", 1.0)],
            Self::PointError => [("p error p99.99 [ulp]", 0.9999), ("p error max [ulp]", 1.0)],
            Self::PointBound => [("p bound p99.99 [ulp]", 0.9999), ("p bound max [ulp]", 1.0)],
            // Its largest is nothing: a coordinate of zero has an error of zero.
            Self::PointTightness => [("p bound / error p50", 0.5), ("p bound / error p90", 0.9)],
            Self::Detachment => [("detachment p99 [ulp]", 0.99), ("detachment max [ulp]", 1.0)],
        }
    }
}

/// A distribution of numbers that are not negative, in bins of 1 % width.
#[derive(Clone, Debug, Default)]
pub struct Distribution {
    bins: BTreeMap<u64, u64>,
    /// How many there are.
    pub count: u64,
    /// The largest.
    pub max: f64,
}

impl Distribution {
    /// The significand's bits that tell bins apart: 7.
    const SHIFT: u32 = 45;

    /// Takes a number; one that is not is taken for infinite.
    pub fn add(&mut self, value: f64) {
        // A NaN is worse than everything.
        let value = if value.is_nan() { f64::INFINITY } else { value };
        *self.bins.entry(value.to_bits() >> Self::SHIFT).or_default() += 1;
        self.count += 1;
        self.max = self.max.max(value);
    }

    /// Both.
    pub fn and(mut self, other: &Self) -> Self {
        for (&bin, &count) in &other.bins {
            *self.bins.entry(bin).or_default() += count;
        }
        Self { count: self.count + other.count, max: self.max.max(other.max), ..self }
    }

    /// The upper end of the bin with the quantile, or the largest value where that is less.
    pub fn quantile(&self, q: f64) -> f64 {
        let mut left = (q * self.count as f64).ceil() as u64;
        for (&bin, &count) in &self.bins {
            if count >= left {
                return f64::from_bits((bin + 1) << Self::SHIFT).min(self.max);
            }
            left -= count;
        }
        self.max
    }
}

/// What a case, or a part of it, has found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    tries: Tries,
    counts: BTreeMap<&'static str, u64>,
    distributions: BTreeMap<Quantity, Distribution>,
}

impl Findings {
    /// Takes a trial: whether the condition holds, and what to say where it does not.
    pub(crate) fn check(&mut self, holds: bool, failure: impl FnOnce() -> String) {
        self.tries.check(holds, failure);
    }

    /// Counts what is a figure and no condition.
    pub(crate) fn count(&mut self, name: &'static str, n: u64) {
        *self.counts.entry(name).or_default() += n;
    }

    /// How often `name` was counted.
    pub(crate) fn counted(&self, name: &str) -> u64 {
        self.counts.get(name).copied().unwrap_or(0)
    }

    /// Takes a measurement.
    pub fn measure(&mut self, quantity: Quantity, value: f64) {
        self.distributions.entry(quantity).or_default().add(value);
    }

    /// A trial: the quantile of what was measured is at most `most`. Nothing measured is a failure.
    pub fn require(&mut self, quantity: Quantity, quantile: f64, most: f64) {
        let found = self.distributions.get(&quantity).map(|d| d.quantile(quantile));
        self.tries.check(found.is_some_and(|x| x <= most), || {
            format!("{quantity:?}: {found:?} at the quantile {quantile}, allowed is {most}")
        });
    }

    /// A trial: something was counted at least `least` times. A case that never meets what it is about proves nothing.
    pub fn require_count(&mut self, name: &'static str, least: u64) {
        let found = self.counted(name);
        self.tries.check(found >= least, || format!("only {found} of {name}, {least} are needed"));
    }

    /// Both.
    pub(crate) fn and(mut self, other: Self) -> Self {
        for (&name, &n) in &other.counts {
            self.count(name, n);
        }
        for (&quantity, theirs) in &other.distributions {
            let mine = self.distributions.remove(&quantity).unwrap_or_default();
            self.distributions.insert(quantity, mine.and(theirs));
        }
        Self { tries: self.tries.and(other.tries), ..self }
    }

    /// What comes of them all.
    pub fn outcome(self) -> Outcome {
        let mut tries = self.tries;
        for (name, n) in self.counts {
            tries.figure(name, n as f64);
        }
        for (quantity, distribution) in self.distributions {
            for (name, q) in quantity.figures() {
                tries.figure(name, distribution.quantile(q));
            }
        }
        tries.outcome()
    }
}

/// Why a case could not even be tried: a mesh, a tree or a transform that was refused.
pub(crate) type Fallible<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// What came of a case; one that could not be tried has failed.
pub(crate) fn outcome_of(found: Fallible<Findings>) -> Outcome {
    match found {
        Ok(findings) => findings.outcome(),
        Err(error) => {
            let mut tries = Tries::new();
            tries.check(false, || format!("could not be tried: {error}"));
            tries.outcome()
        }
    }
}

/// Tries something `count` times, in parallel: each chunk of 1024 trials has its own stream of random numbers, so the
/// findings depend on the seed and on nothing else.
pub(crate) fn in_chunks(
    run: &Run,
    stream: u64,
    count: usize,
    try_one: impl Fn(usize, &mut Random, &mut Findings) + Sync,
) -> Findings {
    const CHUNK: usize = 1024;
    let chunks = count.div_ceil(CHUNK);
    let done = AtomicUsize::new(0);
    (0..chunks)
        .into_par_iter()
        .map(|chunk| {
            let mut random = Random::new(run.seed, stream << 40 | chunk as u64);
            let mut findings = Findings::default();
            for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                try_one(i, &mut random, &mut findings);
            }
            (run.progress)((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / chunks as f64);
            findings
        })
        .reduce(Findings::default, Findings::and)
}
