//! One copy in memory, many places, still and moving.

use std::sync::Arc;

use bvh_flat::geometry::glam::{DVec3, Vec3};
use bvh_flat::geometry::{
    AnimatedTransform, Interval, Keyframe, Ray, Shape, Sphere, Transform, TraversalRay, TriangleMesh,
};
use bvh_flat::primitive::{
    GeometricPrimitive, MaterialId, MediumInterface, Primitive, PrimitiveList, Surface, TransformedPrimitive,
};
use bvh_flat::{BuildConfig, BvhAggregate, MeshBvh, SplitMethod, WideMesh};

use crate::support::{Random, rays_at};

type Object = Arc<GeometricPrimitive<MeshBvh>>;

fn material() -> Surface {
    Surface::of_material(MaterialId::from_index(0).expect("an id"))
}

fn object(mesh: TriangleMesh) -> Object {
    let bvh = MeshBvh::build(mesh, &BuildConfig::default()).expect("the configuration is valid");
    Arc::new(GeometricPrimitive::new(bvh, material(), MediumInterface::VACUUM))
}

fn bumpy() -> TriangleMesh {
    scene::meshes::icosphere(3, |p| 1.0 + 0.2 * (5.0 * p.y).sin()).expect("a mesh")
}

fn random_transform(random: &mut Random) -> Transform {
    let place = Transform::translate((20.0 * random.vector()).as_dvec3()).expect("finite");
    let turn =
        Transform::rotate(f64::from(360.0 * random.unit()), (random.vector() + Vec3::X).as_dvec3()).expect("an axis");
    let size = Transform::scale((random.vector() + Vec3::splat(1.5)).as_dvec3()).expect("not flat");
    place.then_inside(&turn).and_then(|t| t.then_inside(&size)).expect("invertible")
}

/// I01: the identity, exact permutations of the axes with signs, and powers of two give the bits of the flattened
/// scene.
#[test]
fn exact_transforms_are_invisible() {
    let mesh = bumpy();
    let shared = object(mesh.clone());
    let quarter = Transform::rotate(90.0, DVec3::Z).expect("an axis");
    let mirror = Transform::scale(DVec3::new(-2.0, 2.0, 2.0)).expect("not flat");
    for t in [Transform::IDENTITY, quarter, mirror, quarter.then_inside(&mirror).expect("invertible")] {
        let placed = TransformedPrimitive::new(Arc::clone(&shared), t);
        let moved: Vec<Vec3> = mesh.positions().iter().map(|p| t.point(p.as_dvec3()).as_vec3()).collect();
        let flattened = object(TriangleMesh::new(moved, mesh.triangles().to_vec()).expect("indices are in range"));
        let mut hits = 0;
        for (ray, interval) in rays_at(flattened.shape().mesh(), &flattened.world_bound(), 3_000, 7) {
            let Some(ray) = TraversalRay::new(&ray) else { continue };
            let (a, b) = (placed.intersect(&ray, interval), flattened.intersect(&ray, interval));
            assert_eq!(a.map(|h| (h.t, h.primitive)), b.map(|h| (h.t, h.primitive)), "{ray:?}");
            hits += usize::from(a.is_some());
        }
        assert!(hits > 1_000);
    }
}

/// Many instances in a tree, nested twice: the naive list answers the same, bit for bit.
#[test]
fn nested_instances_in_trees_answer_as_lists_do() {
    let mut random = Random::new(11);
    let shared = object(bumpy());
    let inner: Vec<_> =
        (0..12).map(|_| TransformedPrimitive::new(Arc::clone(&shared), random_transform(&mut random))).collect();
    let outer: Vec<Transform> = (0..20).map(|_| random_transform(&mut random)).collect();
    let naive = PrimitiveList::new(
        outer.iter().map(|t| TransformedPrimitive::new(PrimitiveList::new(inner.clone()), *t)).collect(),
    );
    for method in SplitMethod::ALL {
        let config = BuildConfig::new(method);
        let group = Arc::new(BvhAggregate::build(inner.clone(), &config).expect("the configuration is valid"));
        let placed = outer.iter().map(|t| TransformedPrimitive::new(Arc::clone(&group), *t)).collect();
        let world = BvhAggregate::build(placed, &config).expect("the configuration is valid");
        assert_eq!(world.primitive_count(), naive.primitive_count());
        let bounds = world.world_bound();
        let mut hits = 0;
        for _ in 0..10_000 {
            let ray = Ray::new(random.point_in(&bounds), random.vector());
            let ray = TraversalRay::new(&ray).expect("valid");
            let hit = world.intersect(&ray, Interval::FULL);
            assert_eq!(hit, naive.intersect(&ray, Interval::FULL));
            assert_eq!(hit.is_some(), world.intersect_p(&ray, Interval::FULL));
            if let Some(hit) = hit {
                hits += 1;
                let (a, b) = (world.interaction(&ray, &hit), naive.interaction(&ray, &hit));
                assert_eq!(a, b);
                let along = ray.origin64() + f64::from(hit.t) * ray.direction64();
                assert!((a.p().as_dvec3() - along).length() < 1e-4, "{} is not {along}", a.p());
            }
        }
        assert!(hits > 500, "{hits}");
    }
}

/// The world bound of an instance within an instance is asked by a ray that was rounded to f32, and must not cut off
/// what the ray of f64 meets in its planes, where faces of the cube lie: one just below 1, with origins just above,
/// where numbers are twice as coarse.
#[test]
fn bounds_of_nested_instances_change_no_hit() {
    let positions = (0..8).map(|i| Vec3::from_array([1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 })));
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect::<Vec<_>>();
    let cube = TriangleMesh::new(positions.collect::<Vec<_>>(), triangles).expect("indices are in range");
    let cube = Arc::new(WideMesh::build(cube, &BuildConfig::default()).expect("the configuration is valid"));
    let shared = GeometricPrimitive::new(Arc::clone(&cube), material(), MediumInterface::VACUUM);
    let mut random = Random::new(8);
    let mut hits = 0;
    for _ in 0..500 {
        let top = 1.0 - 0.01 * f64::from(random.unit());
        let inner = Transform::translate([0.0, 0.0, top - 1.0]).expect("finite");
        let outer = random_transform(&mut random);
        let nested = TransformedPrimitive::new(TransformedPrimitive::new(shared.clone(), inner), outer);
        for _ in 0..50 {
            let target = random.vector().as_dvec3().with_z(top);
            let way = DVec3::new(0.1, 0.2, -1.0);
            let from = target - 0.05 * f64::from(random.unit()) * way;
            let origin = outer.point(from).as_vec3();
            let Some(ray) = TraversalRay::new(&Ray::new(origin, outer.vector(way).as_vec3())) else { continue };
            let within = outer.ray_to_object(&ray).and_then(|ray| inner.ray_to_object(&ray)).expect("finite");
            let (a, b) = (nested.intersect(&ray, Interval::FULL), cube.intersect(&within, Interval::FULL));
            assert_eq!(a, b, "{ray:?}");
            hits += usize::from(a.is_some());
        }
    }
    assert!(hits > 10_000, "{hits}");
}

/// A million instances of one mesh: 2 · 10¹⁰ triangles in memory of the order of the instances.
#[test]
fn a_million_instances_take_the_memory_of_instances() {
    let shared = object(scene::meshes::icosphere(5, |p| 1.0 + 0.2 * (5.0 * p.y).sin()).expect("a mesh"));
    let per_object = shared.primitive_count();
    let side = 100;
    let places = (0..side * side * side).map(|i| {
        let at = DVec3::new(f64::from(i % side), f64::from(i / side % side), f64::from(i / side / side));
        TransformedPrimitive::new(Arc::clone(&shared), Transform::translate(4.0 * at).expect("finite"))
    });
    let world = BvhAggregate::build(places.collect(), &BuildConfig::new(SplitMethod::Hlbvh)).expect("valid");
    assert_eq!(world.primitive_count(), 1_000_000 * per_object);
    assert!(world.primitive_count() > 20_000_000_000);
    let bytes = world.bvh().memory() + size_of_val(world.list().members());
    assert!(bytes < 400 * 1_000_000, "{bytes} bytes for a million instances");
    let ray = TraversalRay::new(&Ray::new([-10.0, 400.0 - 4.0, 4.0 * 50.0], [1.0, 0.0, 0.0])).expect("valid");
    let hit = world.intersect(&ray, Interval::FULL).expect("a row of instances is ahead");
    assert_eq!(hit.primitive / per_object, 50 * 100 * 100 + 99 * 100);
    assert!((hit.t - 9.0).abs() < 0.3);
}

/// A moving instance is found at every time of the shutter, and its bounds contain it.
#[test]
fn moving_instances_are_found_at_every_time() {
    let mut random = Random::new(23);
    let mut inside = 0;
    for _ in 0..100 {
        let keyframes = [0.0, 1.0].map(|time| Keyframe { time, transform: random_transform(&mut random) });
        let Ok(motion) = AnimatedTransform::new(keyframes.to_vec()) else { continue };
        let sphere = Sphere::new(random.vector(), 0.3 + random.unit()).expect("a sphere");
        let primitive = GeometricPrimitive::new(sphere, material(), MediumInterface::VACUUM);
        let moving = TransformedPrimitive::new(primitive, motion.clone());
        let world = BvhAggregate::build(vec![moving], &BuildConfig::default()).expect("the configuration is valid");
        let bounds = world.world_bound();
        for _ in 0..1_000 {
            let time = random.unit();
            let at = motion.at(time);
            for corner in sphere.object_bound().corners() {
                let p = at.point(corner.as_dvec3());
                assert!(p.cmpge(bounds.min.as_dvec3()).all() && p.cmple(bounds.max.as_dvec3()).all(), "{p} {time}");
            }
            let center = at.point(sphere.center().as_dvec3()).as_vec3();
            let origin = center + 50.0 * random.vector();
            if (origin - center).length() < 10.0 {
                continue;
            }
            let ray = TraversalRay::new(&Ray::new(origin, center - origin).at_time(time)).expect("valid");
            let hit = world.intersect(&ray, Interval::FULL).expect("a ray at the center hits");
            assert!(hit.t < 1.0 && world.intersect_p(&ray, Interval::FULL));
            inside += 1;
        }
    }
    assert!(inside > 50_000, "{inside}");
}
