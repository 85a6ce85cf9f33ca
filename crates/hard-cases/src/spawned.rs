//! R: rays that leave a surface where another ray met it.
//!
//! What all of them demand: no spawned ray hits a triangle that does not lie ahead of the exact hit point (acne), the
//! new origin is at most 4 ulp from there (99 %); surfaces that it jumped over, and others that it meets edge-on
//! further away, are counted.

mod departure;
mod surfaces;
mod thin;

use crate::Case;

pub(crate) const CASES: &[Case] =
    &[surfaces::R01, surfaces::R02, thin::R03, thin::R04, surfaces::R05, thin::R06, surfaces::R07];
