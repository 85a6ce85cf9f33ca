//! Closed meshes from real sources: whatever ray goes in comes out.

use std::path::Path;

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TriangleMesh};
use oracle::{MeshOracle, Oracle, Tally};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// The triangles of a scene in the one layout that these files have; `None` where it is not there.
fn load(name: &str) -> Option<TriangleMesh> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a PLY file") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element)).expect("an element");
        line.trim().parse().expect("a count")
    };
    let (vertices, faces) = bytes[end..].split_at(12 * count("element vertex "));
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
    let index = |b: &[u8]| u32::from_le_bytes(b.try_into().expect("four bytes"));
    let positions = vertices.chunks_exact(12).map(|v| Vec3::new(float(&v[..4]), float(&v[4..8]), float(&v[8..])));
    let triangles = faces.chunks_exact(13).map(|f| [index(&f[1..5]), index(&f[5..9]), index(&f[9..])]);
    Some(TriangleMesh::new(positions, triangles.collect()).expect("indices are in range"))
}

/// Rays from outside of the bounds, aimed at vertices, many of them exactly and along an axis: as many crossings lead
/// out as in, and a ray aimed exactly is not lost.
#[test]
fn closed_meshes_are_closed() {
    for name in ["cow.ply", "cad-as1-assembly.ply", "voxel-monu0-boxes.ply"] {
        let Some(mesh) = load(name) else { return };
        let oracle = MeshOracle::new(&mesh);
        let mut random = Pcg64Mcg::seed_from_u64(37);
        let mut tally = Tally::default();
        let mut ties = 0;
        for i in 0..600 {
            let vertex = mesh.positions()[random.next_u32() as usize % mesh.positions().len()];
            let far =
                Vec3::from_array([0, 1, 2].map(|_| (random.next_u32() as f32 * 2.0_f32.powi(-31) - 1.0) * 1000.0));
            let along_axis = vertex.with_x(-1024.0);
            let ray = if i % 2 == 0 { Ray::new(along_axis, Vec3::X) } else { Ray::new(far, vertex - far) };
            let crossings = oracle.crossings(&ray, Interval::FULL, &mut tally);
            let out = crossings.iter().filter(|crossing| crossing.is_outward).count();
            assert_eq!(2 * out, crossings.len(), "{name} {ray:?}");
            let closest = oracle.closest(&ray, Interval::FULL, &mut tally);
            let all = oracle.all_hits(&ray, Interval::FULL, &mut tally);
            let least = all.iter().filter(|hit| hit.t == all[0].t).map(|hit| hit.primitive).collect::<Vec<_>>();
            ties += usize::from(least.len() > 1);
            assert_eq!(closest.as_ref().map_or(Vec::new(), |closest| closest.primitives.clone()), least);
            assert!(closest.is_some() || i % 2 == 1, "{name} {ray:?}");
            assert_eq!(oracle.any(&ray, Interval::FULL, &mut tally), closest.is_some());
        }
        assert!(ties > 10 && tally.exact > 1000, "{name} {ties} {tally:?}");
    }
}
