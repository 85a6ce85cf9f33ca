//! Small files in pbrt's format, and what must become of them.

mod damage;
mod files;
mod shapes;
mod surfaces;
mod tokens;
mod transforms;

use std::path::Path;

use geometry::glam::Vec3;
use geometry::{Sphere, TriangleMesh};

use super::interpreter::Interpreter;
use crate::{Geometry, LoadError, Scene, SceneShape};

/// A triangle in the plane z = 0, counter-clockwise as seen from +z.
const TRIANGLE: &str = r#"Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2] "#;

fn parse(text: &str) -> Result<Scene, LoadError> {
    Interpreter::new(Path::new("test.pbrt")).scene_of(text.as_bytes())
}

fn scene(text: &str) -> Scene {
    parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The scene, which must have no warnings.
fn sound(text: &str) -> Scene {
    let scene = scene(text);
    assert_eq!(scene.warnings, [""; 0], "{text}");
    scene
}

fn refused(text: &str, message: &str) {
    let error = parse(text).expect_err(text).to_string();
    assert!(error.contains(message), "{text}\n{error}\ndoes not say: {message}");
}

fn warned(text: &str, message: &str) -> Scene {
    let scene = scene(text);
    let count = scene.warnings.iter().filter(|warning| warning.contains(message)).count();
    assert_eq!(count, 1, "{text}\n{:?}", scene.warnings);
    scene
}

fn mesh(geometry: &Geometry) -> &TriangleMesh {
    match &geometry.shape {
        SceneShape::Mesh(mesh) => mesh,
        SceneShape::Sphere(sphere) => panic!("{sphere:?} is no mesh"),
    }
}

fn sphere(geometry: &Geometry) -> Sphere {
    match &geometry.shape {
        SceneShape::Sphere(sphere) => *sphere,
        SceneShape::Mesh(mesh) => panic!("{mesh:?} is no sphere"),
    }
}

/// The vertices of the first triangle of the first geometry.
fn first_triangle(scene: &Scene) -> [Vec3; 3] {
    mesh(&scene.geometries()[0]).vertices(0)
}

fn first_normal(scene: &Scene) -> Vec3 {
    let [a, b, c] = first_triangle(scene);
    (b - a).cross(c - a).normalize()
}
