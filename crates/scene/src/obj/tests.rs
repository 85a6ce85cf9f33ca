use geometry::glam::Vec3;

use super::*;
use crate::ply::tests::{assert_robust, real_file};
use crate::{SceneShape, load};

fn read(text: &str) -> Result<Scene, LoadError> {
    parse(Path::new("folder/test.obj"), text.as_bytes())
}

fn only_mesh(scene: &Scene) -> &TriangleMesh {
    match &scene.geometries() {
        [geometry] => match &geometry.shape {
            SceneShape::Mesh(mesh) => mesh,
            SceneShape::Sphere(_) => panic!("not a mesh"),
        },
        _ => panic!("not one geometry"),
    }
}

const SQUARE: &str = "\
# four corners
mtllib none.mtl
v 0 0 0
v 1 0 0
v 1 1 0 1
v 0 1 .5 0.1 0.2 0.3
vt 0 0
vt 1
vn 0 0 1
o first
usemtl red
f 1/1/1 2/2/1 3/1/1 4/2/1
g second
usemtl light blue
f -4 -3 -2
s off
f 1//1 3//1 4//1 # last
";

#[test]
fn the_whole_file_is_one_mesh_in_file_order() {
    let scene = read(SQUARE).expect("valid");
    let mesh = only_mesh(&scene);
    let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]].map(Vec3::from);
    let corners: Vec<[Vec3; 3]> = (0..mesh.len()).map(|i| mesh.vertices(i)).collect();
    assert_eq!(corners, [[p[0], p[1], p[2]], [p[0], p[2], p[3]], [p[0], p[1], p[2]], [p[0], p[2], p[3]]]);
    let uvs = mesh.uvs().expect("some corners have them");
    assert_eq!(mesh.triangles()[1].map(|v| uvs[v as usize]), [Vec2::ZERO, Vec2::ZERO, Vec2::X]);
    assert_eq!(mesh.positions().len(), 8, "four with texture coordinates, four without");
    assert_eq!(scene.names.materials, ["red", "light blue"]);
    assert_eq!(
        scene.warnings,
        [
            "the material library \"none.mtl\" is not there; materials are names only",
            "2 materials are used, and a mesh has one: all of it is \"red\""
        ]
    );
}

#[test]
fn vertices_stay_as_they_are_where_nothing_has_texture_coordinates() {
    let scene = read("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n").expect("valid");
    assert_eq!((only_mesh(&scene).triangles(), only_mesh(&scene).positions().len()), (&[[1, 2, 3]][..], 4));
    assert_eq!((&scene.names.materials[..], scene.warnings.len()), (&["default".to_owned()][..], 0));
}

#[test]
fn statements_may_be_written_in_many_ways() {
    let plain = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("valid");
    for text in [
        "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3",
        "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "  v\t0 0 0\nv 1 \\\n 0 0\nv 0 1 0\n\n\nf 1 \\\n2 \\\n3",
        "# a path: C:\\folder\\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/ 2/ 3/ # comment\n",
        "f 1 2 3\nv 0 0 0 #\nv 1 0 0\nv 0 1 0",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 2 -1\nl 1 2\np 1\n",
    ] {
        assert_eq!(only_mesh(&read(text).expect("valid")), only_mesh(&plain), "{text}");
    }
}

#[test]
fn what_is_left_out_is_warned_of_once() {
    let text = "v 0 0 0\nf 1 1\nf 1\nl 1 1\np 1\np 1\ncstype bezier\nfoo bar\nbar\n";
    let warnings = read(text).expect("valid").warnings;
    assert_eq!(
        warnings,
        [
            "2 faces have fewer than three vertices; they are left out",
            "lines and points are left out",
            "free-form curves and surfaces are left out",
            "statements are left out that are not OBJ; the first is \"foo\" in line 8",
            "no triangles"
        ]
    );
    for text in ["v 1 2 3\nf", "v 1 2 3\nf 1/", "v 1 2 3\nf 1 1", "v 1 2 3\nf \\\n1 1"] {
        let error = read(text).expect_err(text).to_string();
        assert!(error.contains("line 2: the file ends within a face"), "{text}: {error}");
    }
    for text in ["", "# nothing\n", "v nan inf -1e99\n"] {
        assert_eq!(read(text).expect("valid").warnings, ["no triangles"]);
    }
}

#[test]
fn errors_name_line_face_and_reason() {
    for (text, expected) in [
        ("v 0 0\n", "line 1: 2 numbers where 3 are needed"),
        ("v 0 0 one\n", "line 1: \"one\" is no number"),
        ("\nvt\n", "line 2: 0 numbers where 1 are needed"),
        ("v 0 0 0\n\nf 1 1 1\nf 1 2 1\n", "line 4: face 2 uses vertex 2, but there are only 1 (counted from 1)"),
        ("v 0 0 0\nf 1 1 \\\n1 9\n# end\n", "line 2: face 1 uses vertex 9, but there are only 1 (counted from 1)"),
        ("v 0 0 0\nf 1\nf 1/1 1/1 1/2\nvt 0 0", "line 3: face 2 uses texture coordinate 2, but there are only 1"),
        ("v 0 0 0\nf 1 1 0\n", "line 2: face 1 uses 0 (1 come before it) as a vertex"),
        ("v 0 0 0\nf 1 1 -2\n", "line 2: face 1 uses -2 (1 come before it) as a vertex"),
        ("v 0 0 0\nf 1 1 4294967296\n", "line 2: face 1 uses 4294967296 (1 come before it) as a vertex"),
        ("v 0 0 0\nf 1 1 4294967295\n", "line 2: face 1 uses vertex 4294967295, but there are only 1"),
        ("f 1 2 9223372036854775808\n", "line 1: face 1 uses \"9223372036854775808\" as a vertex"),
        ("f -9223372036854775808\n", "line 1: face 1 uses -9223372036854775808 (0 come before it) as a vertex"),
        ("v 0 0 0\nf 1/a 1 1\n", "line 2: face 1 uses \"a\" as a texture coordinate"),
        ("f / 1 1\n", "line 1: face 1 uses \"\" as a vertex"),
        ("\u{89}PNG\r\n\u{1a}\nIHDR\n", "line 1: not an OBJ file: it begins with \"\\xc2\\x89PNG\""),
    ] {
        let message = read(text).expect_err("damaged").to_string();
        assert!(message.starts_with(&format!("folder/test.obj: {expected}")), "{message}");
    }
}

#[test]
fn damaged_files_are_refused_or_loaded() {
    assert_robust(SQUARE.as_bytes(), parse);
    assert_robust(b"v 0 0 0\nv 1 0 0\r\nv 0 1 \\\n0\nvt 0 .5\nf 1/1 2/1 3/1 -1/-1 1//\n", parse);
}

/// Names, libraries and continued lines do not make the work more than linear.
#[test]
fn many_of_anything_is_no_trouble() {
    let many = |f: &dyn Fn(u32) -> String| (0..100_000).map(f).collect::<String>();
    let scene = read(&many(&|i| format!("usemtl {i}\nmtllib {i}\n"))).expect("valid");
    assert_eq!((scene.names.materials.len(), scene.warnings.len()), (100_000, 3));
    assert_eq!(read(&many(&|_| "\\\n".to_owned())).expect("valid").warnings, ["no triangles"]);
}

/// The reference: the crate tobj.
#[test]
fn real_files_are_what_the_reference_reads() {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    for (name, triangles, materials, warnings) in [
        ("sponza.obj", 66_450, 20, 2),
        ("cornell_box.obj", 36, 8, 2),
        ("cornell_box_mixed/cornell_box.obj", 34, 5, 1),
        ("spider.obj", 1_368, 4, 1),
    ] {
        let Some(path) = real_file(&format!("originals/{name}")) else { continue };
        let scene = load(&path).expect(name);
        let mesh = only_mesh(&scene);
        assert_eq!((mesh.len(), scene.names.materials.len()), (triangles, materials), "{name}");
        assert_eq!(scene.warnings.len(), warnings, "{name}: {:?}", scene.warnings);
        let (models, _) = tobj::load_obj(&path, &options).expect(name);
        let expected = models.iter().flat_map(|model| {
            let p = |&i: &u32| Vec3::from_slice(&model.mesh.positions[3 * i as usize..]);
            model.mesh.indices.iter().map(p)
        });
        assert!(expected.eq((0..mesh.len()).flat_map(|i| mesh.vertices(i))), "{name}");
        let expected = models.iter().flat_map(|model| {
            let uv = |&i: &u32| Vec2::from_slice(&model.mesh.texcoords[2 * i as usize..]);
            model.mesh.texcoord_indices.iter().map(uv)
        });
        let uvs = mesh
            .uvs()
            .map_or(Vec::new(), |uvs| mesh.triangles().as_flattened().iter().map(|&v| uvs[v as usize]).collect());
        assert!(expected.eq(uvs), "{name}");
    }
}
