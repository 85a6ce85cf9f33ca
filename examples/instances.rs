//! Instances, nested and moving: one mesh in memory, a row of three of it, and two rows, one of which moves.

use std::error::Error;
use std::sync::Arc;

use bvh_flat::geometry::{AnimatedTransform, Interval, Keyframe, Ray, Transform, TraversalRay, TriangleMesh};
use bvh_flat::primitive::{
    GeometricPrimitive, MaterialId, MediumInterface, Placement, Primitive, Surface, TransformedPrimitive,
};
use bvh_flat::{BuildConfig, BvhAggregate, WideMesh};

fn main() -> Result<(), Box<dyn Error>> {
    let config = BuildConfig::balanced();
    let corners = [[0.0, 0.0, 0.0], [0.8, 0.0, 0.0], [0.8, 0.8, 0.0], [0.0, 0.8, 0.0]];
    let square = WideMesh::build(TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?, &config)?;
    let material = MaterialId::from_index(0).ok_or("too many materials")?;
    let square = GeometricPrimitive::new(square, Surface::of_material(material), MediumInterface::VACUUM);
    let square = Arc::new(square);

    // A row of three; the transforms are applied to rays, not to the mesh.
    let places = [0.0, 1.0, 2.0].map(|x| Transform::translate([x, 0.0, 0.0]));
    let mut row = Vec::new();
    for place in places {
        row.push(TransformedPrimitive::new(Arc::clone(&square), place?));
    }
    let row = Arc::new(BvhAggregate::build(row, &config)?);

    // Two rows: one at rest, one before it that rises by 1 while the shutter is open.
    let moment = |time, y| -> Result<_, Box<dyn Error>> {
        Ok(Keyframe { time, transform: Transform::translate([0.0, y, 1.0])? })
    };
    let motion = AnimatedTransform::new(vec![moment(0.0, 0.0)?, moment(1.0, 1.0)?])?;
    let rest: Placement = Transform::translate([0.0, 0.0, 0.0])?.into();
    let rows = [rest, motion.into()].map(|place| TransformedPrimitive::new(Arc::clone(&row), place));
    let world = BvhAggregate::build(rows.into(), &config)?;
    println!("{} triangles, 2 of them in memory", world.primitive_count());

    for time in [0.0, 0.5, 1.0] {
        let ray = Ray::new([1.6, 0.2, 5.0], [0.0, 0.0, -1.0]).at_time(time);
        let ray = TraversalRay::new(&ray).ok_or("the ray has no direction")?;
        let hit = world.intersect(&ray, Interval::FULL).ok_or("the row at rest is always there")?;
        let at = world.interaction(&ray, &hit);
        println!("at time {time}: t = {}, triangle {}, at {} ± {}", hit.t, hit.primitive, at.p(), at.p_error());
    }
    Ok(())
}
