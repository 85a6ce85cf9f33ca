//! Shapes.

use geometry::glam::{DVec3, Vec2, Vec3};

use super::{TRIANGLE, first_triangle, mesh, refused, scene, sound, sphere, warned};

#[test]
fn meshes_in_either_dialect() {
    let v3 = r#"Shape "trianglemesh" "integer indices" [0 1 2 2 1 3]
        "point P" [0 0 0  1 0 0  0 1 0  1 1 0] "float st" [0 0 1 0 0 1 1 1]"#;
    let v4 = r#"Shape "trianglemesh" "point2 uv" [0 0 1 0 0 1 1 1] # the same
        "point3 P" [0 0 0  1 0 0  0 1 0  1 1 0]"integer indices"[0 1 2 2 1 3]"#;
    for text in [v3, v4] {
        let scene = sound(text);
        let mesh = mesh(&scene.geometries()[0]);
        assert_eq!(mesh.triangles(), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(mesh.positions()[3], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.uvs(), Some(&[Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE][..]));
    }
    let single = sound("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
    assert_eq!(mesh(&single.geometries()[0]).triangles(), [[0, 1, 2]]);
}

#[test]
fn a_subdivision_surface_is_its_cage() {
    let text = r#"Shape "loopsubdiv" "integer nlevels" [1] "integer indices" [0 1 2] "point P" [0 0 0 1 0 0 0 1 0]"#;
    let scene = warned(text, "not subdivided");
    assert_eq!((scene.triangle_count(), scene.warnings.len()), (1, 1));
}

#[test]
fn meshes_that_make_no_sense_are_refused() {
    let mesh = |rest: &str| format!("\nShape \"trianglemesh\" {rest}");
    refused(&mesh(""), "line 2: Shape \"trianglemesh\": the parameter P is missing");
    refused(&mesh("\"point P\" [0 0 0 1 1 1]"), "the parameter indices is missing");
    refused(&mesh("\"point P\" [0 0 0 1] \"integer indices\" []"), "P has 4 numbers, not three for each point");
    refused(
        &mesh("\"point P\" [0 0 0] \"integer indices\" [0 0]"),
        "indices has 2 numbers, not three for each triangle",
    );
    refused(
        &mesh("\"point P\" [0 0 0] \"integer indices\" [0 0 1]"),
        "line 2: Shape \"trianglemesh\": triangle 0 uses vertex 1",
    );
    refused(&mesh("\"point P\" [0 0 0] \"integer indices\" [0 0 -1]"), "indices: -1 is no index");
    refused(&mesh("\"point P\" [0 0 0] \"integer indices\" [0 0 0.5]"), "indices: 0.5 is no index");
    refused(&mesh("\"point P\" [0 0 0] \"integer indices\" [0 0 1e99]"), "is no index");
    refused(&mesh("\"point P\" [0 0 0] \"integer indices\" [0 0 nan]"), "NaN is no index");
    refused(&mesh("\"float P\" [0 0 0]"), "P must be of type point3 or point, not float");
    refused(&mesh("\"point P\" [\"a\"]"), "P must be numbers");
    refused(&mesh("\"point P\" [0 \"a\"]"), "mixes numbers and strings");
    refused(&mesh("\"point P\" [0 Shape"), "Shape stands where a value should stand");
    refused(&mesh("\"point P\" [0\n"), "line 2: the file ends within the parameter that begins here");
    refused(&mesh("\"point P\" ]"), "] stands where a value should stand");
    refused(&mesh("\"P\" [0]"), "\"P\" is no parameter, which reads like");
    refused(&mesh("\"a b c\" [0]"), "\"a b c\" is no parameter");
}

#[test]
fn odd_coordinates_are_kept_and_told_of() {
    let text = r#"Shape "trianglemesh" "point P" [nan 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]"#;
    assert!(first_triangle(&warned(text, "1 triangles have a coordinate that is NaN"))[0].is_nan());
}

#[test]
fn spheres_go_into_the_world_where_they_stay_spheres() {
    for (directives, center, radius) in [
        ("", [0.0, 0.0, 0.0], 2.0),
        ("Translate 1 2 3", [1.0, 2.0, 3.0], 2.0),
        ("Translate 1 2 3 Scale 4 4 4 Rotate 30 1 2 3 Translate 0 0 0", [1.0, 2.0, 3.0], 8.0),
        ("Scale -3 3 3 Translate 1 0 0", [-3.0, 0.0, 0.0], 6.0),
    ] {
        let scene = sound(&format!("{directives} Shape \"sphere\" \"float radius\" 2"));
        let sphere = sphere(&scene.geometries()[0]);
        assert_eq!((sphere.center(), sphere.radius()), (Vec3::from(center), radius), "{directives}");
        assert_eq!(scene.world().geometries, [0]);
    }
    assert_eq!(sphere(&sound("Shape \"sphere\"").geometries()[0]).radius(), 1.0);
}

#[test]
fn spheres_that_become_ellipsoids_or_move_are_instanced() {
    for directives in
        ["Scale 1 2 1", "Scale 1 1 1.00001", "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All"]
    {
        let scene = sound(&format!("Translate 5 0 0 {directives} Shape \"sphere\" \"float radius\" 2"));
        assert_eq!((sphere(&scene.geometries()[0]).center(), scene.objects().len()), (Vec3::ZERO, 2), "{directives}");
        assert_eq!(scene.objects()[1].geometries, [0]);
        let instance = &scene.world().instances[0];
        assert_eq!(instance.placement.at(0.0).point(DVec3::ZERO), DVec3::new(5.0, 0.0, 0.0));
    }
}

#[test]
fn spheres_that_make_no_sense_are_refused_and_parts_of_them_are_whole() {
    refused("Shape \"sphere\" \"float radius\" 0", "radius must be positive and finite, not 0");
    refused("Shape \"sphere\" \"float radius\" nan", "radius must be positive");
    refused("Shape \"sphere\" \"float radius\" []", "radius must be one number, not 0");
    refused("Shape \"sphere\" \"string radius\" \"1\"", "radius must be of type float, not string");
    refused("Translate 1e300 0 0 Shape \"sphere\"", "center must be finite");
    for part in ["\"float zmin\" 0", "\"float zmax\" [0.5]", "\"float phimax\" 180"] {
        warned(&format!("Shape \"sphere\" {part}"), "a part of a sphere");
    }
    sound("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -2 \"float zmax\" 2 \"float phimax\" 360");
}

#[test]
fn other_shapes_and_parameters_are_skipped_with_one_warning_for_each_kind() {
    let text = "Shape \"disk\" \"float height\" 1 Shape \"curve\" \"point3 P\" [0 0 0] Shape \"disk\" ";
    let scene = warned(&format!("{text}{TRIANGLE}"), "Shape \"disk\" is not known: skipped, 2 in all");
    assert_eq!((scene.warnings.len(), scene.geometries().len()), (2, 1));
    let normals = format!("{TRIANGLE} \"normal N\" [0 0 1 0 0 1 0 0 1] {TRIANGLE} \"normal N\" [0 0 1 0 0 1 0 0 1]");
    warned(&normals, "Shape \"trianglemesh\": the parameter \"N\" is ignored");
    warned(&format!("{TRIANGLE} \"float uv\" [0 0]"), "a mesh's uv are ignored");
}

#[test]
fn warnings_are_not_without_end() {
    let text: String = (0..1000).map(|i| format!("Shape \"kind{i}\" Shape \"sphere\" \"float p{i}\" 0 ")).collect();
    assert_eq!(scene(&text).warnings.len(), 100);
}
