//! The interface between geometry and shading: what a ray can hit, and what a renderer learns about it.
//!
//! A [`Primitive`] answers ray queries and describes its hits. [`GeometricPrimitive`] gives a shape its material, area
//! light and media; [`TransformedPrimitive`] puts one copy of a primitive at many places, still or moving;
//! [`PrimitiveList`] is the naive aggregate, the reference for every tree. Aggregates are primitives themselves.
//!
//! Materials, lights and media are opaque ids: the caller owns the tables, and the BSDF is the renderer's.
//!
//! Two rules of pbrt's chapter 4 (third edition; 7 in the fourth) hold for everything here. *Closest hit*: as closer
//! hits are found, everything beyond the closest so far is disqualified, and of equal `t` the smaller primitive wins;
//! the order of testing never shows. *Material*: only primitives with a material take part in `intersect` and
//! `intersect_p`; one without delineates media.
//!
//! A ray is a [`TraversalRay`](geometry::TraversalRay), so it is valid; what cannot be hit (NaN, infinite, beyond 2⁶⁰)
//! has bounds that are not, is left out by every aggregate, and keeps its number.
//!
//! Invariants of this crate: it knows no tree, no file and no thread. Its own aggregate is the naive list.

#![warn(missing_debug_implementations, clippy::return_self_not_must_use)]

mod geometric;
mod id;
mod interaction;
mod list;
mod media;
mod primitive;
mod surface;
mod transformed;

pub use geometric::GeometricPrimitive;
pub use geometry;
pub use id::{AreaLightId, MaterialId, MediumId};
pub use interaction::SurfaceInteraction;
pub use list::PrimitiveList;
pub use media::{MediumBoundary, MediumInterface, medium_boundaries};
pub use primitive::{HitKind, Primitive};
pub use surface::Surface;
pub use transformed::{Placement, TransformedPrimitive};
