//! What came of a case.

/// What came of a case: how often something was tried, how often it failed, and how the first failure looked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// How often it was tried.
    pub trials: u64,
    /// How often the condition did not hold.
    pub failures: u64,
    /// The first failure, in words that let it be repeated.
    pub first_failure: Option<String>,
    /// Figures worth knowing, by name: not conditions of passing.
    pub figures: Vec<(&'static str, f64)>,
}

impl Outcome {
    /// Whether it was tried at all, and nothing failed.
    pub fn passed(&self) -> bool {
        self.trials > 0 && self.failures == 0
    }
}

/// Counts what is tried. Tries of parallel workers are joined with [`and`](Self::and), in a fixed order, so that the
/// outcome does not depend on the number of threads.
#[derive(Clone, Debug, Default)]
pub struct Tries {
    outcome: Outcome,
}

impl Tries {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a trial: whether the condition holds, and what to say where it does not.
    pub fn check(&mut self, holds: bool, failure: impl FnOnce() -> String) {
        self.outcome.trials += 1;
        if !holds {
            self.outcome.failures += 1;
            if self.outcome.first_failure.is_none() {
                self.outcome.first_failure = Some(failure());
            }
        }
    }

    /// Both; the first failure is that of `self` where it has one. Figures of the same name are added.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        let (mine, theirs) = (&mut self.outcome, other.outcome);
        mine.trials += theirs.trials;
        mine.failures += theirs.failures;
        mine.first_failure = mine.first_failure.take().or(theirs.first_failure);
        for (name, value) in theirs.figures {
            match mine.figures.iter_mut().find(|(n, _)| *n == name) {
                Some((_, mine)) => *mine += value,
                None => mine.figures.push((name, value)),
            }
        }
        self
    }

    /// Notes a figure.
    pub fn figure(&mut self, name: &'static str, value: f64) {
        self.outcome.figures.push((name, value));
    }

    /// What came of it.
    pub fn outcome(self) -> Outcome {
        self.outcome
    }
}
