//! Transforms, blocks, objects and the camera.

use geometry::glam::{DVec3, Vec3};
use primitive::Placement;

use super::{TRIANGLE, first_normal, first_triangle, mesh, refused, scene, sound, warned};
use crate::{Camera, ObjectId};

/// Where the origin, and (1, 0, 0), go under `directives`.
fn images(directives: &str) -> [Vec3; 2] {
    let [origin, x, _] = first_triangle(&sound(&format!("{directives} {TRIANGLE}")));
    [origin, x]
}

#[test]
fn transforms_compose_in_the_order_of_the_file() {
    for (directives, origin, x) in [
        ("", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ("Translate 1 2 3", [1.0, 2.0, 3.0], [2.0, 2.0, 3.0]),
        ("Translate [1 2 3] Scale 2 2 2", [1.0, 2.0, 3.0], [3.0, 2.0, 3.0]),
        ("Scale 2 2 2 Translate 1 2 3", [2.0, 4.0, 6.0], [4.0, 4.0, 6.0]),
        ("Rotate 90 0 0 1", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ("Translate 1 2 3 Identity", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        // The columns of the matrix: x goes to y, y to z, z to x; then the translation.
        ("Transform [0 1 0 0  0 0 1 0  1 0 0 0  7 8 9 1]", [7.0, 8.0, 9.0], [7.0, 9.0, 9.0]),
        ("Translate 1 0 0 Transform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1]", [7.0, 8.0, 9.0], [8.0, 8.0, 9.0]),
        ("Translate 1 0 0 ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1]", [8.0, 8.0, 9.0], [9.0, 8.0, 9.0]),
        ("LookAt 0 0 -5  0 0 0  0 1 0", [0.0, 0.0, 5.0], [1.0, 0.0, 5.0]),
        ("Translate 1 0 0 CoordinateSystem \"a\" Identity CoordSysTransform \"a\"", [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]),
        ("Translate 1 0 0 WorldBegin", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ("WorldBegin Translate 1 0 0 CoordSysTransform \"world\"", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ("AttributeBegin Translate 1 0 0 AttributeEnd", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ("TransformBegin Translate 1 0 0 TransformEnd", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ] {
        assert_eq!(images(directives), [origin, x].map(Vec3::from), "{directives}");
    }
    let camera = "LookAt 0 0 -5  0 0 0  0 1 0 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\"";
    assert_eq!(images(camera)[0], Vec3::new(0.0, 0.0, -5.0));
}

#[test]
fn vertices_are_rounded_once() {
    let [origin, x] =
        images("Translate 1e9 0 0 Scale 1e-9 1e-9 1e-9 Translate 0 0.1 0 Scale 1e9 1e9 1e9 Translate -1 0 0");
    assert_eq!((origin, x), (Vec3::new(1e9, 1e-10, 0.0) - Vec3::X, Vec3::new(1e9, 1e-10, 0.0)));
}

#[test]
fn a_mirroring_keeps_the_outside_and_reverse_orientation_swaps_it() {
    for (directives, outside) in [
        ("", Vec3::Z),
        ("Scale -1 1 1", Vec3::Z),
        ("Scale 1 1 -1", Vec3::NEG_Z),
        ("Scale -1 -1 1", Vec3::Z),
        ("ReverseOrientation", Vec3::NEG_Z),
        ("ReverseOrientation ReverseOrientation", Vec3::Z),
        ("ReverseOrientation Scale -1 1 1", Vec3::NEG_Z),
        ("AttributeBegin ReverseOrientation AttributeEnd", Vec3::Z),
        ("TransformBegin ReverseOrientation TransformEnd", Vec3::NEG_Z),
    ] {
        assert_eq!(first_normal(&sound(&format!("{directives} {TRIANGLE}"))), outside, "{directives}");
    }
}

#[test]
fn what_is_no_transform_is_refused_at_its_line() {
    refused("\nScale 1 0 1", "line 2: Scale: the matrix is singular");
    refused("Translate 0 nan 0", "line 1: Translate: the matrix has an entry that is not finite");
    refused("Translate 1e400 0 0", "not finite");
    refused("Rotate 30 0 0 0", "line 1: Rotate: the axis has no length");
    refused("LookAt 1 1 1  1 1 1  0 1 0", "line 1: LookAt: it looks at where it stands");
    refused("Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2]", "the last row of the matrix must be 0 0 0 1");
    refused("Translate 1 2", "the file ends where the 3 numbers of Translate should stand");
    refused("Translate 1 2 Shape", "Shape stands where the 3 numbers of Translate should stand");
    refused("Scale [1 2 3 4]", "Scale takes 3 numbers, and there are more in the brackets");
    refused("CoordinateSystem \"left\" CoordSysTransform \"lift\"", "system \"lift\"; did you mean \"left\"?");
    refused("ActiveTransform Both", "ActiveTransform takes All, StartTime or EndTime, not Both");
}

#[test]
fn what_begins_must_end() {
    refused("\nAttributeEnd", "line 2: AttributeEnd ends nothing");
    refused("\nAttributeBegin\n", "line 2: the AttributeBegin here is never ended");
    refused(
        "AttributeBegin\nTransformEnd",
        "line 2: TransformEnd stands where the AttributeBegin of line 1 should end",
    );
    refused("ObjectBegin \"a\" AttributeBegin ObjectEnd", "should end");
    refused("ObjectBegin \"a\" ObjectBegin \"b\"", "ObjectBegin \"b\" stands within the object \"a\"");
    refused(&"AttributeBegin ".repeat(20_000), "AttributeBegin nests deeper than 10000");
}

#[test]
fn objects_are_placed_by_the_transform_at_the_instance() {
    let scene = sound(&format!(
        r#"WorldBegin
        Translate 100 0 0
        ObjectBegin "tree" Translate 1 0 0 {TRIANGLE} ObjectEnd
        Identity
        AttributeBegin Translate 0 7 0 ObjectInstance "tree" AttributeEnd
        Scale 2 2 2 ObjectInstance "tree""#
    ));
    let [world, tree] = scene.objects() else { panic!("{:?}", scene.objects()) };
    assert_eq!((tree.name.as_str(), tree.geometries.as_slice(), tree.instances.len()), ("tree", &[0][..], 0));
    assert!(world.geometries.is_empty());
    assert_eq!(first_triangle(&scene)[0], Vec3::new(101.0, 0.0, 0.0));
    let images: Vec<DVec3> = world.instances.iter().map(|i| i.placement.at(0.0).point(DVec3::X)).collect();
    assert_eq!(images, [DVec3::new(1.0, 7.0, 0.0), DVec3::new(2.0, 0.0, 0.0)]);
    assert!(world.instances.iter().all(|i| i.object.index() == 1));
}

#[test]
fn instances_nest_but_not_in_a_circle_or_before_their_object() {
    let nested = format!(
        r#"ObjectBegin "leaf" {TRIANGLE} ObjectEnd ObjectBegin "tree" ObjectInstance "leaf" ObjectEnd ObjectInstance "tree""#
    );
    let scene = sound(&nested);
    assert_eq!(scene.objects()[2].instances[0].object.index(), 1);
    assert_eq!(scene.world().instances[0].object.index(), 2);
    refused("ObjectBegin \"a\" ObjectInstance \"a\"", "object \"a\" is used inside of its own definition");
    let text = "ObjectBegin \"tree1\" ObjectEnd ObjectBegin \"tree2\" ObjectEnd\nObjectInstance \"tree\"";
    refused(
        text,
        "line 2: ObjectInstance: there is no object \"tree\" before this line; did you mean \"tree1\" or \"tree2\"?",
    );
    let scene = warned("ObjectBegin \"a\" ObjectEnd ObjectBegin \"a\" ObjectEnd ObjectInstance \"a\"", "defined again");
    assert_eq!(scene.world().instances[0].object.index(), 2);
}

#[test]
fn active_transforms_and_times_make_motion() {
    let moving = "TransformTimes 0.5 1.5 Translate 1 0 0 ActiveTransform EndTime Translate 0 4 0 ActiveTransform All";
    let scene = sound(&format!("{moving} Scale 2 2 2 {TRIANGLE} ObjectBegin \"a\" ObjectEnd ObjectInstance \"a\""));
    assert_eq!(mesh(&scene.geometries()[0]).positions()[1], Vec3::X, "in its own space");
    assert!(scene.world().geometries.is_empty());
    let [shape, instance] = scene.world().instances.as_slice() else { panic!("two things move") };
    assert_eq!(scene.objects()[shape.object.index()].geometries, [0]);
    for placement in [&shape.placement, &instance.placement] {
        assert!(matches!(placement, Placement::Animated(_)));
        assert_eq!(placement.at(0.5).point(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
        assert_eq!(placement.at(1.5).point(DVec3::X), DVec3::new(3.0, 4.0, 0.0));
        let half = placement.at(1.0).point(DVec3::X);
        assert!((half - DVec3::new(3.0, 2.0, 0.0)).length() < 1e-12, "{half}");
    }
    let still = scene_of_equal_motions();
    assert_eq!(still.world().geometries, [0]);
}

#[test]
fn motion_that_makes_no_sense_is_refused_at_its_line() {
    let moving = "ActiveTransform EndTime Translate 0 4 0\n";
    refused(&format!("TransformTimes 1 0 {moving}{TRIANGLE}"), "line 2: the transform between StartTime and EndTime: ");
    refused(
        &format!("TransformTimes 0 nan {moving}{TRIANGLE}"),
        "line 2: the transform between StartTime and EndTime: ",
    );
}

/// Start and end are moved apart, and together again.
fn scene_of_equal_motions() -> crate::Scene {
    let apart = "ActiveTransform StartTime Translate 1 0 0 ActiveTransform EndTime Translate 1 0 0";
    sound(&format!("{apart} {TRIANGLE}"))
}

#[test]
fn the_world_begins_with_all_transforms_active_and_blocks_keep_which() {
    let scene = sound(&format!("ActiveTransform EndTime WorldBegin Translate 1 0 0 {TRIANGLE}"));
    assert_eq!(first_triangle(&scene)[0], Vec3::X);
    let scene = sound(&format!("TransformBegin ActiveTransform EndTime TransformEnd Translate 1 0 0 {TRIANGLE}"));
    assert_eq!(first_triangle(&scene)[0], Vec3::X);
}

#[test]
fn an_object_of_moving_shapes_is_placed_as_one() {
    let scene = sound(&format!(
        "ObjectBegin \"a\" ActiveTransform EndTime Translate 1 0 0 {TRIANGLE} ObjectEnd ObjectInstance \"a\""
    ));
    let [world, a, shape] = scene.objects() else { panic!("{:?}", scene.objects()) };
    assert_eq!((a.instances[0].object.index(), world.instances[0].object), (2, a_id(&scene)));
    assert_eq!(shape.geometries, [0]);
}

fn a_id(scene: &crate::Scene) -> ObjectId {
    scene.world().instances[0].object
}

#[test]
fn cameras_see_what_pbrts_see() {
    let text = r#"LookAt 3 4 5  1 0 -2  0.2 1 0.1
        Camera "perspective" "float fov" 40 "float shutteropen" 0.25 "float shutterclose" [0.75]"#;
    for (mirror, left_handed) in [("", true), ("Scale -1 1 1 ", false)] {
        let camera = sound(&format!("{mirror}{text}")).camera.expect("it has one");
        assert_eq!((camera.fov, camera.shutter, camera.left_handed), (40.0, [0.25, 0.75], left_handed));
        let written = Camera { eye: [3.0, 4.0, 5.0], look: [1.0, 0.0, -2.0], up: [0.2, 1.0, 0.1], ..camera };
        for (x, y) in [(0.0, 0.0), (30.0, 7.0)] {
            let [a, b] = [camera, written].map(|c| c.view(40, 30).expect("valid").ray(x, y, 0.5));
            assert!((a.direction - b.direction).length() < 1e-6 && (a.origin - b.origin).length() < 1e-6);
            assert_eq!(a.time, 0.5);
        }
    }
}

#[test]
fn a_far_camera_keeps_its_direction() {
    let text = "LookAt 367041 5661510 2878300  367042 5661509.5 2878300.25  0 1 0 Camera \"perspective\"";
    let view = sound(text).camera.expect("it has one").view(2, 2).expect("valid");
    let expected = Vec3::new(1.0, -0.5, 0.25).normalize();
    assert!((view.ray(1.0, 1.0, 0.0).direction - expected).length() < 1e-6);
}

#[test]
fn what_cameras_cannot_do_is_said() {
    assert_eq!(sound("Camera \"perspective\"").camera.expect("it has one").fov, 90.0);
    assert_eq!(sound("Camera \"perspective\" \"float halffov\" 20").camera.expect("it has one").fov, 40.0);
    assert_eq!(warned("Camera \"realistic\"", "only \"perspective\"").camera, None);
    warned("Camera \"perspective\" \"float screenwindow\" [-1 1 -1 1]", "the parameter \"screenwindow\" is ignored");
    warned("Scale 1 2 1 Camera \"perspective\"", "the camera's transform distorts");
    let moving = warned("ActiveTransform EndTime Translate 0 0 9 Camera \"perspective\"", "the camera moves");
    assert_eq!(moving.camera.expect("it has one").eye, [0.0; 3]);
    refused("\nCamera \"perspective\" \"float fov\" 200", "line 2: Camera \"perspective\": the camera's fov must lie");
    refused("Camera \"perspective\" \"float shutteropen\" 2", "closes at 1, before it opens at 2");
    assert_eq!(scene("").camera, None);
}
