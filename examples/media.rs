//! The media along a ray: a cloud that is no surface, and in it a ball of glass full of smoke.

use std::error::Error;

use bvh_flat::geometry::{Interval, Ray, Sphere, TraversalRay};
use bvh_flat::primitive::{
    GeometricPrimitive, MaterialId, MediumId, MediumInterface, Primitive, Surface, medium_boundaries,
};
use bvh_flat::{BuildConfig, BvhAggregate};

const NAMES: [&str; 2] = ["cloud", "smoke"];

fn name(medium: Option<MediumId>) -> &'static str {
    medium.map_or("vacuum", |id| NAMES[id.index() as usize])
}

fn main() -> Result<(), Box<dyn Error>> {
    let [cloud, smoke] = [0, 1].map(MediumId::from_index);
    let glass = Surface::of_material(MaterialId::from_index(0).ok_or("too many materials")?);
    let world = BvhAggregate::build(
        vec![
            GeometricPrimitive::new(
                Sphere::new([0.0, 0.0, 0.0], 2.0)?,
                Surface::MediumBoundary,
                MediumInterface { inside: cloud, outside: None },
            ),
            GeometricPrimitive::new(
                Sphere::new([0.0, 0.0, 0.0], 1.0)?,
                glass,
                MediumInterface { inside: smoke, outside: cloud },
            ),
        ],
        &BuildConfig::balanced(),
    )?;

    let ray = TraversalRay::new(&Ray::new([0.0, 0.5, -5.0], [0.0, 0.0, 1.0])).ok_or("the ray has no direction")?;
    // The cloud has no material: only the glass is hit.
    let hit = world.intersect(&ray, Interval::FULL).ok_or("the glass is ahead")?;
    println!("the glass is hit at t = {}", hit.t);
    for boundary in medium_boundaries(&world, &ray, Interval::FULL) {
        println!("t = {:.4}: from {} into {}", boundary.hit.t, name(boundary.from), name(boundary.to));
    }
    // What a renderer attenuates by: the way up to the surface that it shades.
    let way = medium_boundaries(&world, &ray, Interval::up_to(hit.t));
    let last = way.last().ok_or("the cloud is entered before the glass")?;
    println!("{} of cloud before the glass", hit.t - last.hit.t);
    Ok(())
}
