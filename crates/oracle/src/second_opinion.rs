//! A second, independent implementation in tests: the oracle's own oracle.
//!
//! Nothing is shared but the inputs. Floats are decoded from their bits and scaled by 2¹⁴⁹ to integers; the plane is
//! met by Cramer's rule, and barycentrics decide instead of edge functions. Instances and spheres ([`rational`]) are
//! done in rational numbers.

mod rational;

use std::ops::{Add, Mul, Sub};

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TriangleMesh};
use num_bigint::BigInt;
use num_rational::Ratio;

use crate::dyadic::Dyadic;
use crate::random::{Random, hard_case};
use crate::{Closest, ExactReal, MeshOracle, Oracle, Tally};

type Rational = Ratio<BigInt>;

/// x · 2¹⁴⁹.
fn integer(x: f32) -> BigInt {
    let bits = x.to_bits();
    let (exponent, fraction) = (bits >> 23 & 0xff, bits & 0x7f_ffff);
    let magnitude =
        if exponent == 0 { BigInt::from(fraction) } else { BigInt::from(fraction | 1 << 23) << (exponent - 1) };
    if bits >> 31 == 1 { -magnitude } else { magnitude }
}

trait Number: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}
impl<T: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>> Number for T {}

fn minus<T: Number>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [0, 1, 2].map(|i| a[i].clone() - b[i].clone())
}

/// The determinant of three columns, by the rule of Sarrus.
fn determinant<T: Number>(a: &[T; 3], b: &[T; 3], c: &[T; 3]) -> T {
    let term = |i: usize, j: usize, k: usize| a[i].clone() * b[j].clone() * c[k].clone();
    term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1) - term(2, 1, 0) - term(1, 0, 2) - term(0, 2, 1)
}

/// The determinants (D, D_u, D_v, D_t) of v₀ + u (v₁ − v₀) + v (v₂ − v₀) = o + t d.
fn cramer<T: Number>(o: &[T; 3], d: &[T; 3], v: &[[T; 3]; 3]) -> [T; 4] {
    let (e1, e2, s) = (minus(&v[1], &v[0]), minus(&v[2], &v[0]), minus(o, &v[0]));
    let back = minus(&minus(d, d), d);
    [determinant(&e1, &e2, &back), determinant(&s, &e2, &back), determinant(&e1, &s, &back), determinant(&e1, &e2, &s)]
}

/// t of the hit, from Cramer's determinants; in integers up to t, since the common divisors of rational numbers are
/// slow.
fn hit_of_integers(determinants: [BigInt; 4], interval: Interval) -> Option<Rational> {
    let zero = BigInt::ZERO;
    let [det, u, v, t] = determinants;
    if det == zero {
        return None;
    }
    let [det, u, v, t] = if det < zero { [-det, -u, -v, -t] } else { [det, u, v, t] };
    if u < zero || v < zero || u + v > det {
        return None;
    }
    let above = |x: f32| &t << 149_u32 > integer(x) * &det;
    let below = |x: f32| &t << 149_u32 < integer(x) * &det;
    let is_in_interval = above(interval.t_min()) && (interval.t_max() == f32::INFINITY || below(interval.t_max()));
    is_in_interval.then(|| Rational::new_raw(t, det))
}

fn exact(t: &Rational) -> ExactReal {
    ExactReal::ratio(Dyadic::from_integer(t.numer().clone()), Dyadic::from_integer(t.denom().clone()))
}

/// The closest of all triangles of a mesh.
fn closest(mesh: &TriangleMesh, ray: &Ray, interval: Interval) -> Option<(Rational, Vec<u64>)> {
    let (o, d) = (ray.origin.to_array().map(integer), ray.direction.to_array().map(integer));
    let mut best: Option<(Rational, Vec<u64>)> = None;
    for i in 0..mesh.len() {
        let v = mesh.vertices(i).map(|v| v.to_array().map(integer));
        let Some(t) = hit_of_integers(cramer(&o, &d, &v), interval) else { continue };
        match &mut best {
            Some((least, ids)) if t == *least => ids.push(i as u64),
            Some((least, _)) if t > *least => {}
            _ => best = Some((t, vec![i as u64])),
        }
    }
    best
}

fn agree(ours: &Option<Closest>, theirs: &Option<(Rational, Vec<u64>)>) -> bool {
    match (ours, theirs) {
        (None, None) => true,
        (Some(ours), Some((t, ids))) => ours.t == exact(t) && ours.primitives == *ids,
        _ => false,
    }
}

/// Hard triangles in one mesh of `size`, with neighbours at edges and vertices, copies among them.
fn hard_mesh(random: &mut Random, kind: usize, size: usize) -> (Vec<(Ray, Interval)>, TriangleMesh) {
    let (mut rays, mut positions, mut triangles) = (Vec::new(), Vec::new(), Vec::<[u32; 3]>::new());
    for _ in 0..size {
        let (ray, interval, v) = hard_case(random, kind);
        rays.push((ray, interval));
        let first = positions.len() as u32;
        positions.extend(v);
        triangles.push([first, first + 1, first + 2]);
        if random.below(3) == 0 {
            let pick = |random: &mut Random| random.below(first + 3);
            triangles.push([first + 1, first, pick(random)]);
            triangles.push([pick(random), first + 2, first]);
            triangles.push([first + 2, first, first + 1]);
        }
    }
    (rays, TriangleMesh::new(positions, triangles).expect("indices are in range"))
}

fn compare(seed: u64, cases: usize) -> Tally {
    let mut random = Random::new(seed);
    let (mut tally, mut count, mut ray_count, mut hits) = (Tally::default(), 0, 0, 0);
    for kind in (0..10).cycle() {
        let size = 1 + random.below(6) as usize;
        let (rays, mesh) = hard_mesh(&mut random, kind, size);
        let oracle = MeshOracle::new(&mesh);
        for (ray, interval) in rays {
            if ray.direction == Vec3::ZERO {
                continue;
            }
            let theirs = closest(&mesh, &ray, interval);
            let ours = oracle.closest(&ray, interval, &mut tally);
            assert!(agree(&ours, &theirs), "kind {kind}: {ray:?} {interval:?} {mesh:?}\n{ours:?}\n{theirs:?}");
            assert_eq!(oracle.any(&ray, interval, &mut tally), theirs.is_some());
            hits += usize::from(theirs.is_some());
            ray_count += 1;
            // One case is one ray against one triangle.
            count += mesh.len();
        }
        if count >= cases {
            break;
        }
    }
    assert!(hits * 4 > ray_count, "{hits} hits of {ray_count} rays");
    tally
}

#[test]
fn hard_triangles() {
    let tally = compare(11, 100_000);
    assert!(tally.exact > 1000 && tally.filtered > 1000, "{tally:?}");
}

/// The same, more: `cargo test -p oracle -- --ignored`.
#[test]
#[ignore = "takes a minute"]
fn hard_triangles_at_length() {
    for seed in 100..120 {
        compare(seed, 100_000);
    }
}

#[test]
fn all_hits_are_found_in_order() {
    let mut random = Random::new(13);
    for kind in 0..200 {
        let (rays, mesh) = hard_mesh(&mut random, kind, 5);
        let oracle = MeshOracle::new(&mesh);
        for (ray, interval) in rays.into_iter().filter(|(ray, _)| ray.direction != Vec3::ZERO) {
            let (o, d) = (ray.origin.to_array().map(integer), ray.direction.to_array().map(integer));
            let triangle = |i: usize| mesh.vertices(i).map(|v| v.to_array().map(integer));
            let hit = |i: usize| Some((hit_of_integers(cramer(&o, &d, &triangle(i)), interval)?, i as u64));
            let mut theirs: Vec<_> = (0..mesh.len()).filter_map(hit).collect();
            theirs.sort();
            let ours = oracle.all_hits(&ray, interval, &mut Tally::default());
            assert_eq!(ours.len(), theirs.len());
            for (ours, theirs) in ours.iter().zip(&theirs) {
                assert!(ours.primitive == theirs.1 && ours.t == exact(&theirs.0));
            }
        }
    }
}
