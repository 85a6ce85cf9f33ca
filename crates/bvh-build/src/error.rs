//! Why a tree cannot be built.

use thiserror::Error;

/// Why [`build`](crate::build) gave no tree. No bounds are ever a reason: invalid ones are inactive.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// A tree over so many primitives could have more nodes than its references can name.
    #[error("{count} primitives are more than one tree can hold ({limit}); split them among several trees")]
    TooManyPrimitives {
        /// How many were given; where space may be split, with the references that may be added.
        count: usize,
        /// How many always fit: 2³¹ for the trees of this crate, whose indices have 32 bits; 2²⁸ / 5 for the wide ones
        /// of `bvh-flat`, where of most meshes five times as many fit.
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
