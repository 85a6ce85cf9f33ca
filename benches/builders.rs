//! Builds of a tree over 80 000 triangles, by every split method.

use benchmarks::bumpy_sphere;
use bvh_flat::geometry::Bounds3;
use bvh_flat::{BuildConfig, FlatBvh, SplitMethod};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn builders(c: &mut Criterion) {
    let mesh = bumpy_sphere(6);
    let bounds: Vec<Bounds3> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
    let mut group = c.benchmark_group("build");
    group.throughput(Throughput::Elements(bounds.len() as u64)).sample_size(20);
    for method in SplitMethod::ALL {
        let config = BuildConfig::new(method);
        group.bench_function(method.name(), |b| b.iter(|| FlatBvh::build(&bounds, &config, &())));
    }
    group.finish();
}

criterion_group!(benches, builders);
criterion_main!(benches);
