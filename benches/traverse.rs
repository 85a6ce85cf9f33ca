//! Rays through trees over 80 000 triangles, by every split method; the answers are checked first.

use std::sync::Arc;

use benchmarks::{bumpy_sphere, chords};
use bvh_flat::geometry::{Interval, Shape};
use bvh_flat::{BuildConfig, MeshBvh, SplitMethod};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn traverse(c: &mut Criterion) {
    let mesh = Arc::new(bumpy_sphere(6));
    let rays = chords(&mesh, 1 << 14);
    let mut expected = None;
    for method in SplitMethod::ALL {
        let Ok(bvh) = MeshBvh::build(Arc::clone(&mesh), &BuildConfig::new(method)) else { continue };
        let hits: Vec<_> = rays.iter().map(|ray| bvh.intersect(ray, Interval::FULL)).collect();
        assert_eq!(expected.get_or_insert_with(|| hits.clone()), &hits, "the answers depend on the tree");

        let mut group = c.benchmark_group(format!("traverse/{}", method.name()));
        group.throughput(Throughput::Elements(rays.len() as u64)).sample_size(20);
        group.bench_function("closest", |b| {
            b.iter(|| rays.iter().filter(|ray| bvh.intersect(ray, Interval::FULL).is_some()).count());
        });
        group.bench_function("any", |b| {
            b.iter(|| rays.iter().filter(|ray| bvh.intersect_p(ray, Interval::FULL)).count());
        });
        group.finish();
    }
}

criterion_group!(benches, traverse);
criterion_main!(benches);
