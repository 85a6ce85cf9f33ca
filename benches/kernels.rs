//! The two inner kernels, over data that fits the first cache.

use std::hint::black_box;

use benchmarks::{bumpy_sphere, chords};
use bvh_flat::geometry::{Bounds3, Interval, intersect_triangle};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn kernels(c: &mut Criterion) {
    let mesh = bumpy_sphere(3);
    let rays = chords(&mesh, 16);
    let triangles: Vec<_> = (0..256).map(|i| mesh.vertices(i)).collect();
    let boxes: Vec<Bounds3> = triangles.iter().map(|t| Bounds3::from_points(*t)).collect();
    let pairs = (rays.len() * triangles.len()) as u64;

    let mut group = c.benchmark_group("kernels");
    group.throughput(Throughput::Elements(pairs));
    group.bench_function("box", |b| {
        b.iter(|| {
            let entered = |ray| boxes.iter().filter(|b| enter(ray, b)).count();
            rays.iter().map(entered).sum::<usize>()
        });
    });
    group.bench_function("triangle", |b| {
        b.iter(|| {
            let hit = |ray| triangles.iter().filter(|t| intersect_triangle(ray, t, Interval::FULL).is_some()).count();
            rays.iter().map(hit).sum::<usize>()
        });
    });
    group.finish();
}

fn enter(ray: &bvh_flat::geometry::TraversalRay, bounds: &Bounds3) -> bool {
    black_box(ray).enter(black_box(bounds), Interval::FULL).is_some()
}

criterion_group!(benches, kernels);
criterion_main!(benches);
