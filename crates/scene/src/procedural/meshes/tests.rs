use super::*;
use crate::procedural::Random;

/// Of the inside; positive where the triangles face outward (divergence theorem).
fn volume(mesh: &TriangleMesh) -> f64 {
    let sixth = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0;
    (0..mesh.len()).map(|i| sixth(mesh.vertices(i).map(|v| v.as_dvec3()))).sum()
}

fn assert_solid(mesh: Result<TriangleMesh, MeshError>, triangles: usize, what: &str) -> f64 {
    let mesh = mesh.expect("small");
    assert_eq!(mesh.len(), triangles, "{what}");
    assert!(is_closed(&mesh), "{what}");
    let volume = volume(&mesh);
    assert!(volume > 0.0, "{what}: {volume}");
    volume
}

/// The area of a regular polygon in the circle of this radius.
fn polygon(sides: usize, radius: f64) -> f64 {
    0.5 * sides as f64 * radius * radius * (TAU / sides as f64).sin()
}

#[test]
fn closed_meshes_are_closed_and_face_outward() {
    for n in 0..5 {
        let v = assert_solid(icosphere(n, |_| 2.0), 20 << (2 * n), "icosphere");
        assert!(v < 8.0 * 4.0 / 3.0 * PI && v > [20.2, 29.0, 32.3, 33.1, 33.4][n as usize], "{n}: {v}");
    }
    for (rings, segments) in [(1, 3), (2, 4), (15, 16), (40, 7)] {
        let mut random = Random::new(rings as u64, 0);
        assert_solid(uv_sphere(rings, segments, |_| 1.0), 2 * rings * segments, "sphere");
        let spiky = uv_sphere(rings, segments, |_| random.between(1.0, 6.0));
        assert_solid(spiky, 2 * rings * segments, "spiky sphere");
    }
    let v = assert_solid(cuboid(DVec3::new(-1.0, 2.0, 3.0), DVec3::new(1.0, 5.0, 7.0)), 12, "cuboid");
    assert!((v - 24.0).abs() < 1e-12);
    for sides in [3, 4, 11] {
        let v = assert_solid(tube(&[DVec3::X, DVec3::new(1.0, 0.0, 2.0)], sides, |_| 0.5), 4 * sides, "cylinder");
        assert!((v / (2.0 * polygon(sides, 0.5)) - 1.0).abs() < 1e-6, "{sides}: {v}");
        let bent = [DVec3::ZERO, DVec3::X, DVec3::new(1.5, 1.0, 0.0), DVec3::new(1.5, 2.0, 1.0)];
        assert_solid(tube(&bent, sides, |i| 0.3 - 0.05 * i as f64), 8 * sides, "bent tube");
        let cup = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.8, 2.0), (0.8, 0.2), (0.0, 0.2)].map(DVec2::from);
        let v = assert_solid(revolution(&cup, sides), 8 * sides, "cup");
        assert!((v / (2.0 * polygon(sides, 1.0) - 1.8 * polygon(sides, 0.8)) - 1.0).abs() < 1e-6, "{sides}: {v}");
        let ring = [(2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (2.0, 1.0)].map(DVec2::from);
        let v = assert_solid(revolution_ring(&ring, sides), 8 * sides, "ring");
        assert!((v / (polygon(sides, 3.0) - polygon(sides, 2.0)) - 1.0).abs() < 1e-6, "{sides}: {v}");
        // Pappus: the area of the tube's section times the length of the circle that it follows.
        let v = assert_solid(torus_knot([1, 0], [3.0, 0.5], 0.2, 400, sides), 800 * sides, "torus");
        assert!((v / (polygon(sides, 0.2) * TAU * 3.5) - 1.0).abs() < 0.05, "{sides}: {v}");
        for turns in [[2, 3], [3, 2], [5, 7]] {
            assert_solid(torus_knot(turns, [3.0, 1.0], 0.2, 200, sides), 400 * sides, "knot");
        }
    }
}

/// The definition: count every edge by comparing it with all others.
fn is_closed_naive(mesh: &TriangleMesh) -> bool {
    let edges: Vec<_> =
        (0..mesh.len()).map(|i| mesh.vertices(i)).flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.iter().all(|&(a, b)| {
        let same = edges.iter().filter(|&&e| e == (a, b)).count();
        let reverse = edges.iter().filter(|&&e| e == (b, a)).count();
        a != b && same == 1 && reverse == 1
    })
}

#[test]
fn damage_opens_a_mesh() {
    let whole = icosphere(1, |_| 1.0).expect("small");
    let rebuilt = |positions: Vec<_>, triangles| TriangleMesh::new(positions, triangles).expect("in range");
    let damaged = |damage: &dyn Fn(&mut Vec<[u32; 3]>)| {
        let mut triangles = whole.triangles().to_vec();
        damage(&mut triangles);
        rebuilt(whole.positions().to_vec(), triangles)
    };
    let soup = {
        let positions = (0..whole.len()).flat_map(|i| whole.vertices(i)).collect::<Vec<_>>();
        rebuilt(positions, (0..whole.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    };
    let with_nan = {
        let mut positions = whole.positions().to_vec();
        positions[0].x = f32::NAN;
        rebuilt(positions, whole.triangles().to_vec())
    };
    let negative_zeros = {
        let negate = |p: &geometry::glam::Vec3| p.map(|x| if x == 0.0 { -0.0 } else { x });
        let mut positions = soup.positions().to_vec();
        positions.iter_mut().step_by(2).for_each(|p| *p = negate(p));
        rebuilt(positions, soup.triangles().to_vec())
    };
    let cases = [
        ("whole", whole.clone(), true),
        ("none", rebuilt(Vec::new(), Vec::new()), true),
        ("without shared indices", soup, true),
        ("negative zeros", negative_zeros, true),
        ("a triangle missing", damaged(&|t| t.truncate(79)), false),
        ("a triangle twice", damaged(&|t| t.push(t[3])), false),
        ("a triangle turned over", damaged(&|t| t[5].swap(0, 1)), false),
        ("all turned over", damaged(&|t| t.iter_mut().for_each(|t| t.swap(0, 1))), true),
        ("two sides of one triangle", damaged(&|t| *t = vec![[0, 1, 2], [0, 2, 1]]), true),
        ("a point for a triangle", damaged(&|t| *t = vec![[0, 0, 0]]), false),
        ("open", grid(2, 3, |i, j| DVec3::new(i as f64, 0.0, j as f64)).expect("small"), false),
    ];
    for (what, mesh, closed) in cases {
        assert_eq!((is_closed(&mesh), is_closed_naive(&mesh)), (closed, closed), "{what}");
    }
    assert!(is_closed(&with_nan), "each NaN is a vertex of its own, and shared by its index");
}

#[test]
fn a_grid_faces_up_and_is_asked_row_by_row() {
    let mut asked = Vec::new();
    let mesh = grid(3, 2, |column, row| {
        asked.push((column, row));
        DVec3::new(column as f64, 0.0, row as f64)
    });
    let mesh = mesh.expect("small");
    assert_eq!((mesh.len(), mesh.positions().len()), (12, 12));
    assert_eq!(asked[..5], [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1)]);
    for [a, b, c] in (0..12).map(|i| mesh.vertices(i)) {
        assert_eq!((b - a).cross(c - a), geometry::glam::Vec3::Y);
    }
    assert!(grid(0, 5, |_, _| DVec3::ZERO).expect("small").is_empty());
}

#[test]
fn little_and_senseless_input_makes_a_mesh() {
    assert!(tube(&[], 3, |_| 1.0).expect("small").is_empty());
    assert!(revolution(&[], 3).expect("small").is_empty());
    assert!(revolution(&[DVec2::ZERO], 3).expect("small").is_empty());
    assert!(revolution_ring(&[], 3).expect("small").is_empty());
    assert!(merge([]).expect("small").is_empty());
    assert!(smooth_path(&[], 3).is_empty());
    assert_eq!(smooth_path(&[DVec3::X], 3), [DVec3::X]);
    assert_eq!(uv_sphere(0, 0, |_| 1.0).expect("small").len(), 6);
    assert_eq!(tube(&[DVec3::ZERO; 4], 0, |_| 1.0).expect("small").len(), 24);
    assert_eq!(torus_knot([0, 0], [1.0, 1.0], 1.0, 0, 0).expect("small").len(), 18);
    let nan = tube(&[DVec3::NAN, DVec3::X, DVec3::INFINITY], 3, |_| f64::NAN).expect("small");
    assert_eq!(nan.len(), 18);
    assert_eq!(icosphere(1, |_| f64::NAN).expect("small").len(), 80);
}

#[test]
fn too_large_meshes_are_refused_before_they_are_made() {
    let many = usize::MAX / 2;
    let refused = [
        icosphere(14, |_| 1.0),
        icosphere(u32::MAX, |_| 1.0),
        uv_sphere(many, many, |_| 1.0),
        uv_sphere(1 << 16, 1 << 16, |_| 1.0),
        revolution(&[DVec2::ONE; 2], many),
        revolution_ring(&[DVec2::ONE; 3], 1 << 31),
        tube(&[DVec3::ZERO, DVec3::X], 1 << 31, |_| 1.0),
        torus_knot([2, 3], [3.0, 1.0], 0.2, many, 3),
        grid(usize::MAX, 1, |_, _| DVec3::ZERO),
        grid(1 << 16, 1 << 15, |_, _| DVec3::ZERO),
    ];
    for (i, mesh) in refused.into_iter().enumerate() {
        assert!(matches!(mesh, Err(MeshError::TooLarge { .. })), "{i}");
    }
}

#[test]
fn a_smooth_path_goes_through_its_points() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 5.0)];
    let path = smooth_path(&points, 8);
    assert_eq!(path.len(), 25);
    assert!(path.iter().step_by(8).zip(points).all(|(a, b)| (*a - b).length() < 1e-12));
    // Of a straight line with even steps the inner pieces are straight and even.
    let line = smooth_path(&[0.0, 1.0, 2.0, 3.0].map(|x| x * DVec3::ONE), 4);
    assert!((4..=8).all(|i| (line[i] - 0.25 * i as f64 * DVec3::ONE).length() < 1e-12));
}

#[test]
fn merging_keeps_the_order() {
    let [a, b] = [1.0, 2.0].map(|size| cuboid(DVec3::ZERO, size * DVec3::ONE).expect("small"));
    let both = merge([&a, &b]).expect("small");
    let vertices = |mesh: &TriangleMesh| (0..mesh.len()).map(|i| mesh.vertices(i)).collect::<Vec<_>>();
    assert_eq!(vertices(&both), [vertices(&a), vertices(&b)].concat());
}
