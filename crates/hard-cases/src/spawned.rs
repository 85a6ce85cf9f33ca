//! R: rays that leave a surface where another ray met it.
//!
//! What all of them demand: no spawned ray hits the surface that it left (acne), nor anything that an exact ray from its
//! origin does not hit; the new origin is at most 4 ulp from the exact hit point (99 %). Surfaces that it jumped over,
//! and others that it meets though their planes are not ahead of that point, are counted.

mod departure;
mod surfaces;
mod thin;

use crate::Case;

pub(crate) const CASES: &[Case] =
    &[surfaces::R01, surfaces::R02, thin::R03, thin::R04, surfaces::R05, thin::R06, surfaces::R07];
