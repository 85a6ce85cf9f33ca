//! Spawned rays on surfaces of every size and place: R01, R02, R05 and R07.

use std::sync::Arc;

use geometry::glam::{DAffine3, DMat3, DVec3, Vec3};
use geometry::{Bounds3, Hit, Interval, Ray, Transform, TraversalRay, TriangleMesh};
use oracle::{ExactTransform, MeshOracle};
use primitive::{
    GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface, SurfaceInteraction, TransformedPrimitive,
};
use scene::meshes;

use super::departure::{DETACHMENT, Departure, Scenery, require_few_grazes};
use crate::triangles::findings::{Fallible, Findings, Quantity, in_chunks, outcome_of};
use crate::triangles::generate::{log_uniform, mapped};
use crate::triangles::judge::{Specimen, interaction};
use crate::{Aim, Case, Outcome, Random, Run, aimed_rays};

pub(super) const R01: Case = Case { id: "R01", title: "reflected, at 10^-3 to 10^7", run: r01 };
pub(super) const R02: Case = Case { id: "R02", title: "leaving at 10^-6 to 10^-1 rad", run: r02 };
pub(super) const R05: Case = Case { id: "R05", title: "on scaled and sheared instances", run: r05 };
pub(super) const R07: Case = Case { id: "R07", title: "transmitted to the other side", run: r07 };

/// Rough balls, axis-parallel boxes and floors with |p| of 10⁻³ to 10⁷: around the origin, and smaller beside it.
pub(super) fn surfaces(run: &Run) -> Fallible<Vec<Specimen>> {
    let mut random = Random::new(run.seed, 0x8010);
    let ball = meshes::icosphere(3, |_| 1.0 + 0.3 * f64::from(random.unit()))?;
    let cuboid = meshes::cuboid(DVec3::new(-1.0, -0.7, -0.4), DVec3::new(0.3, 0.9, 1.1))?;
    let floor = meshes::grid(9, 9, |x, z| DVec3::new(0.2 * x as f64 - 0.9, 0.0, 0.2 * z as f64 - 0.9))?;
    let mut specimens = Vec::new();
    for power in -3..=7 {
        let size = 10.0_f64.powi(power);
        for mesh in [&ball, &cuboid, &floor] {
            specimens.push(Specimen::new(run, mapped(mesh, |p| size * p)?)?);
            let beside = mapped(mesh, |p| size * (DVec3::new(0.8, -0.6, 0.3) + 0.01 * p))?;
            specimens.push(Specimen::new(run, beside)?);
        }
    }
    Ok(specimens)
}

/// The subject's own answers about a mesh.
pub(super) fn on_mesh<T>(specimen: &Specimen, look: impl FnOnce(&Scenery) -> T) -> T {
    look(&Scenery {
        oracle: &specimen.oracle,
        vertices: &|i| specimen.vertices(i),
        closest: &|ray, interval| specimen.closest(ray, interval),
        interaction: &|ray, hit| Some(interaction(specimen.shape.surface_point(&TraversalRay::new(ray)?, hit))),
    })
}

/// A ray from around or within `bounds` at `mesh`, aimed at edges and vertices too.
fn ray_at(mesh: &TriangleMesh, bounds: &Bounds3, random: &mut Random) -> Option<Ray> {
    let origin = bounds.centroid() + bounds.diagonal().max_element() * (0.2 + random.unit()) * random.direction();
    let aim = Aim::ALL[random.below(4)];
    let ray = aimed_rays(mesh, aim, 1, random, |_| origin).next();
    ray.map(|ray| Ray::new(ray.origin, ray.direction + 0.1 * ray.direction.length() * random.vector()))
}

/// Spawns from all surfaces towards what `direction` draws for a departure.
fn spawn_everywhere(
    run: &Run,
    stream: u64,
    direction: impl Fn(&Departure, &mut Random) -> Vec3 + Sync,
) -> Fallible<Findings> {
    let specimens = surfaces(run)?;
    let mut findings = in_chunks(run, stream, run.effort.pick(30_000, 20_000_000), |i, random, findings| {
        let specimen = &specimens[i % specimens.len()];
        let Some(ray) = ray_at(&specimen.mesh, &specimen.shape.object_bound(), random) else { return };
        on_mesh(specimen, |scenery| {
            if let Some(departure) = scenery.arrive(&ray, findings) {
                scenery.depart(&departure, direction(&departure, random), findings);
            }
        });
    });
    findings.require_count("hits", run.effort.pick(10_000, 5_000_000));
    findings.require(Quantity::Detachment, 0.99, DETACHMENT);
    require_few_grazes(&mut findings);
    Ok(findings)
}

/// Uniform in the half-space of `n`.
pub(super) fn hemisphere(n: DVec3, random: &mut Random) -> Vec3 {
    let d = random.direction();
    if n.dot(d.as_dvec3()) < 0.0 { -d } else { d }
}

fn r01(run: &Run) -> Outcome {
    outcome_of(spawn_everywhere(run, 0x801, |departure, random| hemisphere(departure.n, random)))
}

fn r02(run: &Run) -> Outcome {
    outcome_of(spawn_everywhere(run, 0x802, |departure, random| {
        let angle = f64::from(log_uniform(random, 1e-6, 1e-1));
        let along = departure.n.cross(random.direction().as_dvec3()).normalize_or(departure.n.any_orthonormal_vector());
        (along + angle * departure.n).as_vec3()
    }))
}

fn r07(run: &Run) -> Outcome {
    outcome_of(spawn_everywhere(run, 0x807, |departure, random| hemisphere(-departure.n, random)))
}

/// Rough balls and boxes through scales of 1 : 1000, shears and rotations, near and far.
fn r05(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mut random = Random::new(run.seed, 0x8050);
        let ball = meshes::icosphere(2, |_| 1.0 + 0.3 * f64::from(random.unit()))?;
        let cuboid = meshes::cuboid(DVec3::new(-1.0, -0.7, -0.4), DVec3::new(0.3, 0.9, 1.1))?;
        let surface = Surface::of_material(MaterialId::from_index(0).ok_or("no material")?);
        let mut instances = Vec::new();
        for i in 0..run.effort.pick(24, 200) {
            let mesh = if i % 2 == 0 { &ball } else { &cuboid };
            let entry = |random: &mut Random| f64::from(random.signed());
            let scale = DVec3::from_array([0; 3].map(|_| f64::from(log_uniform(&mut random, 0.03, 30.0))));
            let shear = DMat3::from_cols_array(&[0; 9].map(|_| entry(&mut random))) + DMat3::IDENTITY * 1.5;
            let at = random.vector().as_dvec3() * [0.0, 10.0, 1e4][i % 3];
            let map = DAffine3::from_mat3_translation(shear * DMat3::from_diagonal(scale), at);
            // A draw that is nearly singular is no instance.
            let (Ok(transform), Some(exact)) = (Transform::from_affine(map), ExactTransform::new(&map)) else {
                continue;
            };
            let inner = GeometricPrimitive::new(
                run.subject.shape(Arc::new(mesh.clone()))?,
                surface,
                MediumInterface::default(),
            );
            let vertices: Vec<[DVec3; 3]> =
                (0..mesh.len()).map(|i| mesh.vertices(i).map(|v| map.transform_point3(v.as_dvec3()))).collect();
            let rounded = mapped(mesh, |p| map.transform_point3(p))?;
            instances.push((
                TransformedPrimitive::new(inner, transform),
                MeshOracle::instance(mesh, exact),
                vertices,
                rounded,
            ));
        }
        let mut findings = in_chunks(run, 0x805, run.effort.pick(20_000, 10_000_000), |i, random, findings| {
            let (instance, oracle, vertices, rounded) = &instances[i % instances.len()];
            let Some(ray) = ray_at(rounded, &instance.world_bound(), random) else { return };
            let interaction = |ray: &Ray, hit: &Hit| -> Option<SurfaceInteraction> {
                Some(instance.interaction(&TraversalRay::new(ray)?, hit))
            };
            let scenery = Scenery {
                oracle,
                vertices: &|i| vertices[i as usize],
                closest: &|ray, interval: Interval| instance.intersect(&TraversalRay::new(ray)?, interval),
                interaction: &interaction,
            };
            if let Some(departure) = scenery.arrive(&ray, findings) {
                let side = if i % 3 == 0 { -departure.n } else { departure.n };
                scenery.depart(&departure, hemisphere(side, random), findings);
            }
        });
        findings.require_count("hits", run.effort.pick(5_000, 2_000_000));
        findings.require(Quantity::Detachment, 0.99, DETACHMENT);
        require_few_grazes(&mut findings);
        Ok(findings)
    };
    outcome_of(try_all())
}
