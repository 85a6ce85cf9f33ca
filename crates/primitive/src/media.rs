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

    /// Whether the two media differ: only then is the surface a boundary.
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
/// once for each pair of media. A ray that runs along a surface is taken to come from outside. Empty where the interval
/// is, or the ray is in one medium all the way: in which one is for the caller to know, as pbrt's rays do. It is that
/// of the camera or, of a spawned ray, that side of the surface's [`media`](crate::SurfaceInteraction::media) which it
/// leaves to; where the surface has none, that which the ray before was in.
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
    let mut ordered: Vec<MediumBoundary> = Vec::with_capacity(boundaries.len());
    for ties in boundaries.chunk_by(|a, b| a.hit.t == b.hit.t) {
        push_chain(&mut ordered, ties);
    }
    ordered
}

/// Adds boundaries at one `t`, each pair of media once, such that each continues the medium before where one does. The
/// first of all begins in a medium into which no other of them leads, which is where the ray comes from.
fn push_chain(ordered: &mut Vec<MediumBoundary>, ties: &[MediumBoundary]) {
    let mut left: Vec<MediumBoundary> = Vec::with_capacity(ties.len());
    for tie in ties {
        if !left.iter().any(|other| (other.from, other.to) == (tie.from, tie.to)) {
            left.push(*tie);
        }
    }
    while !left.is_empty() {
        let next = match ordered.last() {
            Some(previous) => left.iter().position(|b| b.from == previous.to),
            None => left.iter().position(|b| left.iter().all(|other| other.to != b.from)),
        };
        ordered.push(left.remove(next.unwrap_or(0)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GeometricPrimitive, PrimitiveList, Surface};
    use geometry::glam::Vec3;
    use geometry::{Ray, Sphere, TriangleMesh};

    fn media(inside: u32, outside: Option<u32>) -> MediumInterface {
        MediumInterface { inside: MediumId::from_index(inside), outside: outside.and_then(MediumId::from_index) }
    }

    fn ways(primitive: &impl Primitive, origin: Vec3) -> Vec<(Option<u32>, Option<u32>)> {
        let ray = TraversalRay::new(&Ray::new(origin, Vec3::Z)).expect("valid");
        let index = |id: Option<MediumId>| id.map(MediumId::index);
        medium_boundaries(primitive, &ray, Interval::FULL).iter().map(|b| (index(b.from), index(b.to))).collect()
    }

    /// Two equal spheres, the inner medium within the outer: in whatever order they stand, the way is a chain.
    #[test]
    fn boundaries_at_one_place_make_a_chain_in_any_order() {
        let sphere = Sphere::new(Vec3::new(0.0, 0.0, 5.0), 1.0).expect("valid");
        let make = |m| GeometricPrimitive::new(sphere, Surface::MediumBoundary, m);
        let shells = [make(media(1, Some(0))), make(media(0, None))];
        for order in [[0, 1], [1, 0]] {
            let list = PrimitiveList::new(order.map(|i| shells[i]).to_vec());
            let expected = [(None, Some(0)), (Some(0), Some(1)), (Some(1), Some(0)), (Some(0), None)];
            assert_eq!(ways(&list, Vec3::ZERO), expected);
        }
    }

    /// A ray through a vertex of a closed surface meets many triangles there, and crosses once.
    #[test]
    fn a_vertex_is_crossed_once() {
        let corners = [Vec3::NEG_Z, Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z];
        let ring = [[1, 2], [2, 3], [3, 4], [4, 1]];
        let below = ring.map(|[a, b]| [0, b, a]);
        let above = ring.map(|[a, b]| [5, a, b]);
        let mesh = TriangleMesh::new(corners.to_vec(), [below, above].concat()).expect("indices are in range");
        let octahedron = GeometricPrimitive::new(mesh, Surface::MediumBoundary, media(3, None));
        assert_eq!(ways(&octahedron, Vec3::new(0.0, 0.0, -5.0)), [(None, Some(3)), (Some(3), None)]);
    }
}
