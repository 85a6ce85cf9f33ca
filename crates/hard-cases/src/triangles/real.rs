//! Real scenes. They stand beside the checkout; where they do not, a case counts one trial, and says so in the figure
//! "skipped".

use std::path::PathBuf;

use geometry::{Bounds3, Interval, Ray, TriangleMesh};
use scene::SceneShape;

use super::closed::{Closed, try_all};
use super::findings::{Fallible, Findings, Quantity, in_chunks, outcome_of};
use super::judge::Specimen;
use crate::{Aim, Case, Outcome, Random, Run, aimed_rays};

macro_rules! scenes {
    ($($name:ident = $id:literal, $file:literal, $title:literal, $try_scene:ident;)*) => {$(
        pub(super) const $name: Case = Case {
            id: $id,
            title: $title,
            run: |run| on_scene(run, $file, $try_scene),
        };
    )*};
}

scenes! {
    T31 = "T31", "cow.ply", "cow, closed", closed;
    T32 = "T32", "nefertiti.ply", "nefertiti, closed", closed;
    T33 = "T33", "cad-as1-assembly.ply", "assembly, closed solids with slivers", closed;
    T34 = "T34", "cad-shaft.ply", "shaft, closed with long slivers", closed;
    T35 = "T35", "terrain-everest-ecef.ply", "terrain at 5.7e6 from the origin", judged;
    T36 = "T36", "engine-2cylinder.ply", "engine with repeated vertices", judged;
    T37 = "T37", "voxel-monu0-boxes.ply", "voxels with coincident faces", judged;
    T38 = "T38", "q3-minia.ply", "game level with T-junctions", judged;
}

pub(super) const T40: Case = Case { id: "T40", title: "hit points within their bounds on real scenes", run: t40 };

/// The mesh of a real scene, the first of a file; `None` where the file is not there.
pub(super) fn real_mesh(file: &str) -> Fallible<Option<TriangleMesh>> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes")).join(file);
    if !path.is_file() {
        return Ok(None);
    }
    let scene = scene::load(&path)?;
    let mesh = scene.geometries().iter().find_map(|geometry| match &geometry.shape {
        SceneShape::Mesh(mesh) => Some(TriangleMesh::clone(mesh)),
        SceneShape::Sphere(_) => None,
    });
    mesh.map(Some).ok_or_else(|| "the scene has no mesh".into())
}

/// How many scenes were not there.
pub(super) const SKIPPED: &str = "skipped";

/// What a case finds whose scene is not there.
pub(super) fn skipped() -> Findings {
    let mut findings = Findings::default();
    findings.count(SKIPPED, 1);
    findings.check(true, String::new);
    findings
}

/// Loads the scene and tries it; where there is none, tries nothing.
fn on_scene(run: &Run, file: &str, try_scene: fn(&Run, TriangleMesh, Bounds3) -> Fallible<Findings>) -> Outcome {
    let found = real_mesh(file).and_then(|mesh| match mesh {
        None => Ok(skipped()),
        Some(mesh) => {
            let bounds = Bounds3::from_points(mesh.positions().iter().copied());
            try_scene(run, mesh, bounds)
        }
    });
    outcome_of(found)
}

/// No ray from within leaks.
fn closed(run: &Run, mesh: TriangleMesh, bounds: Bounds3) -> Fallible<Findings> {
    let mut random = Random::new(run.seed, 0x71f0);
    let closed = Closed::around(run, mesh, run.effort.pick(100, 2_000), &bounds, &mut random)?;
    let aims = [Aim::Edge, Aim::Vertex, Aim::Corner];
    Ok(try_all(run, 0x71f, run.effort.pick(20_000, 10_000_000), &[closed], &aims))
}

/// Rays from anywhere around answer as the oracle does.
fn judged(run: &Run, mesh: TriangleMesh, bounds: Bounds3) -> Fallible<Findings> {
    let specimen = Specimen::new(run, mesh)?;
    let mut findings = in_chunks(run, 0x720, run.effort.pick(6_000, 2_000_000), |i, random, findings| {
        let origin = bounds.centroid() + 0.75 * bounds.diagonal() * random.vector();
        for ray in aimed_rays(&specimen.mesh, Aim::ALL[i % 4], 1, random, |_| origin) {
            specimen.judge(&ray, Interval::FULL, findings);
        }
    });
    findings.require(Quantity::TError, 0.9999, 16.0);
    Ok(findings)
}

/// No hit point is further from the exact one than it says, and what it says is at most two units of f32 at
/// its largest coordinate. From anywhere around, at the inside of triangles, edges, vertices and box corners.
fn t40(run: &Run) -> Outcome {
    const FILES: [&str; 8] = [
        "engine-2cylinder.ply",
        "terrain-everest-ecef.ply",
        "bunny.ply",
        "sponza.ply",
        "cad-shaft.ply",
        "hairball-procedural.ply",
        "kitchen.ply",
        "dragon.ply",
    ];
    let files = run.effort.pick(&FILES[..2], &FILES[..]);
    // Three of four rays hit, of rays at holes and at what is behind them.
    let count = run.effort.pick(4_000, 1_800_000);
    let try_all = || -> Fallible<Findings> {
        let mut all = Findings::default();
        for (number, file) in files.iter().enumerate() {
            let Some(mesh) = real_mesh(file)? else {
                all = all.and(skipped());
                continue;
            };
            let bounds = Bounds3::from_points(mesh.positions().iter().copied());
            let specimen = Specimen::new(run, mesh)?;
            let progress = |part: f64| (run.progress)((number as f64 + part) / files.len() as f64);
            let run = Run { progress: &progress, ..*run };
            all = all.and(in_chunks(&run, 0x728 + number as u64, count, |i, random, findings| {
                let origin = bounds.centroid() + 0.75 * bounds.diagonal() * random.vector();
                let direction = Aim::ALL[i % 4].target(&specimen.mesh, random) - origin;
                let hit = specimen.judge(&Ray::new(origin, direction), Interval::FULL, findings);
                findings.count("hits", u64::from(hit.is_some()));
            }));
        }
        if all.counted(SKIPPED) == 0 {
            all.require_count("hits", run.effort.pick(4_000, 10_000_000));
        }
        if all.counted(SKIPPED) < files.len() as u64 {
            all.require(Quantity::PointBound, 1.0, 2.0);
        }
        Ok(all)
    };
    outcome_of(try_all())
}
