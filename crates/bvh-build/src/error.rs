//! Why a tree cannot be built.

use thiserror::Error;

/// Why [`build`](crate::build) gave no tree. No bounds are ever a reason: invalid ones are inactive.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// A tree over so many primitives could have more nodes than 32-bit indices can name.
    #[error("{count} primitives are more than one tree can hold ({limit}); split them among several trees")]
    TooManyPrimitives {
        /// How many bounds were given.
        count: usize,
        /// How many a tree can hold: 2³¹.
        limit: usize,
    },
    /// A parameter of the configuration is out of its range.
    #[error("{parameter} is {value}, but must be {requirement}")]
    InvalidConfig {
        /// The field of [`BuildConfig`](crate::BuildConfig).
        parameter: &'static str,
        /// Its value.
        value: f32,
        /// What it must be.
        requirement: &'static str,
    },
    /// The observer did not want it any more ([`BuildObserver::progressed`](crate::BuildObserver::progressed)).
    #[error("the build was cancelled")]
    Cancelled,
}
