//! A mesh behind a chain of transforms, and its answers held against the exact ones.

use std::sync::Arc;

use bvh_flat::{BuildConfig, WideMesh};
use geometry::glam::{DMat3, DVec3, Vec3};
use geometry::{Hit, Interval, Ray, Shape, Transform, TraversalRay, TriangleMesh};
use oracle::{Agreement, Closest, ExactTransform, MeshOracle, Oracle, PointAgreement, Tally, Verdict};
use primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface, TransformedPrimitive};

use crate::spheres::Trials;
use crate::{Aim, Random};

/// Half the spacing of f32 at 1.
pub(super) const U32: f64 = f32::EPSILON as f64 / 2.0;

/// Promise P6: the f64 ray differs from the ideal one by at most this, times κ and the coordinates, for each level.
pub(super) const F64_RAY: f64 = 1.0 / (1_u64 << 48) as f64;

pub(crate) type AnyPrimitive = Arc<dyn Primitive + Send + Sync>;

/// A mesh behind a chain of transforms, with its exact counterpart.
pub(crate) struct Placed {
    pub(crate) mesh: Arc<TriangleMesh>,
    /// From the world inwards.
    pub(super) chain: Vec<Transform>,
    pub(crate) primitive: AnyPrimitive,
    oracle: MeshOracle,
    /// What is asked of hit points, in ulp, where the ray is not nearly along the surface: the largest error in f64 for
    /// each level, and the largest bound.
    pub(super) limits: Option<(f64, f64)>,
}

/// The mesh with its tree and a material.
pub(crate) fn mesh_primitive(mesh: &Arc<TriangleMesh>) -> Option<AnyPrimitive> {
    let tree = WideMesh::build(Arc::clone(mesh), &BuildConfig::default()).ok()?;
    let surface = Surface::of_material(MaterialId::from_index(0)?);
    Some(Arc::new(GeometricPrimitive::new(tree, surface, MediumInterface::VACUUM)))
}

/// A closed, star-shaped mesh around `center` with radii around `size`, of 320 triangles.
pub(crate) fn bumpy(random: &mut Random, center: Vec3, size: f32) -> Option<Arc<TriangleMesh>> {
    let mesh = scene::meshes::icosphere(2, |_| f64::from(size * (0.8 + 0.4 * random.unit()))).ok()?;
    let positions: Vec<Vec3> = mesh.positions().iter().map(|p| *p + center).collect();
    TriangleMesh::new(positions, mesh.triangles().to_vec()).ok().map(Arc::new)
}

impl Placed {
    /// `None` where the mesh cannot be built.
    pub(crate) fn new(mesh: Arc<TriangleMesh>, chain: Vec<Transform>) -> Option<Self> {
        let mut primitive = mesh_primitive(&mesh)?;
        let mut exact: Option<ExactTransform> = None;
        for transform in chain.iter().rev() {
            primitive = Arc::new(TransformedPrimitive::new(primitive, *transform));
            let outer = ExactTransform::new(transform.matrix())?;
            exact = Some(exact.map_or(outer.clone(), |inner| outer.then_inside(&inner)));
        }
        let oracle = match exact {
            Some(exact) => MeshOracle::instance(&mesh, exact),
            None => MeshOracle::new(&mesh),
        };
        Some(Self { mesh, chain, primitive, oracle, limits: None })
    }

    /// A point of the mesh's space in the world.
    pub(super) fn to_world(&self, p: DVec3) -> DVec3 {
        self.chain.iter().rev().fold(p, |p, transform| transform.point(p))
    }

    /// A ray from outside or inside of the mesh, at one of the places where meshes leak. In f64, so that it goes there
    /// also where f32 is coarse in the mesh's space.
    pub(crate) fn aimed(&self, random: &mut Random) -> Ray {
        let bounds = self.mesh.object_bound();
        let (center, size) = (bounds.centroid().as_dvec3(), f64::from(bounds.diagonal().max_element()));
        let far = if random.below(4) == 0 { 0.1 } else { f64::from(random.power_of_two(0.0, 4.0)) };
        let o = self.to_world(center + far * size * random.direction().as_dvec3()).as_vec3();
        let triangle = random.below(self.mesh.len());
        let [a, b, c] = self.mesh.vertices(triangle).map(Vec3::as_dvec3);
        let [s, t] = [random.unit(), random.unit()].map(f64::from);
        let target = match Aim::ALL[random.below(4)] {
            Aim::Edge => a + s * (b - a),
            Aim::Vertex => a,
            Aim::Corner => self.mesh.triangle_bounds(triangle).corners()[random.below(8)].as_dvec3(),
            Aim::Anywhere => a + s * (b - a) + t * (1.0 - s) * (c - a),
        };
        let way = (self.to_world(target) - o.as_dvec3()) * f64::from(random.power_of_two(-4.0, 4.0));
        Ray::new(o, way.as_vec3())
    }

    /// The ray at each level, from the world inwards.
    fn rays(&self, ray: &TraversalRay) -> Vec<TraversalRay> {
        let mut rays = vec![*ray];
        for transform in &self.chain {
            rays.extend(transform.ray_to_object(&rays[rays.len() - 1]));
        }
        rays
    }

    /// What the rays of promise P6 may be off by at `t`, in the mesh's space: 2⁻⁴⁸ κ of the coordinates for each level.
    fn deviation(&self, rays: &[TraversalRay], t: f64) -> f64 {
        let mut condition = 1.0;
        let mut all = 0.0;
        for (transform, ray) in self.chain.iter().zip(rays).rev() {
            condition *= norm(&transform.matrix().matrix3) * norm(&transform.inverse_matrix().matrix3);
            let coordinates = reach(ray, t).max_element() + transform.matrix().translation.abs().max_element();
            // In units of the space inside.
            let inside = norm(&transform.inverse_matrix().matrix3);
            all += F64_RAY * condition * coordinates * inside;
        }
        all
    }

    /// The band, in the mesh's space: within this distance of an edge a decision may differ from the exact one. Boxes
    /// and triangles are tested with the local ray rounded to f32, hence up to 2⁻²⁴ (|o| + t |d|) off at each level
    /// below the world's, and the triangles' shear is good to 5 · 2⁻²⁴ of that.
    fn band(&self, rays: &[TraversalRay], t: f64) -> f64 {
        let mut to_mesh = DMat3::IDENTITY;
        let mut all = DVec3::ZERO;
        for level in (1..rays.len()).rev() {
            let absolute = DMat3::from_cols(to_mesh.x_axis.abs(), to_mesh.y_axis.abs(), to_mesh.z_axis.abs());
            all += absolute * (reach(&rays[level], t) * U32);
            to_mesh *= self.chain[level - 1].inverse_matrix().matrix3;
        }
        8.0 * (all.max_element() + reach(&rays[rays.len() - 1], t).max_element() * U32) + self.deviation(rays, t)
    }

    /// The [band](Self::band) of a ray of the world.
    pub(super) fn bound_of(&self, ray: &TraversalRay, t: f64) -> f64 {
        self.band(&self.rays(ray), t)
    }

    /// The least distance of the ray from an edge of a triangle, in the mesh's space.
    fn edge_distance(&self, ray: &TraversalRay, triangle: u64) -> f64 {
        let (o, d) = (ray.origin64(), ray.direction64().normalize());
        let across = self.mesh.vertices(triangle as usize).map(|v| {
            let p = v.as_dvec3() - o;
            p - p.dot(d) * d
        });
        let distance = |a: DVec3, b: DVec3| {
            let s = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            (a + if s.is_finite() { s } else { 0.0 } * (b - a)).length()
        };
        let [a, b, c] = across;
        distance(a, b).min(distance(b, c)).min(distance(c, a))
    }

    /// Holds the closest hit of a ray against the exact one.
    ///
    /// The decision is right, or one of the triangles that it is about (the nearer of the exact and the claimed one;
    /// either where they are equally near) has an edge within the [band](Self::band). Where it is right, t is within 1
    /// ulp, but for what promise P6 allows the ray to be off, and the point's bound holds.
    pub(crate) fn judge(&self, trials: &mut Trials, ray: &Ray) {
        let Some(traversal) = TraversalRay::new(ray) else { return };
        let exact = self.oracle.closest(ray, Interval::FULL, &mut Tally::default());
        let hit = self.primitive.intersect(&traversal, Interval::FULL);
        let any = self.primitive.intersect_p(&traversal, Interval::FULL);
        trials.check(any == hit.is_some(), || format!("{self:?} {ray:?}: {hit:?}, but any: {any}"));
        let agreement = Agreement::of(hit.map(|hit| (hit.t, hit.primitive)), exact.as_ref());
        match (&hit, &exact) {
            _ if agreement.verdict != Verdict::Right => {
                let rays = self.rays(&traversal);
                let (distance, band) = self.dispute(&rays, hit.as_ref(), exact.as_ref());
                trials.count("decisions within the band", 1);
                let plain =
                    self.deviation(&rays, 0.0).max(8.0 * U32 * self.distance(&rays, hit.as_ref(), exact.as_ref()));
                trials.largest("furthest decision, in bands of a plain ray", distance / plain);
                trials.check(distance <= band, || {
                    let exact = exact.as_ref().map(|exact| (exact.t.to_f64(), &exact.primitives));
                    format!("{self:?} {ray:?}: {hit:?} instead of {exact:?}, {distance:e} from an edge, band {band:e}")
                });
            }
            (Some(hit), Some(exact)) => self.judge_values(trials, ray, &traversal, hit, exact, agreement),
            _ => {}
        }
    }

    /// Holds the closest hit of a ray against the exact one without any allowance, where f64 holds the ray in the
    /// mesh's space exactly; whether it hits. That there is a ray which it does not hold is a failure, too.
    pub(super) fn judge_strictly(&self, trials: &mut Trials, ray: &Ray) -> bool {
        let Some(traversal) = TraversalRay::new(ray) else { return false };
        let rays = self.rays(&traversal);
        let inner = &rays[rays.len() - 1];
        let direction = self.chain.iter().rev().fold(inner.direction64(), |d, transform| transform.vector(d));
        let is_held = self.to_world(inner.origin64()) == ray.origin.as_dvec3() && direction == ray.direction.as_dvec3();
        trials.check(is_held, || format!("{self:?} {ray:?}: f64 does not hold it"));
        trials.count("rays that f32 does not hold", u64::from(inner.is_rounded()));
        let exact = self.oracle.closest(ray, Interval::FULL, &mut Tally::default());
        let expected = exact.map(|exact| (exact.t.to_f32(), exact.primitives[0]));
        let hit = self.primitive.intersect(&traversal, Interval::FULL).map(|hit| (hit.t, hit.primitive));
        let any = self.primitive.intersect_p(&traversal, Interval::FULL);
        trials.count("hits", u64::from(hit.is_some()));
        trials.check(hit == expected && any == expected.is_some(), || {
            format!("{self:?} {ray:?}: {hit:?}, any: {any}, instead of {expected:?}")
        });
        hit.is_some()
    }

    fn judge_values(
        &self,
        trials: &mut Trials,
        ray: &Ray,
        traversal: &TraversalRay,
        hit: &Hit,
        exact: &Closest,
        agreement: Agreement,
    ) {
        trials.count("hits", 1);
        let rays = self.rays(traversal);
        let inner = &rays[rays.len() - 1];
        let [a, b, c] = self.mesh.vertices(hit.primitive as usize).map(Vec3::as_dvec3);
        let n = (b - a).cross(c - a).normalize_or_zero();
        // Along the ray, what it is off sideways grows by the slant of the plane.
        let off = self.deviation(&rays, hit.t.into()) / n.dot(inner.direction64()).abs();
        let t_error = agreement.t_error.unwrap_or(f64::INFINITY);
        if self.edge_distance(inner, hit.primitive) > self.deviation(&rays, hit.t.into()) {
            trials.largest("t error, ulp", t_error);
            trials.check(t_error <= 1.0 + off / exact.t.ulp32(), || {
                format!("{self:?} {ray:?}: t {} instead of {}: {t_error} ulp", hit.t, exact.t.to_f64())
            });
        }
        let interaction = self.primitive.interaction(traversal, hit);
        let point = exact.point(ray);
        let (p, p_error) = (interaction.p().as_dvec3(), interaction.p_error().as_dvec3());
        let rounded = PointAgreement::of(p, p_error, &point);
        let in_f64 = PointAgreement::of(interaction.point.p, interaction.point.p_error, &point);
        trials.check(rounded.is_bounded && in_f64.is_bounded, || {
            format!("{self:?} {ray:?}: {:?} is not bounded: {in_f64:?}, rounded {rounded:?}", interaction.point)
        });
        trials.largest("p error, ulp", rounded.error);
        trials.largest("p error in f64, ulp", in_f64.error);
        let slant = interaction.point.n.dot(traversal.direction64()).abs() / traversal.direction64().length();
        if slant > 0.01 {
            trials.largest("p bound beyond 0.6 degrees, ulp", rounded.bound);
        }
        let level = self.chain.len().max(1) as f64;
        if let Some((error, bound)) = self.limits
            && slant > 0.01
        {
            trials.check(in_f64.error <= error * level && rounded.bound <= bound, || {
                format!("{self:?} {ray:?}: {in_f64:?}, rounded {rounded:?}")
            });
        }
        // Outside stays outside, whatever mirrors: seen from the middle of the mesh.
        let middle = self.mesh.object_bound().centroid().as_dvec3();
        let outward = n.dot(a - middle) * interaction.point.n.dot(interaction.point.p - self.to_world(middle));
        trials.check(outward > 0.0, || format!("{self:?} {ray:?}: the normal changes sides"));
    }

    /// How far the ray goes to the hit, or to where it should be, in the mesh's space.
    fn distance(&self, rays: &[TraversalRay], hit: Option<&Hit>, exact: Option<&Closest>) -> f64 {
        let t = hit.map(|h| f64::from(h.t)).or(exact.map(|e| e.t.to_f64())).unwrap_or(0.0);
        t * rays[rays.len() - 1].direction64().length()
    }

    /// How near the decision was, and how near it must be to be excused.
    fn dispute(&self, rays: &[TraversalRay], hit: Option<&Hit>, exact: Option<&Closest>) -> (f64, f64) {
        let ray = &rays[rays.len() - 1];
        let claimed = hit.map(|hit| (f64::from(hit.t), vec![hit.primitive]));
        let wanted = exact.map(|exact| (exact.t.to_f64(), exact.primitives.clone()));
        let mut about: Vec<(f64, Vec<u64>)> = claimed.into_iter().chain(wanted).collect();
        about.sort_by(|a, b| a.0.total_cmp(&b.0));
        let nearest = about[0].0;
        about.retain(|(t, _)| *t <= nearest * 1.000_01);
        let distance =
            about.iter().flat_map(|(_, ids)| ids).map(|&id| self.edge_distance(ray, id)).fold(f64::INFINITY, f64::min);
        (distance, self.band(rays, nearest))
    }
}

impl std::fmt::Debug for Placed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let matrices: Vec<_> = self.chain.iter().map(Transform::matrix).collect();
        write!(f, "{} triangles from {:?} behind {matrices:?}", self.mesh.len(), self.mesh.positions()[0])
    }
}

/// |o| + t |d|.
pub(super) fn reach(ray: &TraversalRay, t: f64) -> DVec3 {
    ray.origin64().abs() + ray.direction64().abs() * t
}

/// The largest sum of a row.
pub(super) fn norm(m: &DMat3) -> f64 {
    (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()).max_element()
}
