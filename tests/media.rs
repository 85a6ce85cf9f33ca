//! The way of a ray through the media, through trees and instances.

use std::sync::Arc;

use bvh_flat::geometry::glam::{DVec3, Vec3};
use bvh_flat::geometry::{Interval, Ray, Sphere, Transform, TraversalRay};
use bvh_flat::primitive::{
    GeometricPrimitive, MaterialId, MediumId, MediumInterface, Primitive, Surface, TransformedPrimitive,
    medium_boundaries,
};
use bvh_flat::{BuildConfig, BvhAggregate, SplitMethod};

fn medium(i: u32) -> Option<MediumId> {
    MediumId::from_index(i)
}

fn ball(z: f32, radius: f32, surface: Surface, inside: u32, outside: Option<u32>) -> GeometricPrimitive<Sphere> {
    let sphere = Sphere::new(Vec3::new(0.0, 0.0, z), radius).expect("a sphere");
    let media = MediumInterface { inside: medium(inside), outside: outside.and_then(medium) };
    GeometricPrimitive::new(sphere, surface, media)
}

/// A cloud with a glass ball in it, and an opaque ball behind: five boundaries and one hit that ends the way.
fn scene() -> Vec<GeometricPrimitive<Sphere>> {
    let glass = Surface::of_material(MaterialId::from_index(0).expect("an id"));
    vec![
        ball(10.0, 4.0, Surface::MediumBoundary, 0, None),
        ball(10.0, 1.0, glass, 1, Some(0)),
        ball(20.0, 1.0, Surface::MediumBoundary, 2, None),
    ]
}

fn along_z() -> TraversalRay {
    TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).expect("valid")
}

#[test]
fn boundaries_come_in_order_with_the_media_on_both_sides() {
    let expected = [
        (6.0, None, medium(0)),
        (9.0, medium(0), medium(1)),
        (11.0, medium(1), medium(0)),
        (14.0, medium(0), None),
        (19.0, None, medium(2)),
        (21.0, medium(2), None),
    ];
    for method in SplitMethod::ALL {
        let world = BvhAggregate::build(scene(), &BuildConfig::new(method)).expect("the configuration is valid");
        let seen: Vec<_> =
            medium_boundaries(&world, &along_z(), Interval::FULL).iter().map(|b| (b.hit.t, b.from, b.to)).collect();
        assert_eq!(seen, expected);
        let before_glass = medium_boundaries(&world, &along_z(), Interval::up_to(9.5));
        assert_eq!(before_glass.len(), 2);
    }
}

#[test]
fn only_the_glass_is_hit() {
    let world = BvhAggregate::build(scene(), &BuildConfig::default()).expect("the configuration is valid");
    let hit = world.intersect(&along_z(), Interval::FULL).expect("the glass is ahead");
    assert_eq!((hit.t, hit.primitive), (9.0, 1));
    let interaction = world.interaction(&along_z(), &hit);
    assert_eq!(interaction.media, Some(MediumInterface { inside: medium(1), outside: medium(0) }));
    assert!(!world.intersect_p(&along_z(), Interval::new(11.5, 100.0)), "a boundary without a material blocks nothing");
    assert!(world.intersect_p(&along_z(), Interval::up_to(9.5)));
}

/// A mirrored and scaled instance keeps its inside inside.
#[test]
fn boundaries_of_instances_are_where_the_instances_are() {
    let object = Arc::new(BvhAggregate::build(scene(), &BuildConfig::default()).expect("the configuration is valid"));
    let place = Transform::translate(DVec3::new(0.0, 0.0, 100.0))
        .and_then(|t| t.then_inside(&Transform::scale(DVec3::new(2.0, 2.0, -2.0))?))
        .expect("invertible");
    let world = TransformedPrimitive::new(object, place);
    // Mirrored along z: what was at z now is at 100 − 2z, so the ray comes from behind.
    let seen: Vec<_> =
        medium_boundaries(&world, &along_z(), Interval::FULL).iter().map(|b| (b.hit.t, b.from, b.to)).collect();
    assert_eq!(
        seen,
        [
            (58.0, None, medium(2)),
            (62.0, medium(2), None),
            (72.0, None, medium(0)),
            (78.0, medium(0), medium(1)),
            (82.0, medium(1), medium(0)),
            (88.0, medium(0), None),
        ]
    );
}
