//! Rays in parallel with rayon: a picture row by row, and a batch.

use std::error::Error;

use bvh_flat::geometry::{Interval, MeshError, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, RaySegment, WideMesh};
use rayon::prelude::*;

/// Waves on a pond of 200 x 200 squares of two triangles, from its middle on.
fn waves() -> Result<TriangleMesh, MeshError> {
    let positions = (0..201 * 201).map(|i| {
        let [x, z] = [i % 201, i / 201].map(|i| i as f32 / 100.0 - 1.0);
        [x, 0.1 * (20.0 * x.hypot(z)).cos(), z]
    });
    let triangles = (0..200 * 200).map(|i| i / 200 * 201 + i % 200);
    TriangleMesh::new(positions, triangles.flat_map(|a| [[a, a + 201, a + 1], [a + 1, a + 201, a + 202]]).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    // The build itself uses all threads, and gives the same bytes for any number of them.
    let mesh = WideMesh::build(waves()?, &BuildConfig::balanced())?;

    // A tree is shared as it is: a query needs no more than a reference.
    let (width, height) = (72, 36);
    let origin = |x: u32, y: u32| [0.05 * x as f32 - 1.8, 4.0, 0.1 * y as f32 - 1.8];
    let rows: Vec<String> = (0..height)
        .into_par_iter()
        .map(|y| {
            let row = (0..width).map(|x| {
                let ray = TraversalRay::new(&Ray::new(origin(x, y), [0.0, -1.0, 0.0]));
                let hit = ray.and_then(|ray| mesh.intersect(&ray, Interval::FULL));
                hit.map_or(' ', |hit| if hit.t < 4.0 { '#' } else { '.' })
            });
            row.collect()
        })
        .collect();
    println!("{}", rows.join("\n"));

    // Of many rays at once the tree keeps several on their way, on every thread of the pool.
    let rays: Vec<RaySegment> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| RaySegment {
            origin: origin(x, y),
            t_min: 0.0,
            direction: [0.0, -1.0, 0.0],
            t_max: f32::INFINITY,
        })
        .collect();
    let mut hits = vec![None; rays.len()];
    mesh.par_intersect_many(&rays, &mut hits);
    let count = hits.iter().flatten().count();
    assert_eq!(count, rows.concat().chars().filter(|&c| c != ' ').count());
    println!("{count} of {} rays hit", rays.len());
    Ok(())
}
