//! Ray masks, alpha and shadow rays to a lamp: which hits count is for the renderer to say, by the hit alone.

use std::error::Error;

use bvh_flat::geometry::{ClosestHit, FirstHit, Hit, Interval, Ray, TraversalRay, TriangleMesh};
use bvh_flat::primitive::{GeometricPrimitive, HitKind, MaterialId, MediumInterface, Primitive, Surface};
use bvh_flat::{BuildConfig, BvhAggregate, WideMesh};

type World = BvhAggregate<GeometricPrimitive<WideMesh>>;

// Kinds of rays, a bit each; and of each member of the world, which kinds meet it.
const CAMERA: u8 = 1;
const SHADOW: u8 = 2;
const NAMES: [&str; 4] = ["floor", "lamp", "leaf", "glow"];
const MASKS: [u8; 4] = [CAMERA | SHADOW, CAMERA | SHADOW, CAMERA | SHADOW, CAMERA];

/// Whether rays of this kind meet what was hit: its mask says so, and the leaf has a hole where alpha is 0.
fn is_met(world: &World, kind: u8, hit: &Hit) -> bool {
    let (member, Hit { primitive, u, v, .. }) = world.list().member_of(hit);
    let mesh = world.list().members()[member].shape().mesh();
    let uv = mesh.surface_at(primitive as usize, u, v).uv;
    let is_hole = NAMES[member] == "leaf" && (uv - 0.5).length() < 0.25;
    MASKS[member] & kind != 0 && !is_hole
}

/// A square of side 2 around the y axis.
fn square(y: f32) -> Result<GeometricPrimitive<WideMesh>, Box<dyn Error>> {
    let uvs = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let mesh = TriangleMesh::new(uvs.map(|[u, v]| [2.0 * u - 1.0, y, 2.0 * v - 1.0]), vec![[0, 1, 2], [0, 2, 3]])?;
    let mesh = WideMesh::build(mesh.with_uvs(uvs)?, &BuildConfig::balanced())?;
    let surface = Surface::of_material(MaterialId::from_index(0).ok_or("too many materials")?);
    Ok(GeometricPrimitive::new(mesh, surface, MediumInterface::VACUUM))
}

fn main() -> Result<(), Box<dyn Error>> {
    let members = [0.0, 4.0, 2.0, 3.0].into_iter().map(square).collect::<Result<_, _>>()?;
    let world = World::build(members, &BuildConfig::balanced())?;
    // Onto the glow, through the leaf's hole, onto the leaf, and from below it.
    for [x, y] in [[0.1, 3.5], [0.1, 2.5], [0.8, 2.5], [-0.9, 1.5]] {
        let ray = TraversalRay::new(&Ray::new([x, y, 0.0], [0.0, -1.0, 0.0])).ok_or("the ray has no direction")?;
        let mut seen = ClosestHit::among(Interval::FULL, |hit| is_met(&world, CAMERA, hit));
        let _ = world.visit_hits(&ray, Interval::FULL, HitKind::Material, &mut seen);
        let hit = seen.hit().ok_or("the floor is below")?;
        let (member, _) = world.list().member_of(&hit);

        // To a place on the lamp; neither it nor the surface here is met below t = 1, without an epsilon.
        let lamp = world.list().members()[1].shape().mesh().surface_at(0, 0.3, 0.4);
        let to_lamp = world.interaction(&ray, &hit).spawn_ray_to(&lamp);
        let (to_lamp, way) = (TraversalRay::new(&to_lamp).ok_or("no way")?, Interval::up_to(1.0));
        let mut blocker = FirstHit::among(way, |hit| is_met(&world, SHADOW, hit));
        let is_lit = world.visit_hits(&to_lamp, way, HitKind::Material, &mut blocker).is_continue();
        println!("from {x}, {y}: the {} is seen, {}", NAMES[member], if is_lit { "lit" } else { "in shadow" });
    }
    Ok(())
}
