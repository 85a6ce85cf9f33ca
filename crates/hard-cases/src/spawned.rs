//! R: rays that leave a surface where another ray met it.
//!
//! What all of them demand: no spawned ray hits the surface that it left (acne), and the new origin is at most 4 ulp
//! from the exact hit point (99 %). Surfaces that it jumped over are counted, and so are others that it meets though
//! their planes are not ahead of that point (grazes). Those must be met by an exact ray from the same origin too, and
//! of 10⁶ hits one at most may be met within 4 ulp: the exact half-line from the exact point does not meet these, so by
//! the letter they are acne; but any other origin that f32 has would as well see another picture so near by.

mod departure;
mod surfaces;
mod thin;

use crate::Case;

pub(crate) const CASES: &[Case] =
    &[surfaces::R01, surfaces::R02, thin::R03, thin::R04, surfaces::R05, thin::R06, surfaces::R07];
