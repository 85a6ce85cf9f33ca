//! One answer from everything that promises the exact one: T39.

use std::sync::Arc;

use bvh_flat::{BuildConfig, MeshBvh, RaySegment, SimdWidth, WideLayout, WideMesh};
use geometry::{Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
use rayon::prelude::*;

use super::findings::{Fallible, Findings, outcome_of};
use super::real::{SKIPPED, real_mesh, skipped};
use crate::build::sweep::{LEAVES, configs};
use crate::{Aim, Case, Outcome, Random, Run};

pub(super) const T39: Case = Case { id: "T39", title: "one answer of all configurations on real scenes", run: t39 };

/// Scenes in which much ties or has no area.
const FILES: [&str; 3] = ["voxel-monu0-boxes.ply", "engine-2cylinder.ply", "q3-minia.ply"];

/// What is asked, and what must be answered.
struct Asked {
    rays: Vec<(TraversalRay, Interval)>,
    segments: Vec<RaySegment>,
    expected: Vec<Option<Hit>>,
}

/// Every split method, leaf size, layout, width and kind of query (ray by ray, in batches, in batches on one to three
/// threads) has the same bits for the same rays: those of one binary tree. The figure "hash" is of all these bits.
fn t39(run: &Run) -> Outcome {
    let try_all = || -> Fallible<Findings> {
        let mut all = Findings::default();
        let mut hash = 0xcbf2_9ce4_8422_2325;
        let files = run.effort.pick(&FILES[..1], &FILES[..]);
        for (number, file) in files.iter().enumerate() {
            let Some(mesh) = real_mesh(file)? else {
                all = all.and(skipped());
                continue;
            };
            let progress = |part: f64| (run.progress)((number as f64 + part) / files.len() as f64);
            let asked = Asked::new(&mesh, run.effort.pick(1_000, 1_000_000), run.seed)?;
            asked.expected.iter().for_each(|hit| hash = hashed(hash, hit.as_ref()));
            all = all.and(asked.try_all(run, Arc::new(mesh), &progress)?);
        }
        // Figures are f64, which holds so many bits.
        all.count("hash", hash >> 16);
        // More with each width that the processor has.
        if all.counted(SKIPPED) == 0 {
            all.require_count("configurations", run.effort.pick(30, 100 * FILES.len() as u64));
        }
        Ok(all)
    };
    outcome_of(try_all())
}

impl Asked {
    /// Rays at edges, vertices, corners and everywhere, with ends of every sort.
    fn new(mesh: &TriangleMesh, count: usize, seed: u64) -> Fallible<Self> {
        let (bounds, mut random) = (mesh.object_bound(), Random::new(seed, 0x727));
        let mut rays = Vec::with_capacity(count);
        while rays.len() < count {
            let i = rays.len();
            let origin = bounds.centroid() + 0.75 * bounds.diagonal() * random.vector();
            let mut direction = Aim::ALL[i % 4].target(mesh, &mut random) - origin;
            if i % 16 == 0 {
                direction[random.below(3)] = [0.0, -0.0][random.below(2)];
            }
            let interval = match i % 5 {
                0 => Interval::up_to(2.0 * random.unit()),
                1 => Interval::new(random.unit(), 1.0 + random.unit()),
                _ => Interval::FULL,
            };
            rays.extend(TraversalRay::new(&Ray::new(origin, direction)).map(|ray| (ray, interval)));
        }
        let segment = |(ray, interval): &(TraversalRay, Interval)| {
            let Ray { origin, direction, .. } = ray.ray();
            let (origin, direction) = (origin.into(), direction.into());
            RaySegment { origin, t_min: interval.t_min(), direction, t_max: interval.t_max() }
        };
        let segments = rays.iter().map(segment).collect();
        let reference = MeshBvh::build(mesh.clone(), &BuildConfig::default())?.exact();
        let expected = rays.par_iter().map(|(ray, interval)| reference.intersect(ray, *interval)).collect();
        Ok(Self { rays, segments, expected })
    }

    fn try_all(&self, run: &Run, mesh: Arc<TriangleMesh>, progress: &dyn Fn(f64)) -> Fallible<Findings> {
        let mut findings = Findings::default();
        let built_in = [BuildConfig::balanced(), BuildConfig::highest()];
        let configs: Vec<BuildConfig> = configs(run.effort.pick(&LEAVES[2..3], &LEAVES)).chain(built_in).collect();
        for (i, config) in configs.iter().enumerate() {
            let bvh = MeshBvh::build(Arc::clone(&mesh), config)?;
            let name = || format!("{config:?}, seed {}", run.seed);
            self.one_by_one(&mut findings, &bvh.exact(), || format!("{}, binary", name()));
            for layout in WideLayout::ALL {
                let wide = WideMesh::new(&bvh, layout).ok_or("too large")?;
                for width in SimdWidth::available() {
                    let name = || format!("{}, {}, {}", name(), layout.name(), width.name());
                    let wide = wide.with_simd_width(width);
                    self.one_by_one(&mut findings, &wide, name);
                    self.in_batches(&mut findings, &wide, name);
                }
                let threads = 1 + i % 3;
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
                pool.install(|| self.in_parallel(&mut findings, &wide, || format!("{}, {threads} threads", name())));
            }
            progress((i + 1) as f64 / configs.len() as f64);
        }
        Ok(findings)
    }

    fn one_by_one(&self, findings: &mut Findings, shape: &(dyn Shape + Sync), name: impl Fn() -> String) {
        let rays = || self.rays.par_iter();
        let hits: Vec<Option<Hit>> = rays().map(|(ray, interval)| shape.intersect(ray, *interval)).collect();
        let any: Vec<bool> = rays().map(|(ray, interval)| shape.intersect_p(ray, *interval)).collect();
        self.compare(findings, &hits, &any, || format!("{}, one by one", name()));
    }

    fn in_batches(&self, findings: &mut Findings, wide: &WideMesh, name: impl Fn() -> String) {
        let (mut hits, mut any) = (vec![None; self.rays.len()], vec![false; self.rays.len()]);
        wide.intersect_many(&self.segments, &mut hits);
        wide.intersect_p_many(&self.segments, &mut any);
        self.compare(findings, &hits, &any, || format!("{}, in batches", name()));
    }

    fn in_parallel(&self, findings: &mut Findings, wide: &WideMesh, name: impl Fn() -> String) {
        let (mut hits, mut any) = (vec![None; self.rays.len()], vec![false; self.rays.len()]);
        wide.par_intersect_many(&self.segments, &mut hits);
        wide.par_intersect_p_many(&self.segments, &mut any);
        self.compare(findings, &hits, &any, || format!("{}, in batches in parallel", name()));
    }

    fn compare(&self, findings: &mut Findings, hits: &[Option<Hit>], any: &[bool], name: impl Fn() -> String) {
        findings.count("configurations", 1);
        for (i, (hit, any)) in hits.iter().zip(any).enumerate() {
            let expected = &self.expected[i];
            findings.check(bits(hit.as_ref()) == bits(expected.as_ref()) && *any == expected.is_some(), || {
                format!("{}: {:?} hits {hit:?}, any {any}, not {expected:?}", name(), self.segments[i])
            });
        }
    }
}

fn bits(hit: Option<&Hit>) -> Option<(u64, [u32; 3])> {
    hit.map(|h| (h.primitive, [h.t, h.u, h.v].map(f32::to_bits)))
}

/// Fowler, Noll and Vo's hash, 1a, over words of 64 bits.
fn hashed(hash: u64, hit: Option<&Hit>) -> u64 {
    let words = bits(hit).map_or([u64::MAX; 4], |(primitive, [t, u, v])| [primitive, t.into(), u.into(), v.into()]);
    words.into_iter().fold(hash, |hash, word| (hash ^ word).wrapping_mul(0x0100_0000_01b3))
}
