//! R: rays that leave a surface where another ray met it. Cases of the study of accuracy, under its numbers.
//!
//! Metric M6 for all of them: no spawned ray hits a triangle that does not lie ahead of the exact hit point (acne), the
//! new origin is at most 4 ulp from there (99 %); surfaces that it jumped over, and others that it meets edge-on
//! further away, are counted.

mod departure;
mod surfaces;
mod thin;

use crate::Case;

pub(crate) const CASES: &[Case] =
    &[surfaces::R01, surfaces::R02, thin::R03, thin::R04, surfaces::R05, thin::R06, surfaces::R07];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Effort, Library, Run};

    #[test]
    fn the_library_passes() {
        let run = Run { effort: Effort::Quick, seed: 1, subject: &Library::default(), progress: &|_| () };
        let outcomes = CASES.iter().map(|case| (case.id, (case.run)(&run)));
        let failed: Vec<_> = outcomes.filter(|(_, outcome)| !outcome.passed()).collect();
        assert!(failed.is_empty(), "{failed:#?}");
    }
}
