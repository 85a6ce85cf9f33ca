//! Rays through wide trees over 80 000 triangles: layouts, widths, one by one and in batches; the answers are checked
//! first.

use std::sync::Arc;

use benchmarks::{bumpy_sphere, chords};
use bvh_flat::geometry::{Interval, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, RaySegment, SimdWidth, WideLayout, WideMesh};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn segment(ray: &TraversalRay) -> RaySegment {
    let ray = ray.ray();
    RaySegment { origin: ray.origin.into(), t_min: 0.0, direction: ray.direction.into(), t_max: f32::INFINITY }
}

fn traverse(c: &mut Criterion) {
    let mesh: Arc<TriangleMesh> = Arc::new(bumpy_sphere(6));
    let rays = chords(&mesh, 1 << 14);
    let segments: Vec<RaySegment> = rays.iter().map(segment).collect();
    let mut expected = None;
    for layout in WideLayout::ALL {
        let Ok(built) = WideMesh::build_observed(Arc::clone(&mesh), &BuildConfig::balanced(), layout, &()) else {
            continue;
        };
        for width in SimdWidth::available() {
            let wide = built.with_simd_width(width);
            let hits: Vec<_> = rays.iter().map(|ray| wide.intersect(ray, Interval::FULL)).collect();
            assert_eq!(expected.get_or_insert_with(|| hits.clone()), &hits, "the answers depend on layout or width");

            let mut group = c.benchmark_group(format!("wide/{}/{}", layout.name(), width.name()));
            group.throughput(Throughput::Elements(rays.len() as u64)).sample_size(20);
            group.bench_function("closest", |b| {
                b.iter(|| rays.iter().filter(|ray| wide.intersect(ray, Interval::FULL).is_some()).count());
            });
            group.bench_function("any", |b| {
                b.iter(|| rays.iter().filter(|ray| wide.intersect_p(ray, Interval::FULL)).count());
            });
            let mut hits = vec![None; segments.len()];
            group.bench_function("closest, batch", |b| b.iter(|| wide.intersect_many(&segments, &mut hits)));
            group.finish();
        }
    }
}

criterion_group!(benches, traverse);
criterion_main!(benches);
