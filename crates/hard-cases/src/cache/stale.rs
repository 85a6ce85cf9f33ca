//! X07: trees over geometry that has changed since.

use std::sync::Arc;

use bvh_flat::cache::GeometryKey;
use bvh_flat::{BuildConfig, FlatBvh};
use geometry::glam::{Vec2, Vec3};
use geometry::{Bounds3, Transform, TriangleMesh};

use super::{LAYOUTS, file_of, load, options, small_mesh, variant};
use crate::{Outcome, Random, Run, Tries};

type Change = fn(&mut Vec<Vec3>, &mut Vec<[u32; 3]>);

const CHANGES: [(&str, Change); 9] = [
    ("a vertex by one ulp", |p, _| p[17].y = p[17].y.next_up()),
    ("the last vertex by one ulp", |p, _| {
        let last = p.len() - 1;
        p[last].z = p[last].z.next_down();
    }),
    ("the sign of a zero", |p, _| p[0].x = -p[0].x),
    ("two vertices exchanged", |p, _| p.swap(3, 4)),
    ("two triangles exchanged", |_, t| t.swap(0, 1)),
    ("a triangle turned", |_, t| t[5].rotate_left(1)),
    ("an index", |_, t| t[7][2] = 0),
    ("a vertex more, which no triangle has", |p, _| p.push(Vec3::ONE)),
    ("a triangle less", |_, t| t.truncate(t.len() - 1)),
];

pub(super) fn other_geometry(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 707);
    let mesh = small_mesh(&mut random);
    let mut positions = mesh.positions().to_vec();
    positions[0].x = 0.0;
    let mesh = Arc::new(TriangleMesh::new(positions, mesh.triangles().to_vec()).expect("in range"));
    for layout in LAYOUTS {
        let file = file_of(&mesh, layout);
        for (name, change) in CHANGES {
            let (mut positions, mut triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
            change(&mut positions, &mut triangles);
            let changed = Arc::new(TriangleMesh::new(positions, triangles).expect("in range"));
            let loaded = load(&file, &changed, layout);
            tries.check(variant(&loaded) == "StaleGeometry", || format!("{layout}, {name}: {}", variant(&loaded)));
        }
        let same = TriangleMesh::clone(&mesh).with_uvs(vec![Vec2::ONE; mesh.positions().len()]).expect("as many");
        let loaded = load(&file, &Arc::new(same), layout);
        tries.check(loaded.is_ok(), || format!("{layout}, texture coordinates: {}", variant(&loaded)));
    }
    moved_instances(&mut tries, &mut random);
    tries.outcome()
}

/// A tree over instances is one over their boxes: a transform that changes makes another key.
fn moved_instances(tries: &mut Tries, random: &mut Random) {
    let unit = Bounds3::new(Vec3::splat(-0.5), Vec3::splat(0.5));
    let placed = |places: &[Vec3]| -> Vec<Bounds3> {
        let boxes = places.iter().map(|&place| Transform::translate(place.as_dvec3()).expect("finite").bounds(&unit));
        boxes.collect()
    };
    let places: Vec<Vec3> = (0..20).map(|_| 10.0 * random.vector()).collect();
    let bounds = placed(&places);
    let options = options(bvh_flat::cache::TreeLayout::Binary);
    let tree = FlatBvh::build(&bounds, &BuildConfig::default(), &()).expect("the default is valid");
    let file = tree.to_bytes(GeometryKey::of_bounds(&bounds), &options).expect("a built tree can be saved");
    let mut moved = places.clone();
    moved[11].x += 0.25;
    let mut exchanged = places.clone();
    exchanged.swap(0, 19);
    for (places, expected) in [(places, "accepted"), (moved, "StaleGeometry"), (exchanged, "StaleGeometry")] {
        let loaded = FlatBvh::from_bytes(&file, GeometryKey::of_bounds(&placed(&places)), Some(&options));
        tries.check(variant(&loaded) == expected, || format!("instances: {}, not {expected}", variant(&loaded)));
    }
}
