//! The catalogue is worth what it catches: kernels that are deliberately damaged, each in one way that ray tracers are,
//! must fail. The library passes every case, and its binary tree with watertight kernels, which most of them are made
//! of, those that are named here: the crate's own tests say so.

use std::ops::ControlFlow;
use std::sync::Arc;

use bvh_flat::{BuildConfig, BuildError, MeshBvh, WideMesh};
use geometry::glam::Vec3;
use geometry::{
    Bounds3, Hit, HitVisitor, Interval, Kernels, MollerTrumboreTriangles, Shape, SurfacePoint, TraversalRay,
    TriangleHit, TriangleMesh, UnpaddedBoxes, Visit, intersect_triangle,
};
use hard_cases::{AnyShape, BinaryWatertight, Case, Effort, Library, Outcome, Run, Subject, cases};

/// A subject made of a function from the library's binary tree with watertight kernels.
struct Damaged {
    name: &'static str,
    damage: fn(MeshBvh) -> AnyShape,
}

impl Subject for Damaged {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok((self.damage)(MeshBvh::build(mesh, &BuildConfig::default())?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        BinaryWatertight::default().without_tree(mesh)
    }

    fn is_exact(&self) -> bool {
        false
    }
}

/// A subject made of a function from the library's wide tree, which promises to be exact.
struct DamagedWide {
    name: &'static str,
    damage: fn(WideMesh) -> AnyShape,
}

impl Subject for DamagedWide {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok((self.damage)(WideMesh::build(mesh, &BuildConfig::default())?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        Library::default().without_tree(mesh)
    }

    fn is_exact(&self) -> bool {
        true
    }
}

fn with_kernels<K: Kernels + Sync>(name: &'static str) -> Damaged {
    Damaged { name, damage: |bvh| Box::new(bvh.with_kernels::<K>()) }
}

macro_rules! kernels {
    ($($(#[$doc:meta])* $name:ident: $enter:path, $triangle:path;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        struct $name;

        impl Kernels for $name {
            fn enter(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32> {
                $enter(ray, bounds, interval)
            }

            fn intersect_triangle(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
                $triangle(ray, v, interval)
            }
        }
    )*};
}

kernels! {
    /// A padded box test that orders planes by `d >= 0`, and has an infinity of the wrong sign for −0.
    OctantByComparison: enter_by_comparison, intersect_triangle;
    /// Edge functions in f32 of which the compiler has fused one product.
    ContractedEdges: TraversalRay::enter, contracted_edges;
    /// The same kernel with edge functions that are not damaged.
    SoundEdges: TraversalRay::enter, sound_edges;
    /// pbrt's error bound on t, below which hits are rejected.
    RejectedByDeltaT: TraversalRay::enter, rejected_by_delta_t;
    /// The Plücker test of Embree's robust mode, with its tolerance.
    TolerantPluecker: TraversalRay::enter, tolerant_pluecker;
    /// A determinant below 10⁻⁶ is parallel.
    AbsoluteEpsilon: TraversalRay::enter, absolute_epsilon;
}

fn enter_by_comparison(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let (mut entry, mut exit) = (interval.t_min(), interval.t_max().min(f32::MAX));
    for i in 0..3 {
        let (near, far) = if d[i] >= 0.0 { (bounds.min[i], bounds.max[i]) } else { (bounds.max[i], bounds.min[i]) };
        let padding = 6.0 * f32::EPSILON;
        let near = (near - o[i]) * (d[i].recip() * (1.0 - padding)).clamp(-f32::MAX, f32::MAX);
        let far = (far - o[i]) * (d[i].recip() * (1.0 + padding));
        entry = if near > entry { near } else { entry };
        exit = if far < exit { far } else { exit };
    }
    (entry <= exit).then_some(entry)
}

/// Woop's test with the vertices sheared in f32.
fn woop(
    ray: &TraversalRay,
    v: &[Vec3; 3],
    interval: Interval,
    edge: impl Fn([f32; 2], [f32; 2]) -> f64,
) -> Option<TriangleHit> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let kz = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs()))?;
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let p = v.map(|v| v - o);
    let [a, b, c] = p.map(|p| [p[kx] - d[kx] / d[kz] * p[kz], p[ky] - d[ky] / d[kz] * p[kz]]);
    let e = [edge(c, b), edge(a, c), edge(b, a)];
    let det = e[0] + e[1] + e[2];
    if (e.iter().any(|e| *e < 0.0) && e.iter().any(|e| *e > 0.0)) || det == 0.0 {
        return None;
    }
    let z = p.map(|p| f64::from(p[kz]) / f64::from(d[kz]));
    let t = ((e[0] * z[0] + e[1] * z[1] + e[2] * z[2]) / det) as f32;
    interval.contains(t).then_some(TriangleHit { t, u: (e[1] / det) as f32, v: (e[2] / det) as f32 })
}

fn sound_edges(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    woop(ray, v, interval, |p, q| f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0]))
}

fn contracted_edges(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    woop(ray, v, interval, |p, q| p[0].mul_add(q[1], -(p[1] * q[0])).into())
}

/// *Physically Based Rendering*, fourth edition, section 6.8.7.
fn rejected_by_delta_t(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let hit = intersect_triangle(ray, v, interval)?;
    let gamma = |n: f32| n * 0.5 * f32::EPSILON / (1.0 - n * 0.5 * f32::EPSILON);
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let kz = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs()))?;
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let sheared = v.map(|v| {
        let p = v - o;
        Vec3::new(p[kx] - d[kx] / d[kz] * p[kz], p[ky] - d[ky] / d[kz] * p[kz], p[kz] / d[kz])
    });
    let [a, b, c] = sheared;
    let e = Vec3::new(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    let max = a.abs().max(b.abs()).max(c.abs());
    let (delta_x, delta_y, delta_z) = (gamma(5.0) * (max.x + max.z), gamma(5.0) * (max.y + max.z), gamma(3.0) * max.z);
    let delta_e = 2.0 * (gamma(2.0) * max.x * max.y + delta_y * max.x + delta_x * max.y);
    let max_e = e.abs().max_element();
    let det = e.x + e.y + e.z;
    let delta_t = 3.0 * (gamma(3.0) * max_e * max.z + delta_e * max.z + delta_z * max_e) / det.abs();
    (hit.t > delta_t).then_some(hit)
}

/// Embree's `triangle_intersector_pluecker.h`: edge functions relative to the origin, accepted within one ulp of their
/// sum.
fn tolerant_pluecker(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let (o, d) = (ray.ray().origin, ray.ray().direction);
    let [v0, v1, v2] = v.map(|v| v - o);
    let (e0, e1, e2) = (v2 - v0, v0 - v1, v1 - v2);
    let [u, v, w] = [e0.cross(v2 + v0), e1.cross(v0 + v1), e2.cross(v1 + v2)].map(|m| m.dot(d));
    let sum = u + v + w;
    let epsilon = f32::EPSILON * sum.abs();
    if u.min(v).min(w) < -epsilon && u.max(v).max(w) > epsilon {
        return None;
    }
    let n = e0.cross(e1);
    let den = n.dot(d);
    if den == 0.0 {
        return None;
    }
    let t = v0.dot(n) / den;
    interval.contains(t).then(|| TriangleHit { t, u: (u / sum).clamp(0.0, 1.0), v: (v / sum).clamp(0.0, 1.0) })
}

fn absolute_epsilon(ray: &TraversalRay, v: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let det = (v[1] - v[0]).dot(ray.ray().direction.cross(v[2] - v[0]));
    if det.abs() < 1e-6 { None } else { intersect_triangle(ray, v, interval) }
}

/// A shape that hears of hits one by one and keeps the closest by a rule of its own.
struct OwnRule<S, R> {
    shape: S,
    rule: R,
}

impl<S: Shape, R: Fn(&Hit, &Hit) -> bool + Send + Sync> Shape for OwnRule<S, R> {
    fn object_bound(&self) -> Bounds3 {
        self.shape.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.shape.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.shape.visit_hits(ray, interval, visitor)
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let _ = self.shape.visit_hits(ray, interval, &mut |hit: Hit| {
            if closest.as_ref().is_none_or(|best| (self.rule)(&hit, best)) {
                closest = Some(hit);
            }
            ControlFlow::Continue(closest.map_or(interval.t_max(), |best| best.t_max_for_ties()))
        });
        closest
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.shape.surface_point(ray, hit)
    }
}

/// Hit points without their bound: spawned rays start on the surface, on either side of it.
struct WithoutBounds<S>(S);

impl<S: Shape> Shape for WithoutBounds<S> {
    fn object_bound(&self) -> Bounds3 {
        self.0.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.0.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.0.visit_hits(ray, interval, visitor)
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        // A rounded point, of which a renderer believes that it is exact.
        let point = self.0.surface_point(ray, hit);
        SurfacePoint { p: point.p.as_vec3().as_dvec3(), p_error: Default::default(), ..point }
    }
}

/// The filter of eight triangles, for one: edge functions of vertices sheared in f32, against a bound on their error. A
/// hit that it rules out is lost.
struct Filtered {
    wide: WideMesh,
    /// The bound, of the triangle's largest extent D and the depth |A_z| of its first vertex.
    error: fn(f32, f32) -> f32,
}

/// Half the spacing of f32 at 1.
const U: f32 = f32::EPSILON / 2.0;

/// What it was at first: without the product of the errors of two coordinates, which counts where D is below u |A_z|.
fn error_without_products(d: f32, az: f32) -> f32 {
    U * d * (64.0 * az + 144.0 * d)
}

fn sound_error(d: f32, az: f32) -> f32 {
    error_without_products(d, az) + 256.0 * U * U * az * az
}

impl Filtered {
    fn is_ruled_out(&self, ray: &TraversalRay, hit: &Hit) -> bool {
        let v = self.wide.mesh().vertices(hit.primitive as usize);
        let (o, shear) = (ray.ray().origin, ray.shear());
        let [a, b, c] = v.map(|v| {
            let p = v - o;
            [p[shear.kx] - shear.sx * p[shear.kz], p[shear.ky] - shear.sy * p[shear.kz]]
        });
        let edge = |p: [f32; 2], q: [f32; 2]| p[0].mul_add(q[1], -(p[1] * q[0]));
        let e = [edge(c, b), edge(a, c), edge(b, a)];
        let extent = Bounds3::from_points(v).diagonal().max_element();
        let error = (self.error)(extent, (v[0] - o)[shear.kz].abs());
        e.iter().any(|e| *e < -error) && e.iter().any(|e| *e > error)
    }
}

impl Shape for Filtered {
    fn object_bound(&self) -> Bounds3 {
        self.wide.object_bound()
    }

    fn primitive_count(&self) -> u64 {
        self.wide.primitive_count()
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        self.wide.visit_hits(ray, interval, visitor)
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        self.wide.intersect(ray, interval).filter(|hit| !self.is_ruled_out(ray, hit))
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        self.intersect(ray, interval).is_some()
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.wide.surface_point(ray, hit)
    }
}

fn run(case: &Case, subject: &dyn Subject) -> Outcome {
    (case.run)(&Run { effort: Effort::Quick, seed: 1, subject, progress: &|_| () })
}

/// Each of `ids` fails on the subject.
fn caught_by(subject: &dyn Subject, ids: &[&str]) {
    let cases = cases();
    for id in ids {
        let case = cases.iter().find(|case| case.id == *id).expect("the catalogue has the case");
        let outcome = run(case, subject);
        assert!(outcome.trials > 0 && !outcome.passed(), "{}, {id}: {outcome:?}", subject.name());
    }
}

#[test]
fn boxes_without_padding() {
    caught_by(&with_kernels::<UnpaddedBoxes>("no padding"), &["T02"]);
}

#[test]
fn octants_by_comparison() {
    caught_by(&with_kernels::<OctantByComparison>("octant from d >= 0"), &["T05"]);
}

/// The same kernel without the contraction leaks nothing there.
#[test]
fn contracted_edge_functions() {
    caught_by(&with_kernels::<ContractedEdges>("contracted edges"), &["T01"]);
    let sound = with_kernels::<SoundEdges>("edges in f64");
    let t01 = cases().into_iter().find(|case| case.id == "T01").expect("the catalogue has T01");
    let outcome = run(&t01, &sound);
    assert!(outcome.figures.contains(&("leaks", 0.0)), "{outcome:?}");
}

#[test]
fn hits_rejected_by_an_error_bound_on_t() {
    caught_by(&with_kernels::<RejectedByDeltaT>("deltaT"), &["T03"]);
}

#[test]
fn tolerant_pluecker_coordinates() {
    caught_by(&with_kernels::<TolerantPluecker>("Plücker with a tolerance"), &["T03"]);
}

/// With the product the same filter loses nothing there.
#[test]
fn an_error_bound_without_the_product_of_two_errors() {
    let damage = |wide| -> AnyShape { Box::new(Filtered { wide, error: error_without_products }) };
    caught_by(&DamagedWide { name: "first-order bound", damage }, &["T25"]);
    let sound = |wide| -> AnyShape { Box::new(Filtered { wide, error: sound_error }) };
    let sound = DamagedWide { name: "second-order bound", damage: sound };
    let t25 = cases().into_iter().find(|case| case.id == "T25").expect("the catalogue has T25");
    let outcome = run(&t25, &sound);
    assert!(outcome.passed(), "{outcome:?}");
}

#[test]
fn moller_trumbore() {
    caught_by(&with_kernels::<MollerTrumboreTriangles>("Möller and Trumbore"), &["T01", "T02"]);
}

#[test]
fn an_absolute_epsilon() {
    caught_by(&with_kernels::<AbsoluteEpsilon>("|det| < 1e-6"), &["T07"]);
}

/// Of equal t, the one found first, or the one found last.
#[test]
fn ties_by_the_order_of_finding() {
    let first = |bvh| -> AnyShape { Box::new(OwnRule { shape: bvh, rule: |hit: &Hit, best: &Hit| hit.t < best.t }) };
    let last = |bvh| -> AnyShape { Box::new(OwnRule { shape: bvh, rule: |hit: &Hit, best: &Hit| hit.t <= best.t }) };
    caught_by(&Damaged { name: "first found", damage: first }, &["T05", "T12"]);
    caught_by(&Damaged { name: "last found", damage: last }, &["T05", "T12"]);
    let first = |wide| -> AnyShape { Box::new(OwnRule { shape: wide, rule: |hit: &Hit, best: &Hit| hit.t < best.t }) };
    let last = |wide| -> AnyShape { Box::new(OwnRule { shape: wide, rule: |hit: &Hit, best: &Hit| hit.t <= best.t }) };
    caught_by(&DamagedWide { name: "wide, first found", damage: first }, &["T05", "T12"]);
    caught_by(&DamagedWide { name: "wide, last found", damage: last }, &["T05", "T12"]);
}

/// Of hits whose t round to the same number, the smaller primitive, though the other is closer.
#[test]
fn closest_by_the_rounded_t() {
    let damage = |wide| -> AnyShape { Box::new(OwnRule { shape: wide, rule: Hit::is_before }) };
    caught_by(&DamagedWide { name: "rounded t", damage }, &["T20"]);
}

/// Watertight kernels that claim to be exact: nothing is excused.
#[test]
fn watertight_is_not_exact() {
    let damage = |wide: WideMesh| -> AnyShape {
        let binary = MeshBvh::build(Arc::clone(wide.mesh()), &BuildConfig::default());
        Box::new(binary.expect("the default configuration is valid"))
    };
    caught_by(&DamagedWide { name: "watertight as exact", damage }, &["T01", "T06", "T14", "T16", "T20", "T24", "S18"]);
}

#[test]
fn hit_points_without_bounds() {
    // T16 of the wide tree, since the binary one fails it as it is.
    caught_by(&Damaged { name: "no p_error", damage: |bvh| Box::new(WithoutBounds(bvh)) }, &["R01"]);
    caught_by(&DamagedWide { name: "wide, no p_error", damage: |wide| Box::new(WithoutBounds(wide)) }, &["T16", "R01"]);
}
