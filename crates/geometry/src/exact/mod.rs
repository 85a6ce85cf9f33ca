//! Decisions about rays and triangles that are those of real arithmetic.
//!
//! A [watertight](crate::intersect_triangle) test only makes neighbours agree: a ray that passes an edge at less than
//! f32 can see may hit either of them, and of two surfaces an ulp apart either may be the closer. Here every decision
//! is the one that real arithmetic takes on the given numbers; so it can depend on no tree, no layout and no width of
//! registers.
//!
//! *Semantics.* An f32 stands for the number it is, and so does each f64 of a ray that was transformed into an
//! instance. A triangle is closed and has two sides: with pᵢ = vᵢ − o it is hit where its edge functions
//! eᵢ = det[pⱼ, pₖ, d] are all >= 0 or all <= 0 and D = e₀ + e₁ + e₂ is not zero. So a triangle without area, or one
//! that the ray sees edge-on, is never hit. t* = det[p₀, p₁, p₂] / D lies in the open interval, both ends compared
//! exactly; an infinite end stands for `f32::MAX`, beyond which there is no t to report. The closest hit has the least
//! t*, of equal t* the smallest index.
//!
//! *Three tiers* ([`Tier`]), each a refuge of the one before; none needs a fused multiply-add:
//! 1. edge functions in f64, sheared into the ray's frame, against one error bound for the ray;
//! 2. the same numbers against the error bound of this very triangle, and an enclosure of t*;
//! 3. exact integers: of 128 bits where the numbers lie close enough together, else of as many as it takes.
//!
//! Sources: Shewchuk 1997, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates* (the
//! order of tiers); Woop, Benthin and Wald 2013 (the shear).

mod enclosure;
mod integer;
mod number;
mod rational;
mod ray;
mod sheared;
mod tier;

#[cfg(test)]
mod tests;

pub use enclosure::{Enclosure, cmp_plane};
pub(crate) use ray::exact_weights;
pub use ray::{ExactRay, HitLanes, ValueLanes, are_coplanar, intersect_triangle_exact, values_of_hit};
pub use tier::{Tier, TierCounts, TierObserver};
