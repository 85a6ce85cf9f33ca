//! Small maps, and what must become of points, normals, rays and boxes under them.

use super::*;
use crate::Ray;

#[test]
fn what_cannot_be_inverted_is_refused() {
    assert!(matches!(Transform::scale(DVec3::new(1.0, 0.0, 1.0)), Err(TransformError::Singular { .. })));
    assert!(matches!(Transform::scale(DVec3::new(1.0, f64::NAN, 1.0)), Err(TransformError::NotFinite)));
    let rank_one = [[1.0, 2.0, 3.0, 0.0], [2.0, 4.0, 6.0, 0.0], [3.0, 6.0, 9.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    assert!(matches!(Transform::from_rows(rank_one), Err(TransformError::Singular { .. })));
    let projective = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    assert!(matches!(Transform::from_rows(projective), Err(TransformError::NotAffine(_))));
    assert!(Transform::scale(DVec3::new(1e-6, 1.0, 1e6)).is_ok());
    assert!(Transform::scale(DVec3::splat(1e-100)).is_ok());
}

#[test]
fn quarter_turns_mirrors_and_powers_of_two_are_exact() {
    let t = Transform::rotate(90.0, DVec3::Z).expect("valid");
    assert_eq!(t.point(DVec3::X), DVec3::Y);
    let t = Transform::scale(DVec3::new(-2.0, 0.5, 1024.0)).expect("valid");
    assert_eq!(t.inverse().point(t.point(DVec3::new(0.1, 0.2, 0.3))), DVec3::new(0.1, 0.2, 0.3));
    assert!(t.swaps_handedness());
}

#[test]
fn composition_and_inverse() {
    let t = Transform::translate(DVec3::new(1.0, 2.0, 3.0)).expect("valid");
    let r = Transform::rotate(30.0, DVec3::new(1.0, 1.0, 0.0)).expect("valid");
    let tr = t.then_inside(&r).expect("valid");
    let p = DVec3::new(0.3, -0.4, 0.5);
    assert!((tr.point(p) - t.point(r.point(p))).length() < 1e-14);
    assert!((tr.inverse().point(tr.point(p)) - p).length() < 1e-14);
}

#[test]
fn t_means_the_same_in_both_spaces() {
    let t = Transform::scale(DVec3::splat(4.0)).expect("valid");
    let world = TraversalRay::new(&Ray::new([8.0, 0.0, 0.0], [-1.0, 0.0, 0.0])).expect("valid");
    let object = t.ray_to_object(&world).expect("valid");
    assert_eq!(object.ray().origin, Vec3::new(2.0, 0.0, 0.0));
    assert_eq!(object.ray().direction, Vec3::new(-0.25, 0.0, 0.0));
}

#[test]
fn normals_keep_their_side_when_mirrored() {
    let t = Transform::scale(DVec3::new(-1.0, 2.0, 3.0)).expect("valid");
    let (p, n) = (DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, 1.0, 0.0));
    let outside = t.point(p + 1e-3 * n) - t.point(p);
    assert!(t.normal(n).dot(outside) > 0.0);
}

#[test]
fn look_at_is_pbrts() {
    let t = Transform::look_at(DVec3::new(0.0, 0.0, -5.0), DVec3::ZERO, DVec3::Y).expect("valid");
    assert_eq!(t.point(DVec3::ZERO), DVec3::new(0.0, 0.0, 5.0));
    assert!(Transform::look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_err());
}

#[test]
fn bounds_contain_the_image_of_every_corner() {
    let b = Bounds3::new(Vec3::new(-1.3, 0.1, 2.7), Vec3::new(4.1, 0.3, 9.9));
    for i in 0..100 {
        let axis = DVec3::new(1.0, f64::from(i) * 0.1, -0.5);
        let r = Transform::rotate(f64::from(i) * 7.3, axis).expect("valid");
        let t = Transform::translate(DVec3::new(1e5, -3.0, 1e-3)).expect("valid").then_inside(&r).expect("valid");
        let image = t.bounds(&b);
        for c in b.corners() {
            let p = t.point(c.as_dvec3());
            assert!(p.cmpge(image.min.as_dvec3()).all() && p.cmple(image.max.as_dvec3()).all());
        }
    }
    assert!(Transform::IDENTITY.bounds(&Bounds3::EMPTY).is_empty());
    assert!(Transform::IDENTITY.bounds(&b).contains(&b));
}
