//! Spawned rays where another surface is near, or is where they go to: R03, R04 and R06.

use geometry::glam::Vec3;
use geometry::{Interval, Ray};

use super::departure::{Departure, Scenery, require_few_grazes};
use super::surfaces::{hemisphere, on_mesh, surfaces};
use crate::triangles::findings::{Fallible, Findings, in_chunks, outcome_of};
use crate::triangles::generate::{log_uniform, soup};
use crate::triangles::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run};

pub(super) const R03: Case = Case { id: "R03", title: "in creases of 1 to 30 degrees", run: r03 };
pub(super) const R04: Case = Case { id: "R04", title: "between shells 1 to 8 ulp apart", run: r04 };
pub(super) const R06: Case = Case { id: "R06", title: "segments with both ends on surfaces", run: r06 };

/// Two triangles with a common edge and a narrow angle between them, hit within 1 to 100 ulp of the edge.
fn r03(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x8030);
    let creases: Fallible<Vec<Specimen>> = (0..run.effort.pick(100, 1_000))
        .map(|_| {
            let size = log_uniform(&mut random, 1e-2, 1e4);
            let (a, along) = (size * random.vector(), random.direction());
            let up = along.cross(random.direction()).normalize_or(along.any_orthonormal_vector());
            let angle = (1.0 + 29.0 * random.unit()).to_radians();
            let (c, d) = (up, up * angle.cos() + along.cross(up) * angle.sin());
            let b = a + size * along;
            let middle = a.midpoint(b);
            Specimen::new(run, soup([[a, b, middle + size * c], [b, a, middle + size * d]])?)
        })
        .collect();
    outcome_of(creases.map(|creases| {
        let mut findings = in_chunks(run, 0x803, run.effort.pick(20_000, 10_000_000), |i, random, findings| {
            let specimen = &creases[i % creases.len()];
            let ([a, b, c], d) = (specimen.mesh.vertices(i / 2 % 2), specimen.mesh.vertices(1 - i / 2 % 2)[2]);
            let ulp = f32::EPSILON * a.abs().max(b.abs()).max_element();
            let steps = (1 + random.below(100)) as f32;
            let inward = (c - a.midpoint(b)).normalize_or(Vec3::X);
            let target = a.lerp(b, 0.2 + 0.6 * random.unit()) + steps * ulp * inward;
            // Out of the middle of the opening.
            let origin = c.midpoint(d) + 0.1 * (b - a).length() * random.vector();
            on_mesh(specimen, |scenery| {
                let ray = Ray::new(origin, target - origin);
                if let Some(departure) = scenery.arrive(&ray, findings) {
                    scenery.depart(&departure, hemisphere(departure.n, random), findings);
                }
            });
        });
        findings.require_count("hits", run.effort.pick(10_000, 5_000_000));
        require_few_grazes(&mut findings);
        findings
    }))
}

/// How many of the rays that should stay between two shells have jumped over one, by the distance of the shells.
const JUMPS: [&str; 8] = [
    "jumps over a gap of 1 ulp",
    "jumps over a gap of 2 ulp",
    "jumps over a gap of 3 ulp",
    "jumps over a gap of 4 ulp",
    "jumps over a gap of 5 ulp",
    "jumps over a gap of 6 ulp",
    "jumps over a gap of 7 ulp",
    "jumps over a gap of 8 ulp",
];

/// Parallel sheets, 1 to 8 ulp of their coordinates apart along one axis, hit from outside and entered. The gap is in
/// the nature of the format: jumps are counted, by the gap.
fn r04(run: &Run) -> Outcome {
    let mut random = Random::new(run.seed, 0x8040);
    let shells: Fallible<Vec<Specimen>> = (0..run.effort.pick(240, 2_400))
        .map(|i| {
            let (axis, steps) = (i / 8 % 3, (i % 8 + 1) as f32);
            let sheet = [0; 3].map(|_| Vec3::ONE + Vec3::new(random.unit(), random.unit(), random.unit()));
            let shifted = sheet.map(|mut p| {
                p[axis] -= steps * f32::EPSILON;
                p
            });
            Specimen::new(run, soup([sheet, shifted])?)
        })
        .collect();
    outcome_of(shells.map(|shells| {
        let mut findings = in_chunks(run, 0x804, run.effort.pick(20_000, 10_000_000), |i, random, findings| {
            let specimen = &shells[i % shells.len()];
            let axis = i % shells.len() / 8 % 3;
            let target = Aim::Anywhere.target(&specimen.mesh, random);
            let mut origin = target + random.vector();
            origin[axis] = target[axis] + 1.0;
            on_mesh(specimen, |scenery| {
                let Some(departure) = scenery.arrive(&Ray::new(origin, target - origin), findings) else { return };
                // On through the outer shell towards the inner one.
                let mut own = Findings::default();
                scenery.depart(&departure, hemisphere(-departure.n, random), &mut own);
                findings.count(JUMPS[i % 8], own.counted("tunnels"));
                *findings = std::mem::take(findings).and(own);
            });
        });
        findings.require_count("hits", run.effort.pick(5_000, 2_000_000));
        require_few_grazes(&mut findings);
        findings
    }))
}

/// From a hit on a surface to a hit on the same or another side of it, both ends moved off: what stands between the
/// ends is neither of the two, nor anything in their planes, nor, but for few grazes, what touches them.
fn r06(run: &Run) -> Outcome {
    let ray_to = |specimen: &Specimen, random: &mut Random| {
        let bounds = specimen.shape.object_bound();
        let origin = bounds.centroid() + bounds.diagonal().max_element() * random.direction();
        Ray::new(origin, Aim::Anywhere.target(&specimen.mesh, random) - origin)
    };
    outcome_of(surfaces(run).map(|specimens| {
        let mut findings = in_chunks(run, 0x806, run.effort.pick(30_000, 10_000_000), |i, random, findings| {
            let specimen = &specimens[i % specimens.len()];
            on_mesh(specimen, |scenery| {
                let ends = [0; 2].map(|_| scenery.arrive(&ray_to(specimen, random), findings));
                if let [Some(a), Some(b)] = ends
                    && a.primitive != b.primitive
                {
                    connect(scenery, &a, &b, findings);
                }
            });
        });
        findings.require_count("segments", run.effort.pick(5_000, 2_000_000));
        require_few_grazes(&mut findings);
        findings
    }))
}

fn connect(scenery: &Scenery, a: &Departure, b: &Departure, findings: &mut Findings) {
    let (there, back) = ((b.p - a.p).as_vec3(), (a.p - b.p).as_vec3());
    let ends = [a.interaction.spawn_ray(there), b.interaction.spawn_ray(back)];
    let [from, to] = ends.map(|ray| ray.origin);
    if from == to {
        return;
    }
    findings.count("segments", 1);
    for (departure, segment) in [(a, Ray::new(from, to - from)), (b, Ray::new(to, from - to))] {
        scenery.judge_acne(departure, &segment, Interval::up_to(1.0), findings);
    }
}
