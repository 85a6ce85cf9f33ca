//! B16, B17, B18, B19: primitives that cannot be hit leave the others alone.

use std::sync::{Arc, Mutex};

use bvh_flat::bvh_build::TreeStatistics;
use bvh_flat::{BuildObserver, BvhAggregate, FlatBvh};
use geometry::glam::Vec3;
use geometry::{Bounds3, Hit, HitVisitor, Interval, Ray, Sphere, TraversalRay, TriangleMesh, Visit};
use primitive::{GeometricPrimitive, HitKind, MaterialId, MediumInterface, Primitive, Surface, SurfaceInteraction};

use super::meshes::{no_area, not_finite};
use super::sweep::{LEAVES, answers, checked_tree, configs, label, rays_at, sweep};
use crate::{Outcome, Random, Run, Tries};

/// B16: NaN in one coordinate or in all.
pub(super) fn nan(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 16);
    for axis in 0..4 {
        let mesh = not_finite(run.effort.pick(1_000, 1_000_000), f32::NAN, axis, &mut random);
        leaves_the_others_alone(&mut tries, run, &format!("NaN on axis {axis}"), mesh, is_active, &mut random);
    }
    tries.outcome()
}

/// B17: infinities in one coordinate or in all, numbers beyond the domain, and infinite boxes in a row.
pub(super) fn infinite(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 17);
    for bad in [f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1.2e18] {
        for axis in [0, 1, 3] {
            let mesh = not_finite(run.effort.pick(500, 50_000), bad, axis, &mut random);
            leaves_the_others_alone(&mut tries, run, &format!("{bad} on axis {axis}"), mesh, is_active, &mut random);
        }
    }
    let all = Bounds3::new(Vec3::NEG_INFINITY, Vec3::INFINITY);
    let mut bounds = vec![all; 1_000];
    bounds.extend((0..100).map(|i| Bounds3::from_points([Vec3::splat(i as f32)])));
    bounds.extend(vec![all; 1_000]);
    for config in configs(&LEAVES) {
        let tree = checked_tree(&mut tries, "infinite boxes in a row", &bounds, &config);
        let root = tree.as_ref().map_or(Bounds3::EMPTY, FlatBvh::bounds);
        tries.check(root == Bounds3::new(Vec3::ZERO, Vec3::splat(99.0)), || format!("the root is {root:?}"));
    }
    tries.outcome()
}

/// B19: a third of all triangles has no area, exactly.
pub(super) fn without_area(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 19);
    let mesh = no_area(run.effort.pick(1_000, 100_000), &mut random);
    let has_area = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]) != Vec3::ZERO;
    leaves_the_others_alone(&mut tries, run, "without area", mesh, has_area, &mut random);
    tries.outcome()
}

fn is_active(triangle: &[Vec3; 3]) -> bool {
    Bounds3::from_points(*triangle).is_valid()
}

/// The mesh answers as one without the triangles that are not to be `kept`, under its own numbers; and every tree over
/// it as the mesh alone.
fn leaves_the_others_alone(
    tries: &mut Tries,
    run: &Run,
    name: &str,
    mesh: TriangleMesh,
    kept: fn(&[Vec3; 3]) -> bool,
    random: &mut Random,
) {
    let numbers: Vec<usize> = (0..mesh.len()).filter(|&i| kept(&mesh.vertices(i))).collect();
    tries.check(numbers.len() < mesh.len(), || format!("{name}: there are none"));
    let triangles = numbers.iter().map(|&i| mesh.triangles()[i]).collect();
    let others = TriangleMesh::new(mesh.positions().to_vec(), triangles).expect("the same indices");
    // At all, also at those that cannot be hit: those rays are valid where the target is.
    let mut rays = rays_at(&mesh, run.effort.pick(150, 1_000), random);
    rays.extend(rays_at(&others, run.effort.pick(150, 1_000), random));
    let few = &rays[..rays.len() / 4];
    sweep(tries, run, name, mesh.clone(), few, run.effort.pick(&[1, 4], &LEAVES));

    let shapes = run.subject.shape(Arc::new(mesh)).and_then(|all| Ok((all, run.subject.shape(Arc::new(others))?)));
    let (all, others) = match shapes {
        Ok(shapes) => shapes,
        Err(error) => return tries.check(false, || format!("{name}: {error}")),
    };
    let expected: Vec<_> = (rays.iter().filter_map(TraversalRay::new))
        .map(|ray| {
            let hit = others.intersect(&ray, Interval::FULL);
            (ray, hit.map(|hit| Hit { primitive: numbers[hit.primitive as usize] as u64, ..hit }))
        })
        .collect();
    let hits = expected.iter().filter(|(_, hit)| hit.is_some()).count();
    tries.check(hits > rays.len() / 4, || format!("{name}: only {hits} rays hit"));
    answers(tries, &format!("{name}, beside those without"), &all, &expected);
}

/// B18: primitives of one's own whose bounds are inverted, NaN or infinite: they are counted, and the others are hit.
pub(super) fn wrong_bounds(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 18);
    let wrong = [
        Bounds3::EMPTY,
        Bounds3::new(Vec3::splat(1.0), Vec3::new(2.0, 0.0, 2.0)),
        Bounds3::new(Vec3::NAN, Vec3::NAN),
        Bounds3::new(Vec3::new(0.0, f32::NAN, 0.0), Vec3::ONE),
        Bounds3::new(Vec3::ZERO, Vec3::new(1.0, 1.0, f32::NAN)),
        Bounds3::new(Vec3::NEG_INFINITY, Vec3::INFINITY),
    ];
    let members: Vec<Claiming> = (0..run.effort.pick(300, 5_000))
        .map(|i| {
            let sphere = Sphere::new(10.0 * random.vector(), 0.5 + random.unit()).expect("a valid sphere");
            let bounds = if i % 7 == 2 { Some(wrong[i / 7 % wrong.len()]) } else { None };
            Claiming {
                sphere: GeometricPrimitive::new(sphere, Surface::of_material(MATERIAL), MediumInterface::VACUUM),
                bounds,
            }
        })
        .collect();
    let good: Vec<usize> = (0..members.len()).filter(|&i| members[i].bounds.is_none()).collect();
    let others: Vec<Claiming> = good.iter().map(|&i| members[i]).collect();
    for config in configs(&LEAVES) {
        let statistics = Statistics::default();
        let all = BvhAggregate::build_observed(members.clone(), &config, &statistics);
        let Some((all, others)) = all.ok().zip(BvhAggregate::build(others.clone(), &config).ok()) else {
            tries.check(false, || label("does not build", &config));
            continue;
        };
        let reported = statistics.0.into_inner().map_or(0, |s| s.inactive_count as usize);
        tries.check(reported == members.len() - good.len(), || format!("{reported} are reported inactive"));
        for _ in 0..run.effort.pick(100, 1_000) {
            let ray = TraversalRay::new(&Ray::new(12.0 * random.vector(), random.direction())).expect("a valid ray");
            let hit = all.intersect(&ray, Interval::FULL);
            let expected = others.intersect(&ray, Interval::FULL);
            let expected = expected.map(|hit| Hit { primitive: good[hit.primitive as usize] as u64, ..hit });
            tries.check(hit == expected, || format!("{:?}: {hit:?}, not {expected:?}", ray.ray()));
        }
    }
    tries.outcome()
}

const MATERIAL: MaterialId = MaterialId::from_index(0).expect("0 is an index");

/// A sphere that may claim bounds that it does not have.
#[derive(Clone, Copy)]
struct Claiming {
    sphere: GeometricPrimitive<Sphere>,
    bounds: Option<Bounds3>,
}

impl Primitive for Claiming {
    fn world_bound(&self) -> Bounds3 {
        self.bounds.unwrap_or_else(|| self.sphere.world_bound())
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, kind: HitKind, visitor: &mut dyn HitVisitor) -> Visit {
        self.sphere.visit_hits(ray, interval, kind, visitor)
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        self.sphere.interaction(ray, hit)
    }
}

/// Keeps what a build reports.
#[derive(Default)]
struct Statistics(Mutex<TreeStatistics>);

impl BuildObserver for Statistics {
    fn built(&self, statistics: &TreeStatistics) {
        if let Ok(mut mine) = self.0.lock() {
            *mine = *statistics;
        }
    }
}
