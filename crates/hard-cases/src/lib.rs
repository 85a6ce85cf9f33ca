//! The catalogue of hard cases: input on which ray tracers lose hits, invent them, hang or crash, each with the exact
//! answer and the condition of passing. Unpublished.
//!
//! A case has an id: a letter for what it is hard on (**B**uild, boxe**S** and traversal, **T**riangles, s**P**heres,
//! **I**nstances, **A**nimation, spawned **R**ays, cache files: **X**) and a number. It is run on a [`Subject`], the
//! way in which a mesh is made to answer rays: the library's own at first, and in tests a deliberately damaged one,
//! which must fail. The library's own is exact, and no case excuses it; its binary tree with watertight kernels is kept
//! beside it.

mod aim;
mod animation;
mod boxes;
mod build;
mod cache;
mod exact_triangles;
mod instances;
mod outcome;
mod random;
mod spawned;
mod spheres;
mod subject;
mod triangles;

pub use aim::{Aim, aimed_rays};
pub use build::adversarial_meshes;
pub use cache::{check_fuzzed, files_with_huge_counts, fuzzed_mesh};
pub use outcome::{Outcome, Tries};
pub use random::Random;
pub use subject::{AnyShape, BinaryWatertight, Library, Subject};
pub use triangles::findings::{Distribution, Findings, Quantity};

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effort {
    /// At most about a second a case on one core: for every run of the tests.
    Quick,
    /// Full size: minutes to hours.
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

/// The cases that the library does not pass yet, with what is known of the reason. A test demands that it fails them,
/// so that none stays here by mistake.
pub const OPEN: [(&str, &str); 0] = [];

/// The cases that [`BinaryWatertight`] does not pass, with the reason. A test demands that it fails them, and passes
/// the others.
pub const BINARY_OPEN: [(&str, &str); 4] = [
    ("T06", "the f32 shear moves far vertices of needles that reach behind the origin by more than their boxes grow"),
    ("T14", "of an origin exactly in a slanted plane, t is 10^-16 instead of 0"),
    ("T16", "the f32 shear accepts what f64 finds outside, and clamping then moves the point by up to 11 ulp"),
    ("T25", "the f32 shear moves vertices by up to 10^6 times the size of the triangles"),
];

/// The whole catalogue, in the order of the ids within each letter.
pub fn cases() -> Vec<Case> {
    [
        build::CASES,
        boxes::CASES,
        triangles::CASES,
        spheres::CASES,
        instances::CASES,
        animation::CASES,
        spawned::CASES,
        cache::CASES,
    ]
    .concat()
}
