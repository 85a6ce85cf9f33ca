//! A mesh that deforms: the tree is refitted from frame to frame, and built anew where that has made it too bad.

use std::error::Error;
use std::sync::Arc;

use bvh_flat::geometry::{Interval, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, WideMesh};

const SIZE: u32 = 64;

/// The vertices of a sheet that is rolled up as time goes on from 0 to 1.
fn positions(time: f32) -> impl Iterator<Item = [f32; 3]> {
    let positions = (0..=SIZE).flat_map(|y| (0..=SIZE).map(move |x| [x, y].map(|i| i as f32 / SIZE as f32)));
    positions.map(move |[x, y]| {
        let (angle, radius) = (12.0 * time * x, 1.0 - 0.8 * x);
        if time == 0.0 { [x, 0.0, y] } else { [radius * angle.sin(), radius * (1.0 - angle.cos()), y] }
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let triangles = (0..SIZE * SIZE).flat_map(|i| {
        let a = i / SIZE * (SIZE + 1) + i % SIZE;
        [[a, a + 1, a + SIZE + 2], [a, a + SIZE + 2, a + SIZE + 1]]
    });
    let sheet = TriangleMesh::new(positions(0.0), triangles.collect())?;

    // Without spatial splits, whose pieces of triangles cannot be moved.
    let config = BuildConfig::balanced();
    let mut tree = WideMesh::build(sheet.clone(), &config)?;
    let mut cost = 1.0;
    for frame in 1..=10 {
        let moved = Arc::new(sheet.clone().with_positions(positions(frame as f32 / 10.0))?);
        // As a part of the cost before this step: all steps since the last build are multiplied.
        cost *= tree.refit(Arc::clone(&moved))?;
        let is_bad = cost > 2.0;
        println!("frame {frame}: rays cost {cost:.2} times as much as after the last build");
        if is_bad {
            (tree, cost) = (WideMesh::build(Arc::clone(&moved), &config)?, 1.0);
            println!("          built anew");
        }
        // Whichever it is, it answers as a new one.
        let new = WideMesh::build(moved, &config)?;
        for i in 0..1000 {
            let (x, z) = ((i % 40) as f32 / 20.0 - 1.0, (i / 40) as f32 / 25.0);
            let ray = TraversalRay::new(&Ray::new([x, 5.0, z], [0.0, -1.0, 0.01])).ok_or("the ray has no direction")?;
            assert_eq!(tree.intersect(&ray, Interval::FULL), new.intersect(&ray, Interval::FULL));
        }
    }
    Ok(())
}
