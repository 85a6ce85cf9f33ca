//! What is no instance: matrices that are refused, cycles, and instances of nothing.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BvhAggregate};
use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{Interval, MAX_COORDINATE, Ray, Sphere, Transform, TransformError, TraversalRay, TriangleMesh};
use primitive::{Primitive, TransformedPrimitive};
use scene::{SceneBuilder, SceneError};

use super::placed::{AnyPrimitive, mesh_primitive};
use super::single::rotation;
use crate::spheres::{Trials, ball};
use crate::{Outcome, Random, Run};

/// I07: one, two and three zero scales, and matrices of rank one and two, turned and translated.
pub(super) fn singular(run: &Run) -> Outcome {
    let mut trials = Trials::default();
    let mut random = Random::new(run.seed, 107 << 32);
    let mut refuse = |matrix: DMat3| {
        for translation in [DVec3::ZERO, DVec3::new(1.0, -2.0, 3e5)] {
            let made = Transform::from_affine(DAffine3::from_mat3_translation(matrix, translation));
            let refused = matches!(made, Err(TransformError::Singular { .. }));
            trials.check(refused, || format!("{matrix} {translation}: {made:?}"));
        }
    };
    for zeros in 1..8 {
        let scale = DVec3::from_array([0, 1, 2].map(|i| if zeros >> i & 1 == 1 { 0.0 } else { 2.5 }));
        refuse(DMat3::from_diagonal(scale));
        refuse(DMat3::from_diagonal(-scale));
        for _ in 0..run.effort.pick(100, 100_000) {
            refuse(rotation(&mut random) * DMat3::from_diagonal(scale));
            refuse(rotation(&mut random) * DMat3::from_diagonal(scale) * rotation(&mut random));
        }
    }
    for _ in 0..run.effort.pick(1000, 1_000_000) {
        let whole = |random: &mut Random| (random.vector() * 100.0).round().as_dvec3();
        let (a, b, k) = (whole(&mut random), whole(&mut random), whole(&mut random));
        refuse(DMat3::from_cols(a * k.x, a * k.y, a * k.z));
        refuse(DMat3::from_cols(a, b, a * k.x + b * k.y));
        refuse(DMat3::from_cols(a, b, a * k.x + b * k.y).transpose());
    }
    trials.outcome()
}

/// I16: NaN and infinities in every place, and every other last row.
pub(super) fn not_a_map(_: &Run) -> Outcome {
    let mut trials = Trials::default();
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in 0..16 {
            let mut rows = identity;
            rows[place / 4][place % 4] = bad;
            let made = Transform::from_rows(rows);
            trials.check(matches!(made, Err(TransformError::NotFinite)), || format!("{rows:?}: {made:?}"));
        }
        for place in 0..12 {
            let mut columns = DAffine3::IDENTITY.to_cols_array();
            columns[place] = bad;
            let made = Transform::from_affine(DAffine3::from_cols_array(&columns));
            trials.check(matches!(made, Err(TransformError::NotFinite)), || format!("{columns:?}: {made:?}"));
        }
        let made = [
            Transform::translate(DVec3::Y * bad),
            Transform::rotate(bad, DVec3::Y),
            Transform::rotate(30.0, DVec3::X * bad),
        ];
        trials.check(made.iter().all(Result::is_err), || format!("{bad}: {made:?}"));
    }
    for (place, value) in [(0, 1e-30), (1, -1.0), (2, 0.5), (3, 0.0), (3, 2.0), (3, -1.0), (3, 1.0 + f64::EPSILON)] {
        let mut rows = identity;
        rows[3][place] = value;
        let made = Transform::from_rows(rows);
        trials.check(matches!(made, Err(TransformError::NotAffine(_))), || format!("{rows:?}: {made:?}"));
    }
    for zero in [DVec3::ZERO, DVec3::splat(1e-320)] {
        let made = Transform::rotate(30.0, zero);
        trials.check(made.is_err(), || format!("rotation about {zero}: {made:?}"));
    }
    // What overflows in the making.
    let large = Transform::scale(DVec3::splat(1e200));
    let twice = large.and_then(|t| t.then_inside(&t));
    trials.check(twice.is_err(), || format!("1e200 twice: {twice:?}"));
    trials.outcome()
}

/// I15: an object in itself, in one inside of it, and in one that is only begun later; and what is no cycle.
pub(super) fn cycles(_: &Run) -> Outcome {
    let mut trials = Trials::default();
    let mut check = |what: &str, made: Result<(), SceneError>, allowed: bool| {
        let right = if allowed { made.is_ok() } else { matches!(made, Err(SceneError::Cycle(_))) };
        trials.check(right, || format!("{what}: {made:?}"));
    };
    let mut scene = SceneBuilder::new();
    check("the world in itself", scene.add_instance(scene::ObjectId::WORLD, Transform::IDENTITY), false);
    let mut open = Vec::new();
    for depth in 0..100 {
        if let Ok(object) = scene.begin_object(format!("{depth}")) {
            open.push(object);
            for &around in &open {
                check("an object that is open", scene.add_instance(around, Transform::IDENTITY), false);
            }
            check("the world", scene.add_instance(scene::ObjectId::WORLD, Transform::IDENTITY), false);
        }
    }
    while let Some(done) = open.pop() {
        scene.end_object();
        for &around in &open {
            check("an object around", scene.add_instance(around, Transform::IDENTITY), false);
        }
        check("an object that is complete", scene.add_instance(done, Transform::IDENTITY), true);
    }
    // A uses B, which is complete; B can no longer use A, since it cannot be opened again.
    scene.end_object();
    check("in the world", open.pop().map_or(Ok(()), |o| scene.add_instance(o, Transform::IDENTITY)), true);
    let scene = scene.finish();
    let acyclic =
        scene.objects().iter().enumerate().all(|(i, o)| o.instances.iter().all(|inner| inner.object.index() != i));
    trials.check(acyclic, || "an object instances itself".into());
    let built = scene::CompiledScene::build(scene, &BuildConfig::default(), &());
    trials.check(built.is_ok(), || format!("{:?}", built.err()));
    trials.outcome()
}

/// I14: instances of what cannot be hit are not hit, and change nothing for what stands beside them.
pub(super) fn of_nothing(run: &Run) -> Outcome {
    let mut trials = Trials::default();
    let mut random = Random::new(run.seed, 114 << 32);
    let bad = [f32::NAN, f32::INFINITY, MAX_COORDINATE.next_up(), f32::MAX];
    let mesh = |x: f32| {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, x, 0.0)];
        TriangleMesh::new(positions, vec![[0, 1, 2]]).ok().and_then(|m| mesh_primitive(&Arc::new(m)))
    };
    let mut nothing: Vec<AnyPrimitive> = bad.iter().filter_map(|&x| mesh(x)).collect();
    nothing.extend(TriangleMesh::new([Vec3::ZERO; 0], Vec::new()).ok().and_then(|m| mesh_primitive(&Arc::new(m))));
    nothing.extend(Sphere::new(Vec3::ZERO, f32::MAX).ok().and_then(ball).map(|b| Arc::new(b) as AnyPrimitive));
    let empty = BvhAggregate::<AnyPrimitive>::build(Vec::new(), &BuildConfig::default());
    nothing.extend(empty.ok().map(|e| Arc::new(e) as AnyPrimitive));
    let all = BvhAggregate::build(nothing.clone(), &BuildConfig::default());
    nothing.extend(all.ok().map(|a| Arc::new(a) as AnyPrimitive));
    trials.check(nothing.len() == 8, || format!("{} of 8 were made", nothing.len()));
    let Some(real) = Sphere::new(Vec3::Z, 0.5).ok().and_then(ball) else { return trials.outcome() };
    let mut members: Vec<AnyPrimitive> = vec![Arc::new(real)];
    for _ in 0..3 {
        // Each time behind one more transform.
        nothing = nothing
            .into_iter()
            .filter_map(|inner| {
                let matrix = DAffine3::from_mat3_translation(rotation(&mut random), random.vector().as_dvec3());
                let placed = TransformedPrimitive::new(inner, Transform::from_affine(matrix).ok()?);
                Some(Arc::new(placed) as AnyPrimitive)
            })
            .collect();
        members.extend(nothing.iter().cloned());
    }
    let Ok(together) = BvhAggregate::build(members, &BuildConfig::default()) else { return trials.outcome() };
    let bounds = together.world_bound();
    trials.check(bounds == real.world_bound(), || format!("the box {bounds:?} is poisoned"));
    for _ in 0..run.effort.pick(2000, 100_000) {
        let o = 3.0 * random.direction();
        let Some(ray) = TraversalRay::new(&Ray::new(o, Vec3::Z + random.vector() - o)) else { continue };
        let hits: Vec<_> = nothing.iter().filter_map(|inner| inner.intersect(&ray, Interval::FULL)).collect();
        trials.check(hits.is_empty(), || format!("{:?} hits nothing: {hits:?}", ray.ray()));
        let (alone, beside) = (real.intersect(&ray, Interval::FULL), together.intersect(&ray, Interval::FULL));
        trials.check(alone == beside, || format!("{:?}: {beside:?}, alone {alone:?}", ray.ray()));
    }
    trials.outcome()
}
