//! Trees over hard cases: the table of degenerate scenes against every method and leaf size.

mod cancel;
mod check;
mod invariance;
mod matrix;
mod reinsertion;
mod scenes;
mod small_stack;
mod spatial;
mod threads;
