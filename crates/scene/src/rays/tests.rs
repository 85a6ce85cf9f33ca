use super::*;
use crate::procedural::meshes;
use geometry::Transform;
use geometry::glam::Vec3;
use primitive::{GeometricPrimitive, MaterialId, MediumInterface, PrimitiveList, Surface, TransformedPrimitive};

fn placed(mesh: geometry::TriangleMesh, at: Transform) -> impl Primitive {
    let surface = Surface::of_material(MaterialId::from_index(0).expect("has an id"));
    TransformedPrimitive::new(GeometricPrimitive::new(mesh, surface, MediumInterface::VACUUM), at)
}

fn hits(primitive: &dyn Primitive, segment: &SceneRay) -> bool {
    let ray = TraversalRay::new(&segment.ray).expect("generated rays are valid");
    primitive.intersect_p(&ray, segment.interval)
}

/// Around the primitive, so that random points lie outside of it too.
fn larger(bounds: &Bounds3) -> Bounds3 {
    let d = bounds.diagonal();
    Bounds3::new(bounds.min - d, bounds.max + d)
}

#[test]
fn pixels_come_in_tiles_each_once() {
    for side in [0_u32, 1, 15, 16, 17, 40] {
        let pixels: Vec<(u32, u32)> = tiled_pixels(side).collect();
        let mut naive: Vec<(u32, u32)> = (0..side).flat_map(|y| (0..side).map(move |x| (x, y))).collect();
        naive.sort_by_key(|&(x, y)| (y / 16, x / 16, y, x));
        assert_eq!(pixels, naive);
    }
}

/// Nothing can stand between a convex body's surface and a point before it: every hit would be the surface left. At all
/// scales and far from the origin, where the error of a hit is that of its coordinates.
#[test]
fn spawned_rays_leave_a_convex_body() {
    let place = |scale: f64, at: DVec3, degrees: f64| {
        let turn = Transform::rotate(degrees, DVec3::new(1.0, 2.0, -0.5)).expect("valid");
        let scale = Transform::scale(scale * DVec3::new(1.0, 0.6, 2.0)).expect("valid");
        let at = Transform::translate(at).expect("valid");
        at.then_inside(&turn).and_then(|t| t.then_inside(&scale)).expect("valid")
    };
    for at in [
        place(1.0, DVec3::ZERO, 0.0),
        place(1.0, DVec3::new(0.3, -0.7, 0.1), 33.0),
        place(1e-6, DVec3::new(1e-3, 0.0, 0.0), 70.0),
        place(1e6, DVec3::new(1e8, -1e7, 3e7), 120.0),
        place(1.0, DVec3::new(5e4, 7e4, -2e4), 200.0),
    ] {
        for mesh in [meshes::cuboid(DVec3::NEG_ONE, DVec3::ONE), meshes::icosphere(1, |_| 1.0)] {
            let body = placed(mesh.expect("small"), at);
            let bounds = larger(&body.world_bound());
            let camera = Camera::looking_at_bounds(&body.world_bound());
            let sets = RaySets::generate(&body, &bounds, &camera, 4096, 3).expect("the camera is valid");
            let seen = sets.primary.iter().filter(|r| hits(&body, r)).count();
            assert!(seen > 100 && sets.diffuse.len() == seen, "{seen} {} {at:?}", sets.diffuse.len());
            assert!(sets.shadow.len() > seen / 2 && sets.shadow.len() <= seen, "{}", sets.shadow.len());
            assert_eq!(sets.diffuse.iter().filter(|r| hits(&body, r)).count(), 0, "diffuse, {at:?}");
            assert_eq!(sets.shadow.iter().filter(|r| hits(&body, r)).count(), 0, "shadow, {at:?}");
        }
    }
}

/// From inside, each of them meets the body again, on the other side.
#[test]
fn spawned_rays_stay_in_a_body_seen_from_inside() {
    let body = placed(meshes::cuboid(DVec3::NEG_ONE, DVec3::ONE).expect("small"), Transform::IDENTITY);
    let camera = Camera { eye: [0.1, 0.2, 0.3], look: [1.0, 0.1, -1.0], ..Camera::default() };
    let sets = RaySets::generate(&body, &body.world_bound(), &camera, 2500, 3).expect("the camera is valid");
    assert_eq!(sets.diffuse.len(), 2500);
    assert!(sets.diffuse.iter().all(|r| hits(&body, r)));
    assert!(sets.shadow.len() == 2500 && !sets.shadow.iter().any(|r| hits(&body, r)));
}

#[test]
fn diffuse_rays_are_distributed_by_the_cosine() {
    let plane = meshes::grid(1, 1, |i, j| DVec3::new(20.0 * i as f64 - 10.0, 0.0, 20.0 * j as f64 - 10.0));
    let plane = placed(plane.expect("small"), Transform::IDENTITY);
    let camera = Camera { eye: [0.0, 5.0, 0.0], look: [0.0; 3], up: [0.0, 0.0, 1.0], ..Camera::default() };
    let sets = RaySets::generate(&plane, &plane.world_bound(), &camera, 4096, 1).expect("the camera is valid");
    assert_eq!(sets.diffuse.len(), 4096);
    let mean = sets.diffuse.iter().map(|r| r.ray.direction.as_dvec3()).sum::<DVec3>() / 4096.0;
    // Six standard deviations: the cosine's variance is 1/2 - (2/3)², that of the other axes 1/4.
    assert!((mean.y - 2.0 / 3.0).abs() < 6.0 * (1.0_f64 / 18.0).sqrt() / 64.0, "{mean}");
    assert!(mean.x.abs().max(mean.z.abs()) < 6.0 * 0.5 / 64.0, "{mean}");
    assert!(sets.diffuse.iter().all(|r| (r.ray.direction.length() - 1.0).abs() < 1e-6 && r.ray.origin.y >= 0.0));
}

#[test]
fn shadow_rays_end_at_one_of_eight_points() {
    let ball = placed(meshes::icosphere(2, |_| 1.0).expect("small"), Transform::IDENTITY);
    let bounds = larger(&ball.world_bound());
    let camera = Camera::looking_at_bounds(&ball.world_bound());
    let sets = RaySets::generate(&ball, &bounds, &camera, 10_000, 5).expect("the camera is valid");
    let mut lights: Vec<Vec3> = Vec::new();
    for SceneRay { ray, interval } in &sets.shadow {
        assert_eq!(*interval, Interval::up_to(1.0));
        let end = ray.at(1.0);
        assert!(bounds.contains_point(end));
        if !lights.iter().any(|l| (*l - end).length() < 1e-5) {
            lights.push(end);
        }
    }
    assert!((2..=8).contains(&lights.len()), "{lights:?}");
}

#[test]
fn random_rays_are_chords_of_the_box() {
    let none = PrimitiveList::<GeometricPrimitive<geometry::Sphere>>::new(Vec::new());
    let flat = Bounds3::new(Vec3::new(1e3, 2.0, -3.0), Vec3::new(1e3 + 1.0, 2.0, 5.0));
    let huge = Bounds3::new(Vec3::splat(-geometry::MAX_COORDINATE), Vec3::splat(geometry::MAX_COORDINATE));
    for bounds in [Bounds3::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 30.0)), flat, huge] {
        let sets = RaySets::generate(&none, &bounds, &Camera::default(), 1000, 8).expect("the camera is valid");
        assert_eq!(sets.random.len(), 1000);
        let mut met = 0;
        for segment in &sets.random {
            let ray = TraversalRay::new(&segment.ray).expect("generated rays are valid");
            assert!(!bounds.contains_point(segment.ray.origin));
            met += usize::from(ray.enter(&bounds, segment.interval).is_some());
        }
        // A box without depth is passed by within rounding.
        assert!(met == 1000 || bounds == flat && met > 300, "{met}");
    }
}

#[test]
fn the_seed_decides() {
    let ball = placed(meshes::icosphere(1, |_| 1.0).expect("small"), Transform::IDENTITY);
    let camera = Camera::looking_at_bounds(&ball.world_bound());
    let generate = |seed| RaySets::generate(&ball, &ball.world_bound(), &camera, 400, seed).expect("valid");
    assert_eq!(generate(1), generate(1));
    for ((name, a), (_, b)) in generate(1).named().into_iter().zip(generate(2).named()) {
        assert!(name == "shadow" || !a.is_empty());
        assert!(a.iter().zip(b).all(|(a, b)| a.ray != b.ray), "{name}");
    }
    let times: Vec<f32> = generate(1).primary.iter().map(|r| r.ray.time).collect();
    assert!(times.iter().all(|t| (0.0..=1.0).contains(t)) && times.iter().any(|&t| t != times[0]));
}

#[test]
fn nothing_to_hit_and_no_size_make_empty_sets() {
    let none = PrimitiveList::<GeometricPrimitive<geometry::Sphere>>::new(Vec::new());
    for (bounds, size) in [(Bounds3::EMPTY, 100), (Bounds3::new(Vec3::NAN, Vec3::ONE), 100), (Bounds3::EMPTY, 0)] {
        let sets = RaySets::generate(&none, &bounds, &Camera::default(), size, 0).expect("the camera is valid");
        assert_eq!(sets.named().map(|(_, rays)| rays.len()), [size, 0, 0, 0]);
    }
    let ball = placed(meshes::icosphere(1, |_| 1.0).expect("small"), Transform::IDENTITY);
    let camera = Camera::looking_at_bounds(&ball.world_bound());
    let sets = RaySets::generate(&ball, &Bounds3::EMPTY, &camera, 400, 0).expect("the camera is valid");
    assert!(!sets.diffuse.is_empty() && sets.shadow.is_empty() && sets.random.is_empty());
    let blind = Camera { look: [0.0; 3], ..Camera::default() };
    assert!(RaySets::generate(&none, &Bounds3::EMPTY, &blind, 100, 0).is_err());
}
