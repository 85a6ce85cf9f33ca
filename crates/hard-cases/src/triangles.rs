//! T: triangles, and real scenes from T31 on.
//!
//! Of an exact subject nothing is excused. The allowance of the watertight tier: where a ray passes within 32 u of an
//! edge, a triangle may be hit or missed against the exact answer, which is counted and not a failure; a
//! closed mesh never leaks.

mod closed;
mod configurations;
pub(crate) mod far;
pub(crate) mod findings;
pub(crate) mod generate;
pub(crate) mod judge;
mod lattice;
mod lists;
mod near;
mod real;
mod scales;
mod seams;
mod values;
mod widths;

use crate::Case;

pub(crate) const CASES: &[Case] = &[
    closed::T01,
    closed::T02,
    closed::T03,
    closed::T04,
    lattice::T05,
    closed::T06,
    scales::T07,
    values::T08,
    lattice::T09,
    lattice::T10,
    seams::T11,
    seams::T12,
    seams::T13,
    near::T14,
    near::T15,
    values::T16,
    widths::T17,
    scales::T18,
    scales::T19,
    near::T20,
    lists::T21,
    lists::T22,
    scales::T23,
    near::T24,
    far::T25,
    real::T31,
    real::T32,
    real::T33,
    real::T34,
    real::T35,
    real::T36,
    real::T37,
    real::T38,
    configurations::T39,
    real::T40,
];
