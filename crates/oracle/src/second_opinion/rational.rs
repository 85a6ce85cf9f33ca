//! Instances and spheres in rational numbers: the ray goes back by an inverse matrix, where the oracle goes forward.

use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{Interval, Ray, Sphere, TriangleMesh};
use num_bigint::BigInt;

use super::{Rational, agree, cramer, determinant, minus};
use crate::random::{Random, hard_case};
use crate::{ExactTransform, MeshOracle, Oracle, SphereOracle, Tally};

fn rational(x: f64) -> Rational {
    let bits = x.to_bits();
    let (exponent, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    let magnitude = BigInt::from(if exponent == 0 { fraction } else { fraction | 1 << 52 });
    let magnitude = if bits >> 63 == 1 { -magnitude } else { magnitude };
    let power = exponent.max(1) - 1075;
    let scale = BigInt::from(1) << power.unsigned_abs();
    if power < 0 { Rational::new(magnitude, scale) } else { Rational::from_integer(magnitude * scale) }
}

/// t of the hit, from Cramer's determinants.
fn hit_of(determinants: [Rational; 4], interval: Interval) -> Option<Rational> {
    let [det, u, v, t] = determinants;
    let zero = rational(0.0);
    if det == zero {
        return None;
    }
    let (u, v, t) = (u / &det, v / &det, t / &det);
    let is_inside = u >= zero && v >= zero && u + v <= rational(1.0);
    let is_beyond = interval.t_max() == f32::INFINITY || t < rational(interval.t_max().into());
    (is_inside && t > rational(interval.t_min().into()) && is_beyond).then_some(t)
}

fn random_matrix(random: &mut Random) -> DAffine3 {
    let entry = |r: &mut Random| if r.below(4) == 0 { r.lattice() } else { r.wild(-8, 8) };
    let [x, y, z, w] = [0, 1, 2, 3].map(|_| DVec3::from_array(random.array(entry)));
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), w)
}

/// Linear part by columns, and translation.
type RationalMap = ([[Rational; 3]; 3], [Rational; 3]);

fn rational_map(m: &DAffine3) -> RationalMap {
    let v = |v: DVec3| v.to_array().map(rational);
    ([v(m.matrix3.x_axis), v(m.matrix3.y_axis), v(m.matrix3.z_axis)], v(m.translation))
}

/// M⁻¹ v by Cramer's rule; `None` where M is singular.
fn solve([x, y, z]: &[[Rational; 3]; 3], v: &[Rational; 3]) -> Option<[Rational; 3]> {
    let det = determinant(x, y, z);
    let [a, b, c] = [determinant(v, y, z), determinant(x, v, z), determinant(x, y, v)];
    (det != rational(0.0)).then(|| [a / &det, b / &det, c / &det])
}

/// The ray in the space inside of all maps, the outermost first.
fn ray_inside(maps: &[DAffine3], ray: &Ray) -> Option<([Rational; 3], [Rational; 3])> {
    let start = [ray.origin, ray.direction].map(|v| v.as_dvec3().to_array().map(rational));
    maps.iter().map(rational_map).try_fold(start.into(), |(o, d), (linear, translation)| {
        Some((solve(&linear, &minus(&o, &translation))?, solve(&linear, &d)?))
    })
}

fn nested(maps: &[DAffine3]) -> ExactTransform {
    let exact = maps.iter().map(|m| ExactTransform::new(m).expect("finite"));
    exact.reduce(|outer, inner| outer.then_inside(&inner)).expect("at least one")
}

#[test]
fn instances() {
    let mut random = Random::new(17);
    let (mut hits, mut tally) = (0, Tally::default());
    for i in 0..240 {
        let maps: Vec<DAffine3> = (0..1 + i % 3).map(|_| random_matrix(&mut random)).collect();
        let (_, interval, v) = hard_case(&mut random, i);
        let mesh = TriangleMesh::new(v.to_vec(), vec![[0, 1, 2]]).expect("indices are in range");
        // Aimed at the image of an edge, of a vertex or of the middle.
        let image = maps.iter().rev().fold(v.map(|v| v.as_dvec3()), |v, m| v.map(|v| m.transform_point3(v)));
        let b = [DVec3::splat(1.0 / 3.0), DVec3::X, DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.1, 0.2, 0.7)][i / 10 % 4];
        let target = b.x * image[0] + b.y * image[1] + b.z * image[2];
        let origin = random.vec3(|r| r.wild(-3, 6));
        let ray = Ray::new(origin, target.as_vec3() - origin);
        let theirs = ray_inside(&maps, &ray).and_then(|(o, d)| {
            let v = v.map(|v| v.as_dvec3().to_array().map(rational));
            hit_of(cramer(&o, &d, &v), interval)
        });
        let oracle = MeshOracle::instance(&mesh, nested(&maps));
        let ours = oracle.closest(&ray, interval, &mut tally);
        assert!(agree(&ours, &theirs.map(|t| (t, vec![0]))), "{maps:?} {ray:?} {v:?}");
        hits += usize::from(ours.is_some());
    }
    assert!(hits > 60 && tally.exact > 10 && tally.filtered > 30, "{hits} {tally:?}");
}

/// |o + t d − c|² − r².
fn distance_squared(o: &[Rational; 3], d: &[Rational; 3], sphere: &Sphere, t: &Rational) -> Rational {
    let c = sphere.center().as_dvec3().to_array().map(rational);
    let r = rational(sphere.radius().into());
    let f = [0, 1, 2].map(|i| o[i].clone() + t * &d[i] - &c[i]);
    f.iter().map(|x| x * x).fold(rational(0.0), |sum, x| sum + x) - &r * &r
}

/// The function of the squared distance has a root between the two floats around each claimed t, and as many roots as
/// were claimed.
#[test]
fn spheres() {
    let mut random = Random::new(19);
    let zero = rational(0.0);
    let mut seen = [0; 3];
    for i in 0..1500 {
        let wild = i % 3 == 0;
        let r = if wild { random.wild(-20, 20).abs() } else { 1.0 + f64::from(random.below(4)) };
        let coordinate = |r: &mut Random| if wild { r.wild(-20, 20) } else { r.lattice() };
        let sphere = Sphere::new(random.vec3(coordinate), r as f32).expect("valid");
        let maps = if i % 5 == 0 { vec![random_matrix(&mut random)] } else { Vec::new() };
        // Tangent in one axis, up to a few ulp, or exactly.
        let origin = random.vec3(coordinate);
        let mut target = sphere.center();
        target[i % 3] += sphere.radius() * (1.0 + random.lattice() as f32 * f32::EPSILON);
        let ray = match i % 4 {
            0 => Ray::new(origin, target - origin),
            1 => Ray::new(target.with_x(origin.x), Vec3::X),
            _ => Ray::new(origin, random.vec3(coordinate)),
        };
        let Some((o, d)) = ray_inside(&maps, &ray) else { continue };
        if ray.direction == Vec3::ZERO {
            continue;
        }
        let value = |t: &Rational| distance_squared(&o, &d, &sphere, t);
        let oracle =
            if maps.is_empty() { SphereOracle::new(&sphere) } else { SphereOracle::instance(&sphere, nested(&maps)) };
        let hits = oracle.all_hits(&ray, Interval::FULL, &mut Tally::default());
        for hit in &hits {
            let [low, high] = hit.t.range().map(rational);
            let (low, high) = (value(&low), value(&high));
            assert!(
                &low * &high <= zero || hits.len() == 2 && hits[0].t.range() == hits[1].t.range(),
                "{sphere:?} {ray:?}"
            );
        }
        // The least distance is at t = −b / a.
        let c = sphere.center().as_dvec3().to_array().map(rational);
        let dot = |a: &[Rational; 3], b: &[Rational; 3]| (0..3).fold(rational(0.0), |sum, i| sum + &a[i] * &b[i]);
        let nearest = dot(&minus(&c, &o), &d) / dot(&d, &d);
        let (least, start) = (value(&nearest), value(&zero));
        let count = if nearest > zero && start > zero {
            if least < zero { 2 } else { usize::from(least == zero) }
        } else {
            usize::from(start < zero || (start == zero && nearest > zero))
        };
        assert_eq!(hits.len(), count, "{sphere:?} {ray:?}");
        seen[count] += 1;
    }
    assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
}
