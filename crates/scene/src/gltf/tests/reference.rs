//! Against the readers of the crate gltf, and against what is known of real files.

use super::*;
use crate::ply::tests::real_file;

#[test]
fn real_files_are_what_the_reference_reads() {
    for (name, in_memory, flat, materials, warnings) in [
        ("originals/engine-2cylinder.glb", 75_730, 121_496, 34, 0),
        ("originals/smallpine/scene.gltf", 1_650, 1_650, 2, 0),
    ] {
        let Some(path) = real_file(name) else { continue };
        let scene = load(&path).expect(name);
        assert_eq!((scene.triangle_count(), flattened(&scene).len()), (in_memory, flat), "{name}");
        assert_eq!(
            (scene.names.materials.len(), scene.warnings.len()),
            (materials, warnings),
            "{name}: {:?}",
            scene.warnings
        );
        assert_equals_reference(&path, &scene);
    }
    let Some(path) = real_file("originals/bridge-garden-meshopt.glb") else { return };
    match load(&path) {
        Err(LoadError::Unsupported { feature, advice, .. }) => {
            assert_eq!((feature.as_str(), advice.contains("gltfpack")), ("EXT_meshopt_compression", true));
        }
        other => panic!("{other:?}"),
    }
}

/// The reference: the readers of the crate gltf, over a recursive walk.
fn assert_equals_reference(path: &Path, scene: &Scene) {
    let gltf::Gltf { document, blob } = gltf::Gltf::open(path).expect("valid");
    let file = blob.or_else(|| std::fs::read(path.with_extension("bin")).ok()).expect("one buffer");
    fn walk(node: &gltf::Node<'_>, parent: DAffine3, file: &[u8], triangles: &mut Vec<[DVec3; 3]>) {
        let to_world = parent
            * DAffine3::from_mat4(geometry::glam::Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4());
        for primitive in node.mesh().into_iter().flat_map(|mesh| mesh.primitives()) {
            let reader = primitive.reader(|_| Some(file));
            let p: Vec<DVec3> = reader
                .read_positions()
                .expect("some")
                .map(|p| to_world.transform_point3(Vec3::from(p).as_dvec3()))
                .collect();
            let indices: Vec<u32> = reader.read_indices().expect("some").into_u32().collect();
            triangles.extend(indices.chunks(3).map(|i| [0, 1, 2].map(|k| p[i[k] as usize])));
        }
        node.children().for_each(|child| walk(&child, to_world, file, triangles));
    }
    let mut expected = Vec::new();
    document
        .default_scene()
        .expect("one")
        .nodes()
        .for_each(|node| walk(&node, DAffine3::IDENTITY, &file, &mut expected));
    let read = flattened(scene);
    assert_eq!(read.len(), expected.len());
    let difference = std::iter::zip(read.as_flattened(), expected.as_flattened()).map(|(a, b)| a.distance(*b));
    let largest = expected.as_flattened().iter().map(|p| p.length()).fold(0.0, f64::max);
    assert!(difference.fold(0.0, f64::max) <= 1e-12 * largest);
}
