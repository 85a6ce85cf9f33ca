//! Participating media: what lies on both sides of a surface, and which media a ray goes through.

use std::ops::ControlFlow;

use geometry::{Hit, Interval, TraversalRay};

use crate::{HitKind, MediumId, Primitive};

/// The media on both sides of a surface: pbrt's MediumInterface. `None` is vacuum. Outside is where the normal points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MediumInterface {
    /// The medium behind the normal.
    pub inside: Option<MediumId>,
    /// The medium before the normal.
    pub outside: Option<MediumId>,
}

impl MediumInterface {
    /// Vacuum on both sides.
    pub const VACUUM: Self = Self { inside: None, outside: None };

    /// Whether the two media differ.
    pub fn is_transition(&self) -> bool {
        self.inside != self.outside
    }
}

/// A place where a ray changes from one medium to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumBoundary {
    /// Where; its [`interaction`](Primitive::interaction) says whether the surface has a material too.
    pub hit: Hit,
    /// The medium that the ray leaves.
    pub from: Option<MediumId>,
    /// The medium that the ray enters.
    pub to: Option<MediumId>,
}

/// The medium boundaries that `ray` crosses within `interval`, in the order in which it crosses them.
///
/// Surfaces without a material are crossed, and so are those with one that separate two media: a renderer asks up to
/// the `t` of its hit. Of boundaries at the same `t`, the one that continues the medium before comes first, then the
/// smaller primitive. A surface that the ray meets in an edge or vertex, hence in several triangles at one `t`, counts
/// once for each direction of crossing.
pub fn medium_boundaries<P: Primitive + ?Sized>(
    primitive: &P,
    ray: &TraversalRay,
    interval: Interval,
) -> Vec<MediumBoundary> {
    let mut boundaries = Vec::new();
    let _ = primitive.visit_hits(ray, interval, HitKind::MediumTransition, &mut |hit: Hit| {
        let interaction = primitive.interaction(ray, &hit);
        if let Some(MediumInterface { inside, outside }) = interaction.media {
            let (from, to) = if interaction.is_from_inside(ray) { (inside, outside) } else { (outside, inside) };
            boundaries.push(MediumBoundary { hit, from, to });
        }
        ControlFlow::Continue(interval.t_max())
    });
    boundaries.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t).then(a.hit.primitive.cmp(&b.hit.primitive)));
    boundaries.dedup_by(|b, a| (a.hit.t, a.from, a.to) == (b.hit.t, b.from, b.to));
    order_ties(&mut boundaries);
    boundaries
}

/// Among boundaries at one `t`, moves forward the first that continues the medium before.
fn order_ties(boundaries: &mut [MediumBoundary]) {
    for i in 1..boundaries.len() {
        let previous = boundaries[i - 1];
        let ties = boundaries[i..].iter().take_while(|b| b.hit.t == boundaries[i].hit.t);
        if let Some(next) = ties.clone().position(|b| b.from == previous.to) {
            boundaries[i..=i + next].rotate_right(1);
        }
    }
}
