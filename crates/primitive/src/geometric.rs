//! A shape with its material, light and media.

use std::ops::ControlFlow;

use geometry::{Bounds3, Hit, HitVisitor, Interval, Shape, TraversalRay, Visit};

use crate::interaction::outgoing_direction;
use crate::{HitKind, MediumInterface, Primitive, Surface, SurfaceInteraction};

/// One shape (a sphere, a mesh, a tree over a mesh) with what its surface is: pbrt's GeometricPrimitive (third edition,
/// section 4.1.1; fourth, 7.1.1). The shape stands in the primitive's own space; to put it elsewhere, wrap it in a
/// [`TransformedPrimitive`](crate::TransformedPrimitive).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometricPrimitive<S> {
    shape: S,
    surface: Surface,
    media: MediumInterface,
}

impl<S: Shape> GeometricPrimitive<S> {
    /// `shape` with `surface`, between the media `media`.
    pub const fn new(shape: S, surface: Surface, media: MediumInterface) -> Self {
        Self { shape, surface, media }
    }

    /// The shape.
    pub const fn shape(&self) -> &S {
        &self.shape
    }

    /// What the surface is.
    pub const fn surface(&self) -> Surface {
        self.surface
    }

    /// The media on both sides.
    pub const fn media(&self) -> MediumInterface {
        self.media
    }

    fn takes_part(&self, kind: HitKind) -> bool {
        match kind {
            HitKind::Material => self.surface.has_material(),
            HitKind::MediumTransition => self.media.is_transition(),
        }
    }
}

impl<S: Shape> Primitive for GeometricPrimitive<S> {
    fn world_bound(&self) -> Bounds3 {
        self.shape.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.shape.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, kind: HitKind, visitor: &mut dyn HitVisitor) -> Visit {
        if self.takes_part(kind) {
            self.shape.visit_hits(ray, interval, visitor)
        } else {
            ControlFlow::Continue(interval.t_max())
        }
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        if self.surface.has_material() { self.shape.intersect(ray, interval) } else { None }
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.surface.has_material() && self.shape.intersect_p(ray, interval)
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        SurfaceInteraction {
            point: self.shape.surface_point(ray, hit),
            time: ray.time(),
            wo: outgoing_direction(ray),
            surface: self.surface,
            media: self.media.is_transition().then_some(self.media),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MaterialId, MediumId};
    use geometry::glam::Vec3;
    use geometry::{Ray, Sphere};

    fn sphere(surface: Surface, media: MediumInterface) -> GeometricPrimitive<Sphere> {
        GeometricPrimitive::new(Sphere::new(Vec3::new(0.0, 0.0, 5.0), 1.0).expect("valid"), surface, media)
    }

    fn material() -> Surface {
        Surface::of_material(MaterialId::from_index(3).expect("has an id"))
    }

    #[test]
    fn only_surfaces_with_a_material_are_hit() {
        let ray = TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).expect("valid");
        let fog = MediumInterface { inside: MediumId::from_index(0), outside: None };
        for (surface, media, hit, boundaries) in [
            (material(), MediumInterface::VACUUM, true, 0),
            (material(), fog, true, 2),
            (Surface::MediumBoundary, fog, false, 2),
            (Surface::MediumBoundary, MediumInterface::VACUUM, false, 0),
        ] {
            let p = sphere(surface, media);
            assert_eq!(p.intersect(&ray, Interval::FULL).is_some(), hit);
            assert_eq!(p.intersect_p(&ray, Interval::FULL), hit);
            let mut count = 0;
            let _ = p.visit_hits(&ray, Interval::FULL, HitKind::MediumTransition, &mut |_: Hit| {
                count += 1;
                ControlFlow::Continue(f32::INFINITY)
            });
            assert_eq!(count, boundaries);
        }
    }

    #[test]
    fn an_interaction_has_media_only_where_they_differ() {
        let ray = TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 2.0])).expect("valid");
        let p = sphere(material(), MediumInterface { inside: MediumId::from_index(1), outside: None });
        let hit = p.intersect(&ray, Interval::FULL).expect("ahead");
        let i = p.interaction(&ray, &hit);
        assert_eq!(i.p(), Vec3::new(0.0, 0.0, 4.0));
        assert_eq!((i.n(), i.wo), (Vec3::NEG_Z, Vec3::NEG_Z));
        assert_eq!(i.media, Some(p.media()));
        assert_eq!(i.surface, material());
        let same = MediumInterface { inside: MediumId::from_index(1), outside: MediumId::from_index(1) };
        assert_eq!(sphere(material(), same).interaction(&ray, &hit).media, None);
    }
}
