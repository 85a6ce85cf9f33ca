//! Materials, lights, media, and what is skipped.

use primitive::{AreaLightId, MaterialId, MediumId, MediumInterface, Surface};

use super::{TRIANGLE, refused, sound, warned};
use crate::Scene;

/// The material's and the light's name of each geometry; `None` for a boundary.
fn surfaces(scene: &Scene) -> Vec<Option<(&str, Option<&str>)>> {
    let material = |id: MaterialId| scene.names.materials[id.index() as usize].as_str();
    let light = |id: AreaLightId| scene.names.area_lights[id.index() as usize].as_str();
    let surface = |surface: Surface| match surface {
        Surface::Material { material: m, area_light } => Some((material(m), area_light.map(light))),
        Surface::MediumBoundary => None,
    };
    scene.geometries().iter().map(|g| surface(g.surface)).collect()
}

#[test]
fn materials_by_kind_and_by_name() {
    let scene = sound(&format!(
        r#"{TRIANGLE} Material "matte" "rgb Kd" [1 0 0] {TRIANGLE} {TRIANGLE}
        MakeNamedMaterial "wood" "string type" "plastic" {TRIANGLE}
        AttributeBegin NamedMaterial "wood" {TRIANGLE} AttributeEnd {TRIANGLE}
        TransformBegin NamedMaterial "wood" TransformEnd {TRIANGLE}"#
    ));
    let names: Vec<_> = surfaces(&scene).into_iter().map(|s| s.expect("a surface").0).collect();
    assert_eq!(names, ["default", "matte", "matte", "matte", "wood", "matte", "wood"]);
    assert_eq!(scene.names.materials, ["default", "matte", "wood"]);
}

#[test]
fn each_material_directive_is_one_material() {
    let scene = sound(&format!("Material \"matte\" {TRIANGLE} Material \"matte\" {TRIANGLE} Material \"unused\""));
    assert_eq!(scene.names.materials, ["matte", "matte"]);
    assert_ne!(scene.geometries()[0].surface, scene.geometries()[1].surface);
}

#[test]
fn shapes_without_a_material_are_boundaries() {
    for directives in [
        "Material \"none\"",
        "Material \"\"",
        "Material \"interface\"",
        "MakeNamedMaterial \"gap\" \"string type\" \"interface\" NamedMaterial \"gap\"",
        "MakeNamedMaterial \"gap\" \"string type\" [\"none\"] NamedMaterial \"gap\"",
    ] {
        let scene = sound(&format!("{directives} {TRIANGLE}"));
        assert_eq!(surfaces(&scene), [None], "{directives}");
        assert!(scene.names.materials.is_empty());
    }
    let scene = warned(&format!("Material \"none\" AreaLightSource \"diffuse\" {TRIANGLE}"), "is dropped");
    assert_eq!((surfaces(&scene), scene.names.area_lights.len()), (vec![None], 0));
}

#[test]
fn a_material_that_is_never_made_is_a_surface() {
    let text = format!("NamedMaterial \"wood\" {TRIANGLE} NamedMaterial \"wood\" {TRIANGLE}");
    let scene = warned(&text, "NamedMaterial \"wood\" is used before it is made");
    assert_eq!(surfaces(&scene), [Some(("wood", None)); 2]);
    assert_eq!(scene.names.materials, ["wood"]);
}

#[test]
fn each_area_light_directive_is_one_light() {
    let scene = sound(&format!(
        r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [1 1 1] {TRIANGLE} {TRIANGLE} AttributeEnd {TRIANGLE}
        AreaLightSource "area" AreaLightSource "diffuse" {TRIANGLE} AreaLightSource "" {TRIANGLE}"#
    ));
    let lights: Vec<_> = surfaces(&scene).into_iter().map(|s| s.expect("a surface").1).collect();
    assert_eq!(lights, [Some("diffuse"), Some("diffuse"), None, Some("diffuse"), None]);
    assert_eq!(scene.names.area_lights, ["diffuse", "diffuse"]);
    let [a, b, d] = [0, 1, 3].map(|i| scene.geometries()[i].surface);
    assert!(a == b && a != d);
}

#[test]
fn media_inside_and_outside() {
    let scene = sound(&format!(
        r#"MakeNamedMedium "fog" "string type" "homogeneous" MakeNamedMedium "milk"
        MediumInterface "fog" "" {TRIANGLE} MediumInterface "milk" "fog" {TRIANGLE} MediumInterface "fog" {TRIANGLE}
        AttributeBegin MediumInterface "" "" {TRIANGLE} AttributeEnd {TRIANGLE}"#
    ));
    let media: Vec<_> = scene.geometries().iter().map(|g| g.media).collect();
    let (fog, milk) = (MediumId::from_index(0), MediumId::from_index(1));
    let interface = |inside, outside| MediumInterface { inside, outside };
    let both = interface(fog, fog);
    assert_eq!(media, [interface(fog, None), interface(milk, fog), both, MediumInterface::VACUUM, both]);
    assert_eq!(scene.names.media, ["fog", "milk"]);
    warned("MediumInterface \"fog\" \"\"", "the medium \"fog\" is used but never made");
}

#[test]
fn a_reversed_sphere_swaps_its_media_and_a_mirrored_one_does_not() {
    let made = "MakeNamedMedium \"fog\" MediumInterface \"fog\" \"\"";
    let fog = MediumId::from_index(0);
    let reversed = warned(&format!("{made} ReverseOrientation Shape \"sphere\""), "ReverseOrientation of a sphere");
    assert_eq!(reversed.geometries()[0].media, MediumInterface { inside: None, outside: fog });
    let mirrored = sound(&format!("{made} Scale -1 1 1 Shape \"sphere\""));
    assert_eq!(mirrored.geometries()[0].media, MediumInterface { inside: fog, outside: None });
}

#[test]
fn what_says_nothing_about_geometry_is_skipped_with_one_warning_for_each_kind() {
    let text = format!(
        r#"Film "image" "integer xresolution" [200] "string filename" "a.exr"
        Sampler "halton" Integrator "path" PixelFilter "box" ColorSpace "srgb" Accelerator "bvh"
        Option "bool disablepixeljitter" true
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1] LightSource "point" "blackbody I" [5500 1] "spectrum x" "y.spd"
        Texture "t" "spectrum" "imagemap" "string filename" "t.png" "bool trilinear" "false"
        Attribute "shape" "float radius" 5
        {TRIANGLE}
        WorldEnd"#
    );
    let scene = warned(&text, "LightSource is not modelled: skipped");
    assert_eq!((scene.warnings.len(), scene.geometries().len()), (10, 1));
}

#[test]
fn unknown_directives_are_skipped_with_one_warning_for_each_name() {
    let text = format!(
        "Identity\n\nShap \"sphere\" \"float radius\" [ 2 ] {TRIANGLE}\n\
        qwertzuiop 1 2 [ 3 ] \"bool x\" true Shap Translat 1 0 0 {TRIANGLE}"
    );
    let scene = super::scene(&text);
    assert_eq!(scene.geometries().len(), 2);
    let skipped = "is no known directive: skipped with its parameters";
    let [shape, noise, translate] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert_eq!(*shape, format!("test.pbrt: line 3: Shap {skipped}; did you mean \"Shape\"?"));
    assert_eq!(*noise, format!("test.pbrt: line 4: qwertzuiop {skipped}"));
    assert!(translate.starts_with(&format!("test.pbrt: line 4: Translat {skipped}; did you mean \"Translate\"")));
    let many: String = (0..1000).map(|i| format!("D{i} ")).collect();
    assert_eq!(super::scene(&many).warnings.len(), 100);
}

#[test]
fn what_has_no_form_is_refused() {
    refused("Shape sphere", "a name should stand in quotes, not sphere");
    refused("Shape", "the file ends where a name should stand");
    refused("Shape \"sphere\" 3", "3 stands where a directive");
    refused("\n\u{e9}t\u{e9} 3", "line 2: \u{e9}t\u{e9} stands where a directive");
    refused("Shap \"sphere\" \"float radius\" [ 2", "line 1: the file ends within the brackets");
    refused("Shap ] Identity", "] stands where a value or a directive should stand");
    refused("\"sphere\"", "\"sphere\" stands where a directive, such as Shape, should stand");
    refused("Identity ]", "] stands where a directive");
    refused("ObjectBegin 3", "the name of an object should stand in quotes");
}

#[test]
fn every_known_directive_is_carried_out() {
    use super::super::interpreter::KNOWN;
    for directive in KNOWN {
        let scene = super::parse(directive);
        let is_known = |scene: &Scene| scene.warnings.iter().all(|w| !w.contains("is no known directive"));
        assert!(scene.as_ref().map_or(true, is_known), "{directive}");
    }
}
