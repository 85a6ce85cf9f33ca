//! Files that name files, and real files.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::super::load;
use super::{TRIANGLE, mesh};
use crate::{LoadError, Scene};

/// A directory with these files.
fn directory(files: &[(&str, &str)]) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory");
    for (name, text) in files {
        let path = directory.path().join(name);
        fs::create_dir_all(path.parent().expect("it is in the directory")).expect("it can be made");
        fs::write(path, text).expect("it can be written");
    }
    directory
}

/// What the first of these files loads as.
fn load_first(files: &[(&str, &str)]) -> Result<Scene, LoadError> {
    let directory = directory(files);
    load(&directory.path().join(files[0].0))
}

fn refused(files: &[(&str, &str)], message: &str) {
    let error = load_first(files).expect_err(message).to_string();
    assert!(error.contains(message), "{error}\ndoes not say: {message}");
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn an_included_file_goes_on_where_the_other_was() {
    let main = "Translate 1 0 0 AttributeBegin Include \"parts/a.pbrt\" AttributeEnd";
    let part = format!("Translate 0 1 0 {TRIANGLE} Include \"parts/b.pbrt\" Include \"c.pbrt\" {TRIANGLE}");
    let scene = load_first(&[
        ("main.pbrt", main),
        ("parts/a.pbrt", &part),
        ("parts/b.pbrt", "Translate 0 0 1"),
        // Beside the main file there is none of that name, so it is the one beside the file that names it.
        ("parts/c.pbrt", "ReverseOrientation"),
    ])
    .expect("sound");
    let [first, second] = scene.geometries() else { panic!("{:?}", scene.geometries()) };
    assert_eq!(mesh(first).positions()[0].to_array(), [1.0, 1.0, 0.0]);
    assert_eq!(mesh(second).positions()[0].to_array(), [1.0, 1.0, 1.0]);
    assert_eq!(mesh(second).triangles(), [[0, 2, 1]]);
}

#[test]
fn an_imported_file_leaves_the_state_as_it_was() {
    let main = format!("Import \"a.pbrt\" {TRIANGLE}");
    let scene = load_first(&[("main.pbrt", &main), ("a.pbrt", "Translate 1 0 0")]).expect("sound");
    assert_eq!(mesh(&scene.geometries()[0]).positions()[0].to_array(), [0.0; 3]);
    refused(&[("main.pbrt", "Import \"a.pbrt\""), ("a.pbrt", "AttributeBegin")], "not balanced");
}

#[test]
fn files_do_not_include_each_other() {
    refused(&[("main.pbrt", "\nInclude \"main.pbrt\"")], "line 2: Include: ");
    let circle =
        [("main.pbrt", "Include \"a.pbrt\""), ("a.pbrt", "Include \"b.pbrt\""), ("b.pbrt", "Include \"./a.pbrt\"")];
    refused(&circle, "includes itself");
    let chain: Vec<(String, String)> =
        (0..80).map(|i| (format!("{i}.pbrt"), format!("Include \"{}.pbrt\"", i + 1))).collect();
    let chain: Vec<(&str, &str)> = chain.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    refused(&chain, "deeper than 64");
}

#[test]
fn errors_name_the_file_that_they_are_in() {
    refused(&[("main.pbrt", "Include \"a.pbrt\""), ("a.pbrt", "\nScale 0 0 0")], "a.pbrt: line 2: Scale");
    refused(
        &[("main.pbrt", "Include \"a.pbrt\""), ("a.pbrt", "\nAttributeBegin")],
        "a.pbrt: line 2: the AttributeBegin here",
    );
    refused(&[("main.pbrt", "\nInclude \"none.pbrt\"")], "main.pbrt: line 2: there is no file \"none.pbrt\"");
    refused(
        &[("main.pbrt", "Include \"a.pbrt.gz\"")],
        "the compressed file \"a.pbrt.gz\" is not supported; decompress it",
    );
    assert!(matches!(load(Path::new("no such file.pbrt")), Err(LoadError::Io { .. })));
}

#[test]
fn what_follows_the_end_of_the_world_is_not_read() {
    let scene = load_first(&[("main.pbrt", "Include \"a.pbrt\" nonsense"), ("a.pbrt", "WorldBegin WorldEnd\n")]);
    assert_eq!(scene.expect("sound").warnings, ["what follows WorldEnd is not read"]);
}

#[test]
fn meshes_of_ply_files() {
    let shape = "Shape \"plymesh\" \"string filename\" \"geometry/a.ply\" ";
    let main = format!("{shape} Scale -2 2 2 {shape}");
    let scene = load_first(&[("main.pbrt", &main), ("geometry/a.ply", PLY)]).expect("sound");
    let [plain, mirrored] = scene.geometries() else { panic!("{:?}", scene.geometries()) };
    assert_eq!((mesh(plain).triangles(), mesh(plain).positions()[1].to_array()), (&[[0, 1, 2]][..], [1.0, 0.0, 0.0]));
    assert_eq!(
        (mesh(mirrored).triangles(), mesh(mirrored).positions()[1].to_array()),
        (&[[0, 2, 1]][..], [-2.0, 0.0, 0.0])
    );
    refused(&[("main.pbrt", shape), ("geometry/a.ply", "ply\nnonsense")], "a.ply");
    refused(&[("main.pbrt", shape)], "main.pbrt: line 1: there is no file \"geometry/a.ply\"");
    refused(&[("main.pbrt", "Shape \"plymesh\"")], "the parameter filename is missing");
}

#[test]
fn the_killeroo_is_a_cage() {
    let scenes = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes"));
    let path = scenes.join("originals/killeroo.pbrt");
    if !path.is_file() {
        eprintln!("skipped: {} is absent", path.display());
        return;
    }
    let scene = load(&path).expect("sound");
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert_eq!((scene.geometries().len(), scene.triangle_count()), (1, 8316));
    // The same triangles, converted by others.
    let converted = crate::ply::load(&scenes.join("killeroo.ply")).expect("sound");
    let mut triangles = scene.geometries().iter().flat_map(|g| (0..mesh(g).len()).map(|i| mesh(g).vertices(i)));
    let expected = mesh(&converted.geometries()[0]);
    assert!((0..expected.len()).all(|i| triangles.next() == Some(expected.vertices(i))));
}
