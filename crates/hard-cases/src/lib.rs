//! The catalogue of hard cases: input on which ray tracers lose hits, invent them, hang or crash, each with the exact
//! answer and the condition of passing. Unpublished.
//!
//! A case has an id: a letter for what it is hard on (**B**uild, boxe**S** and traversal, **T**riangles, s**P**heres,
//! **I**nstances, **A**nimation, spawned **R**ays) and a number. It is run on a [`Subject`], the way in which a mesh is
//! made to answer rays: the library's own at first, and in tests a deliberately damaged one, which must fail.

mod aim;
mod animation;
mod boxes;
mod build;
mod instances;
mod outcome;
mod random;
mod spawned;
mod spheres;
mod subject;
mod triangles;

pub use aim::{Aim, aimed_rays};
pub use outcome::{Outcome, Tries};
pub use random::Random;
pub use subject::{Library, Subject};

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effort {
    /// At most about a second a case on one core: for every run of the tests.
    Quick,
    /// The sizes of the study: minutes to hours.
    Full,
}

impl Effort {
    /// `quick` or `full`.
    pub fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// A hard case.
#[derive(Clone, Copy)]
pub struct Case {
    /// Its id, as B03 or T02.
    pub id: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// Tries it.
    pub run: fn(&Run) -> Outcome,
}

/// What a case is run with.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// How much is tried.
    pub effort: Effort,
    /// Of everything random.
    pub seed: u64,
    /// How meshes are made to answer rays.
    pub subject: &'a dyn Subject,
    /// Is told the part done, from 0 to 1, by cases that take long.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// The whole catalogue, in the order of the ids within each letter.
pub fn cases() -> Vec<Case> {
    [build::CASES, boxes::CASES, triangles::CASES, spheres::CASES, instances::CASES, animation::CASES, spawned::CASES]
        .concat()
}
