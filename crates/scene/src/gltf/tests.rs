mod damage;
mod reference;

use geometry::TriangleMesh;
use geometry::glam::{Vec2, Vec3};

use super::*;
use crate::ply::tests::assert_robust;
use crate::{SceneShape, load};

fn read(bytes: &[u8]) -> Result<Scene, LoadError> {
    parse(Path::new("test.glb"), bytes)
}

fn glb(json: &str, data: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8], bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), b' ');
        [&(bytes.len() as u32).to_le_bytes()[..], kind, &bytes].concat()
    };
    let chunks = [chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", data), chunk(b"ELSE", b"abcd")].concat();
    [b"glTF", &2_u32.to_le_bytes()[..], &(12 + chunks.len() as u32).to_le_bytes()[..], &chunks].concat()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Five corners of a fan, 60 bytes; their texture coordinates as normalised bytes, 20 bytes with the gaps between them;
/// and the indices 0 to 5 and 0, 2, 4 in 8, 16 and 32 bits.
fn data() -> Vec<u8> {
    let mut data = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0., -1., 1., 0.]);
    data.extend((0..5).flat_map(|i| [i * 51, 255 - i * 51, 9, 9]));
    data.extend([0, 1, 2, 0, 2, 4]);
    data.extend([0, 0]);
    data.extend([0_u16, 1, 2, 0, 2, 4].iter().flat_map(|i| i.to_le_bytes()));
    data.extend([0_u32, 1, 2, 0, 2, 4].iter().flat_map(|i| i.to_le_bytes()));
    data
}

const VIEWS: &str = r#""buffers": [{"byteLength": 124}], "bufferViews": [
    {"buffer": 0, "byteLength": 60},
    {"buffer": 0, "byteOffset": 60, "byteLength": 20, "byteStride": 4},
    {"buffer": 0, "byteOffset": 80, "byteLength": 44}], "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5121, "normalized": true, "count": 5, "type": "VEC2"},
    {"bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR"},
    {"bufferView": 2, "byteOffset": 8, "componentType": 5123, "count": 6, "type": "SCALAR"},
    {"bufferView": 2, "byteOffset": 20, "componentType": 5125, "count": 6, "type": "SCALAR"}]"#;

/// A file of one mesh with these primitives, in one node.
fn file(primitives: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, {VIEWS}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"mesh": 0, "name": "node"}}], "meshes": [{{"name": "mesh", "primitives": [{primitives}]}}]}}"#
    )
}

const INDEXED: &str = r#"{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "_ID": 4}, "indices": 3}"#;

fn meshes(scene: &Scene) -> Vec<&TriangleMesh> {
    fn mesh(geometry: &crate::Geometry) -> &TriangleMesh {
        match &geometry.shape {
            SceneShape::Mesh(mesh) => mesh,
            SceneShape::Sphere(_) => panic!("not a mesh"),
        }
    }
    scene.geometries().iter().map(mesh).collect()
}

/// The triangles of all instances in the world.
fn flattened(scene: &Scene) -> Vec<[DVec3; 3]> {
    let meshes = meshes(scene);
    let instances = scene.world().instances.iter().flat_map(|instance| {
        let to_world = instance.placement.at(0.0);
        let geometries = scene.objects()[instance.object.index()].geometries.iter();
        geometries.map(move |&g| (g as usize, to_world))
    });
    instances
        .flat_map(|(g, to_world)| {
            let corner = move |p: Vec3| to_world.point(p.as_dvec3());
            let mesh = meshes[g];
            (0..mesh.len()).map(move |i| mesh.vertices(i).map(corner))
        })
        .collect()
}

#[test]
fn indices_are_of_any_width_or_absent() {
    let expected = [[0, 1, 2], [0, 2, 4]];
    for indices in [2, 3, 4] {
        let primitive = INDEXED.replace("\"indices\": 3", &format!("\"indices\": {indices}"));
        let scene = read(&glb(&file(&primitive), &data())).expect("valid");
        let mesh = meshes(&scene)[0];
        assert_eq!((mesh.triangles(), mesh.positions().len()), (&expected[..], 5));
        assert_eq!(mesh.positions()[4], Vec3::new(-1.0, 1.0, 0.0));
        let uvs: Vec<Vec2> = (0..5_u8).map(|i| f32::from(i) / 5.0).map(|u| Vec2::new(u, 1.0 - u)).collect();
        let distance = std::iter::zip(mesh.uvs().expect("there are some"), uvs).map(|(a, b)| a.distance(b));
        assert!(distance.fold(0.0, f32::max) < 1e-6);
        assert_eq!(scene.warnings, Vec::<String>::new());
        assert_eq!((scene.objects().len(), scene.objects()[1].name.as_str()), (2, "mesh"));
    }
    let scene = read(&glb(&file(r#"{"attributes": {"POSITION": 0}}"#), &data())).expect("valid");
    assert_eq!(meshes(&scene)[0].triangles(), [[0, 1, 2]]);
    assert_eq!(scene.warnings.len(), 1, "two corners are left over: {:?}", scene.warnings);
}

/// For the corners 0 1 2 0 2 4, by the formulas of the specification.
#[test]
fn strips_and_fans_become_triangles() {
    for (mode, expected) in [
        (4, &[[0, 1, 2], [0, 2, 4]][..]),
        (5, &[[0, 1, 2], [1, 0, 2], [2, 0, 2], [0, 4, 2]]),
        (6, &[[1, 2, 0], [2, 0, 0], [0, 2, 0], [2, 4, 0]]),
    ] {
        let primitive = format!(r#"{{"attributes": {{"POSITION": 0}}, "indices": 2, "mode": {mode}}}"#);
        let json = file(&primitive);
        let scene = read(&glb(&json, &data())).expect("valid");
        assert_eq!(meshes(&scene)[0].triangles(), expected, "mode {mode}");
        for few in 0..3 {
            let json = json.replacen("5121, \"count\": 6", &format!("5121, \"count\": {few}"), 1);
            assert_eq!(read(&glb(&json, &data())).expect("valid").triangle_count(), 0, "mode {mode}, {few} corners");
        }
    }
}

#[test]
fn nodes_with_a_mesh_are_instances() {
    let json = file(INDEXED).replace(
        r#"{"mesh": 0, "name": "node"}"#,
        r#"{"children": [2, 1], "translation": [10, 0, 0], "scale": [2, 2, 2]},
           {"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1], "children": [3]},
           {"mesh": 0, "rotation": [0, 0, 1, 0]},
           {"mesh": 0, "translation": [1, 0, 0]},
           {"mesh": 0}"#,
    );
    let scene = read(&glb(&json, &data())).expect("valid");
    assert_eq!((scene.objects().len(), scene.triangle_count()), (2, 2), "node 4 is not in the scene");
    // Depth first, in the order of the children: 2, 1, 3. The point 1 0 0 goes through each.
    let points: Vec<DVec3> = flattened(&scene).chunks(2).map(|triangles| triangles[0][1]).collect();
    assert_eq!(points, [[8.0, 0.0, 0.0], [20.0, 14.0, 14.0], [20.0, 16.0, 14.0]].map(DVec3::from));
    // Without scenes, all nodes that are below no other.
    let json = json.replace(r#""scene": 0, "scenes": [{"nodes": [0]}],"#, "");
    assert_eq!(flattened(&read(&glb(&json, &data())).expect("valid")).len(), 8);
    // What is squeezed flat cannot be placed.
    let flat = json.replace("[2, 2, 2]", "[2, 0, 2]");
    let scene = read(&glb(&flat, &data())).expect("valid");
    assert_eq!(scene.warnings, ["1 nodes are scaled flat; they and what is below them are left out"]);
    assert_eq!(flattened(&scene).len(), 2);
}

#[test]
fn the_first_perspective_camera_is_the_view() {
    let json = file(INDEXED).replace("\"nodes\": [0]", "\"nodes\": [0, 1, 2]").replace(
        r#"{"mesh": 0, "name": "node"}"#,
        r#"{"mesh": 0}, {"camera": 0}, {"camera": 1, "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8]}"#,
    );
    let cameras = r#"{"cameras": [
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 1, "zfar": 2}},
        {"type": "perspective", "perspective": {"yfov": 1.5707964, "znear": 1, "aspectRatio": 2}}], "asset""#;
    let json = json.replace("{\"asset\"", cameras);
    let scene = read(&glb(&json, &data())).expect("valid");
    let camera = scene.camera.expect("there is one");
    let (eye, look, up) = (Vec3::from(camera.eye), Vec3::from(camera.look), Vec3::from(camera.up));
    // The rotation turns -z by twice the angle with sine 0.6 and cosine 0.8: to -(sin, 0, cos) = -(0.96, 0, 0.28).
    assert!((look - eye).normalize().distance(Vec3::new(-0.96, 0.0, -0.28)) < 1e-5, "{camera:?}");
    assert!(eye == Vec3::new(1.0, 2.0, 3.0) && up.distance(Vec3::Y) < 1e-5 && !camera.left_handed, "{camera:?}");
    assert!((camera.fov - 90.0).abs() < 1e-4);
    assert_eq!(scene.warnings, ["orthographic cameras are not modelled"]);
    // In an upright image the horizontal angle is the smaller: its tangent is half of 1 for the half angles.
    let narrow = json.replace("\"aspectRatio\": 2", "\"aspectRatio\": 0.5");
    let fov = read(&glb(&narrow, &data())).expect("valid").camera.expect("there is one").fov;
    assert!((fov - 53.130_1).abs() < 1e-4, "{fov}");
    let message =
        read(&glb(&json.replace("\"camera\": 0", "\"camera\": 2"), &data())).expect_err("no such").to_string();
    assert_eq!(message, "test.glb: node 1: there is no camera 2");
}

#[test]
fn sparse_accessors_replace_elements() {
    // Elements 1 and 4, of zeros or of the five corners, are replaced.
    let mut data = data();
    data.extend([1, 4, 0, 0]);
    data.extend(floats(&[1.5, 2.5, 3.5, 4.5, 5.5, 6.5]));
    let json = file(INDEXED).replace("\"byteLength\": 124", "\"byteLength\": 152").replace(
        r#"{"buffer": 0, "byteLength": 60}"#,
        r#"{"buffer": 0, "byteLength": 60}, {"buffer": 0, "byteOffset": 60, "byteLength": 20, "byteStride": 4},
           {"buffer": 0, "byteOffset": 80, "byteLength": 44}, {"buffer": 0, "byteOffset": 124, "byteLength": 28}"#,
    );
    let sparse = r#""sparse": {"count": 2, "indices": {"bufferView": 3, "componentType": 5121},
        "values": {"bufferView": 3, "byteOffset": 4}}"#;
    let plain = r#"{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"}"#;
    for (base, third) in [("\"bufferView\": 0, ", Vec3::new(0.0, 1.0, 0.0)), ("", Vec3::ZERO)] {
        let replaced = format!(r#"{{{base}"componentType": 5126, "count": 5, "type": "VEC3", {sparse}}}"#);
        let json = json.replace(plain, &replaced);
        let scene = read(&glb(&json, &data)).expect("valid");
        let positions = meshes(&scene)[0].positions();
        assert_eq!(positions[1..], [Vec3::new(1.5, 2.5, 3.5), positions[2], third, Vec3::new(4.5, 5.5, 6.5)]);
        for (bytes, expected) in
            [([4, 1], "do not ascend"), ([1, 5], "do not ascend, or go beyond"), ([1, 1], "do not ascend")]
        {
            let mut data = data.clone();
            data[124..126].copy_from_slice(&bytes);
            let message = read(&glb(&json, &data)).expect_err("damaged").to_string();
            assert!(message.contains("accessor 0: its sparse indices ") && message.contains(expected), "{message}");
        }
        assert_robust(&glb(&json, &data), parse);
    }
}

#[test]
fn quantised_positions_are_read() {
    let json = file(r#"{"attributes": {"POSITION": 0}}"#)
        .replace("{\"asset\"", r#"{"extensionsRequired": ["KHR_mesh_quantization"], "asset""#);
    for (component, normalized, bytes, expected) in [
        (5120, false, &[1, 0xfe, 3][..], [1.0, -2.0, 3.0]),
        (5120, true, &[127, 0x80, 0], [1.0, -1.0, 0.0]),
        (5121, true, &[255, 51, 0], [1.0, 0.2, 0.0]),
        (5122, true, &[0xff, 0x7f, 0, 0x80, 0, 0], [1.0, -1.0, 0.0]),
        (5123, false, &[1, 1, 0xff, 0xff, 0, 0], [257.0, 65535.0, 0.0]),
    ] {
        let accessor = format!(r#""componentType": {component}, "normalized": {normalized}, "count": 3"#);
        let json = json.replacen(r#""componentType": 5126, "count": 5"#, &accessor, 1);
        let scene = read(&glb(&json, &[bytes.repeat(3), data()].concat())).expect("valid");
        assert_eq!(meshes(&scene)[0].positions(), [Vec3::from(expected); 3]);
    }
}

/// Of a large array, a primitive copies only the vertices that it uses.
#[test]
fn unused_vertices_are_dropped_where_they_are_many() {
    let json = file(INDEXED).replace(
        r#""byteOffset": 8, "componentType": 5123, "count": 6"#,
        r#""byteOffset": 14, "componentType": 5123, "count": 3"#,
    );
    let scene = read(&glb(&json, &data())).expect("valid");
    let mesh = meshes(&scene)[0];
    assert_eq!(mesh.triangles(), [[0, 1, 2]]);
    assert_eq!(mesh.vertices(0), [[0., 0., 0.], [1., 1., 0.], [-1., 1., 0.]].map(Vec3::from));
    assert_eq!(mesh.uvs().expect("there are some")[2], Vec2::new(0.8, 0.2));
}

#[test]
fn materials_have_the_numbers_and_names_of_the_file() {
    let plain = r#"{"attributes": {"POSITION": 0}, "indices": 2}"#;
    let of = |material: u32| plain.replace("\"indices\"", &format!("\"material\": {material}, \"indices\""));
    let materials = r#"{"materials": [{"name": "steel"}, {}], "asset""#;
    let json = file(&[of(1), plain.to_owned(), of(0), plain.to_owned()].join(",")).replace("{\"asset\"", materials);
    let scene = read(&glb(&json, &data())).expect("valid");
    assert_eq!(scene.names.materials, ["steel", "material 1", "default"]);
    let material = |g: &crate::Geometry| match g.surface {
        ::primitive::Surface::Material { material, .. } => material.index(),
        ::primitive::Surface::MediumBoundary => panic!("no surface"),
    };
    assert_eq!(scene.geometries().iter().map(material).collect::<Vec<_>>(), [1, 2, 0, 2]);
    let message =
        read(&glb(&json.replace("\"material\": 1", "\"material\": 2"), &data())).expect_err("no such").to_string();
    assert_eq!(message, "test.glb: mesh 0, primitive 0: there is no material 2");
}

#[test]
fn what_is_not_modelled_is_warned_of_once() {
    let json = file(&format!(
        r#"{{"attributes": {{"POSITION": 0}}, "mode": 0}}, {{"attributes": {{"POSITION": 0}}, "mode": 3}},
        {{"attributes": {{}}}}, {{"attributes": {{}}}}, {}"#,
        INDEXED.replace("{\"attr", r#"{"targets": [{"POSITION": 0}], "attr"#)
    ))
    .replace(
        "{\"asset\"",
        r#"{"skins": [{"joints": [0]}], "animations": [{"channels": [], "samplers": []}],
        "extensionsUsed": ["KHR_materials_unlit", "KHR_lights_punctual", "EXT_mesh_gpu_instancing"], "asset""#,
    )
    .replace("[{\"nodes\": [0]}", "[{\"nodes\": [0]}, {\"nodes\": []}");
    assert_eq!(
        read(&glb(&json, &data())).expect("valid").warnings,
        [
            "skins are not modelled; meshes keep the shape that they have without",
            "animations are not modelled; nodes stay where they are without",
            "morph targets are not modelled; meshes keep the shape that they have without",
            "the file has 2 scenes; only one of them is read",
            "extensions that are not modelled: KHR_lights_punctual, EXT_mesh_gpu_instancing",
            "points and lines are left out",
            "primitives without positions are left out"
        ]
    );
    for json in [file(r#"{"attributes": {"POSITION": 0}, "mode": 1}"#), r#"{"asset": {"version": "2.0"}}"#.to_owned()] {
        let scene = read(json.replace(VIEWS, "\"buffers\": []").as_bytes()).expect("valid");
        assert_eq!(scene.warnings.last().expect("one at least"), "no triangles");
        assert!(scene.world().instances.is_empty());
    }
}
