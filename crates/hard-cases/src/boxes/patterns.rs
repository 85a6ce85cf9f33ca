//! S22, S23: all bits that a ray can have.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TraversalRay};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::judge::Judge;
use crate::build::meshes::cuboid;
use crate::{Effort, Outcome, Random, Run, Tries};

/// A ray and its interval as the caller wrote them: ox oy oz dx dy dz tmin tmax.
type Fields = [f32; 8];

const NAMES: [&str; 8] = ["ox", "oy", "oz", "dx", "dy", "dz", "tmin", "tmax"];

/// All values of a field.
const ALL: u64 = 1 << 32;

/// How many are done between two reports of progress.
const CHUNK: u64 = 1 << 20;

/// S22: one of the eight fields takes all 2³² values, while the others are those of a ray that hits a box of 12
/// triangles; in quick runs one value of each of 2¹³ stretches, and those around every power of two.
///
/// In full about three quarters of an hour of a core: 0.65 µs a value (Ice Lake).
pub(super) fn one_field<const FIELD: usize>(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 122);
    let base: Fields = [
        0.3 * random.unit(),
        0.3 * random.unit(),
        -2.0 - random.unit(),
        0.1 * random.signed(),
        0.1 * random.signed(),
        1.0 + random.unit(),
        0.1 * random.unit(),
        5.0 + random.unit(),
    ];
    in_chunks(run, 1 << 13, |judge, tries, values| {
        for i in values {
            let mut fields = base;
            fields[FIELD] = f32::from_bits(i as u32);
            answers_as_the_list(judge, tries, &fields, || NAMES[FIELD]);
        }
    })
}

/// S23: eight fields of any bits; in half of the rays each field is one of the special numbers, or an ordinary one.
pub(super) fn any_bits(run: &Run) -> Outcome {
    const SPECIAL: [f32; 12] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
        1e30,
    ];
    in_chunks(run, 1 << 16, |judge, tries, values| {
        // A stream of its own for each value: the outcome does not depend on where the work is cut.
        for i in values {
            let mut random = Random::new(run.seed ^ i, 123);
            let fields: Fields = std::array::from_fn(|_| match (i % 2, random.below(3)) {
                (0, _) => f32::from_bits(random.bits()),
                (_, 0) => 2.0 * random.signed(),
                _ => SPECIAL[random.below(SPECIAL.len())],
            });
            answers_as_the_list(judge, tries, &fields, || "any bits");
        }
    })
}

/// Has `work` done for all numbers of 32 bits, on all threads and with reports of progress; in quick runs for one of
/// each of `stretches`, and those around each change of the exponent.
fn in_chunks(
    run: &Run,
    stretches: u64,
    work: impl Fn(&Judge, &mut Tries, &mut dyn Iterator<Item = u64>) + Sync,
) -> Outcome {
    let mut tries = Tries::new();
    let mesh = cuboid(Vec3::new(-1.0, -0.75, -0.5), Vec3::new(0.5, 1.0, 1.25));
    let Some(judge) = Judge::new(&mut tries, run, mesh) else { return tries.outcome() };
    if run.effort == Effort::Quick {
        let stretch = ALL / stretches;
        work(&judge, &mut tries, &mut (0..ALL).step_by(stretch as usize).map(|i| i + i / stretch % stretch));
        let around = (0..ALL).step_by(1 << 23).flat_map(|i| [i.wrapping_sub(1) % ALL, i, i + 1]);
        work(&judge, &mut tries, &mut around.into_iter());
        return tries.outcome();
    }
    let done = AtomicU64::new(0);
    let chunk = |i: u64| {
        let mut tries = Tries::new();
        let mut values: Range<u64> = i * CHUNK..(i + 1) * CHUNK;
        work(&judge, &mut tries, &mut values);
        let done = done.fetch_add(CHUNK, Ordering::Relaxed) + CHUNK;
        (run.progress)(done as f64 / ALL as f64);
        tries
    };
    let all: Vec<Tries> = (0..ALL / CHUNK).into_par_iter().map(chunk).collect();
    all.into_iter().fold(tries, Tries::and).outcome()
}

/// A ray is refused where it must be; else it is answered as by the list of triangles, closest and any hit, without
/// NaN.
fn answers_as_the_list(judge: &Judge, tries: &mut Tries, fields: &Fields, what: impl Fn() -> &'static str) {
    let [ox, oy, oz, dx, dy, dz, t_min, t_max] = *fields;
    let ray = Ray::new([ox, oy, oz], [dx, dy, dz]);
    let interval = Interval::new(t_min, t_max);
    let is_valid = fields[..6].iter().all(|x| x.is_finite()) && [dx, dy, dz] != [0.0; 3];
    let traversal = TraversalRay::new(&ray);
    if !is_valid || traversal.is_none() {
        return tries.check(is_valid == traversal.is_some(), || format!("{}: {ray:?} is valid: {is_valid}", what()));
    }
    let Some(traversal) = traversal else { return };
    let hit = judge.shape().intersect(&traversal, interval);
    let holds = hit == judge.alone().intersect(&traversal, interval)
        && judge.shape().intersect_p(&traversal, interval) == hit.is_some()
        && hit.is_none_or(|hit| {
            let p = judge.shape().surface_point(&traversal, &hit);
            let is_within = |x: f32| (0.0..=1.0).contains(&x);
            judge.may_report(hit.t, interval)
                && is_within(hit.u)
                && is_within(hit.v)
                && p.p.is_finite()
                && p.n.is_finite()
                && !p.p_error.is_nan()
        });
    tries.check(holds, || format!("{}: {ray:?} {interval:?} gives {hit:?}", what()));
}
