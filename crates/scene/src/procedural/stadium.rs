//! A teapot in a stadium: everything that a scene can have.

use geometry::glam::{DVec2, DVec3};
use geometry::{AnimatedTransform, Keyframe, Transform};

use super::kit::{Kit, camera, standing};
use super::{BuiltInError, Random, meshes, props, stands};
use crate::Scene;

/// The bowl is round in its own space and stretched so much along x.
const STRETCH: f64 = 1.3;

/// The pitch lies in y = 0 around the origin and is an ellipse, as the bowl around it; the teapot stands in its middle.
pub(super) fn scene(seed: u64) -> Result<Scene, BuiltInError> {
    let mut random = Random::new(seed, 0);
    let mut kit = Kit::new();
    ground(&mut kit)?;
    let bowl = stands::bowl(&mut kit, &mut random)?;
    kit.place(bowl, Transform::scale(DVec3::new(STRETCH, 1.0, 1.0))?)?;
    floodlights(&mut kit)?;
    exhibits(&mut kit)?;
    flying(&mut kit, &mut random)?;
    Ok(kit.finish(camera(DVec3::new(3.6, 5.4, 14.2), DVec3::new(0.2, 2.2, 0.0), 50.0)))
}

/// Stripes of grass with white lines on them, in a plain: the largest triangles and thin ones.
fn ground(kit: &mut Kit) -> Result<(), BuiltInError> {
    kit.mesh(meshes::cuboid(DVec3::new(-60.0, -1.0, -60.0), DVec3::new(60.0, -0.05, 60.0)), "plain")?;
    let (width, depth) = (STRETCH * stands::INNER_RADIUS, stands::INNER_RADIUS);
    let edge = |x: f64| depth * (1.0 - (x / width) * (x / width)).max(0.0).sqrt();
    for i in 0..14 {
        let x = |column: f64| 0.99 * width * ((f64::from(i) + column / 6.0) / 7.0 - 1.0);
        let stripe = meshes::grid(6, 1, |column, row| {
            let x = x(column as f64);
            DVec3::new(x, 0.0, if row == 0 { -edge(x) } else { edge(x) })
        });
        kit.mesh(stripe, if i % 2 == 0 { "grass light" } else { "grass dark" })?;
    }
    let line =
        |radius: f64| [(radius - 0.06, 0.005), (radius + 0.06, 0.005), (radius + 0.06, 0.02), (radius - 0.06, 0.02)];
    let circle = |radius: f64| meshes::revolution_ring(&line(radius).map(|(r, h)| DVec2::new(r, h)), 96);
    let halfway = meshes::cuboid(DVec3::new(-0.06, 0.005, -8.0), DVec3::new(0.06, 0.02, 8.0));
    kit.mesh(meshes::merge(&[circle(4.0)?, circle(8.0)?, halfway?]), "line")
}

/// Four masts behind the stands, which look at the middle.
fn floodlights(kit: &mut Kit) -> Result<(), BuiltInError> {
    let mast = props::floodlight(kit)?;
    for degrees in [38.0, 142.0, 218.0, 322.0] {
        let outside = stands::OUTER_RADIUS + 2.0;
        let (sin, cos) = libm::sincos(f64::to_radians(degrees));
        kit.place(mast, standing(outside * DVec3::new(STRETCH * cos, 0.0, -sin), degrees + 180.0)?)?;
    }
    Ok(())
}

/// What stands on the pitch.
fn exhibits(kit: &mut Kit) -> Result<(), BuiltInError> {
    let pedestal = props::pedestal(kit)?;
    let wide = |at: DVec3, scale: DVec3| -> Result<Transform, BuiltInError> {
        Ok(Transform::translate(at)?.then_inside(&Transform::scale(scale)?)?)
    };
    let teapot = props::teapot(kit)?;
    kit.place(pedestal, wide(DVec3::ZERO, DVec3::new(2.0, 1.0, 2.0))?)?;
    kit.place(teapot, standing(DVec3::new(0.0, 1.0, 0.0), -25.0)?)?;

    let knot = props::knot(kit)?;
    let at = DVec3::new(-6.2, 0.0, -1.0);
    kit.place(pedestal, wide(at, DVec3::new(1.2, 0.8, 1.2))?)?;
    let upright = standing(at + 2.5 * DVec3::Y, 30.0)?.then_inside(&Transform::rotate(90.0, DVec3::X)?)?;
    kit.place(knot, upright)?;

    let ball = props::bumpy_ball(kit)?;
    let at = DVec3::new(6.0, 0.0, -1.6);
    kit.place(pedestal, wide(at, DVec3::new(1.0, 0.8, 1.0))?)?;
    kit.place(ball, wide(at + 2.0 * DVec3::Y, DVec3::splat(1.2))?)?;

    let wheel = props::wheel(kit)?;
    kit.place(wheel, standing(DVec3::new(-4.6, 0.0, 4.6), 22.0)?)?;
    kit.place(wheel, standing(DVec3::new(5.6, 0.0, -6.5), -30.0)?)?;
    let parasol = props::parasol(kit)?;
    for (x, z) in [(9.5, 3.2), (-9.8, 2.6), (10.4, -3.4), (-10.6, -3.8)] {
        kit.place(parasol, wide(DVec3::new(x, 0.0, z), DVec3::splat(1.1))?)?;
    }

    kit.sphere(DVec3::new(3.4, 0.8, 3.6), 0.8, "glass", Some("liquid"))?;
    kit.sphere(DVec3::new(5.0, 0.5, 4.4), 0.5, "glass", None)?;
    kit.sphere(DVec3::new(4.7, 0.3, 5.6), 0.3, "mirror", None)?;
    kit.sphere(DVec3::new(-2.1, 0.55, 3.6), 0.55, "mirror", None)?;
    // Just above the grass, so that no ray meets both at one t.
    kit.medium(meshes::cuboid(DVec3::new(-9.0, 0.03, -4.5), DVec3::new(-3.6, 2.8, 3.0)), "fog")
}

/// What moves: balls that bounce and turn, and drones whose rotors turn too.
fn flying(kit: &mut Kit, random: &mut Random) -> Result<(), BuiltInError> {
    let ball = props::ball(kit)?;
    for (x, z) in [(0.6, 5.6), (2.2, 7.6), (7.4, 1.6), (-1.4, 7.2), (-7.6, 4.6)] {
        let start = DVec3::new(x, 0.25 + random.between(0.0, 0.3), z);
        let step = DVec3::new(random.between(0.3, 0.6), 0.0, random.between(-0.3, 0.3));
        let axis = random.direction();
        // A parabola through three moments.
        let frames = [(0.0, 0.0), (0.5, 0.25), (1.0, 0.0)].map(|(time, rise)| -> Result<Keyframe, BuiltInError> {
            let at = start + f64::from(time) * step + rise * DVec3::Y;
            let turn = Transform::rotate(120.0 * f64::from(time), axis)?;
            Ok(Keyframe { time, transform: Transform::translate(at)?.then_inside(&turn)? })
        });
        kit.place(ball, AnimatedTransform::new(frames.into_iter().collect::<Result<_, _>>()?)?)?;
    }
    let drone = props::drone(kit)?;
    for (x, y, z) in [(-2.6, 5.6, 2.0), (3.8, 5.2, -2.0), (7.0, 6.4, 1.0), (-6.5, 6.2, -3.0)] {
        let (from, degrees) = (DVec3::new(x, y, z), random.between(0.0, 360.0));
        let step = 0.3 * random.direction();
        let frames = [0.0_f32, 1.0].map(|time| -> Result<Keyframe, BuiltInError> {
            let t = f64::from(time);
            Ok(Keyframe { time, transform: standing(from + t * step, degrees + 25.0 * t)? })
        });
        kit.place(drone, AnimatedTransform::new(frames.into_iter().collect::<Result<_, _>>()?)?)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geometry, SceneShape};
    use primitive::{Placement, Surface};

    fn material(scene: &Scene, geometry: &Geometry) -> Option<String> {
        match geometry.surface {
            Surface::Material { material, .. } => Some(scene.names.materials[material.index() as usize].clone()),
            Surface::MediumBoundary => None,
        }
    }

    #[test]
    fn all_is_closed_but_cloth_and_grass() {
        let scene = scene(0).expect("of fixed size");
        let mut open = Vec::new();
        for geometry in scene.geometries() {
            if let SceneShape::Mesh(mesh) = &geometry.shape
                && !meshes::is_closed(mesh)
            {
                open.push(material(&scene, geometry).expect("the boundary is closed"));
            }
        }
        open.sort();
        open.dedup();
        assert_eq!(open, ["canvas", "carbon", "flag", "grass dark", "grass light"]);
    }

    /// Triangles and depth of the instances below an object.
    fn instanced(scene: &Scene, object: usize) -> (u64, u32, u32) {
        let object = &scene.objects()[object];
        let triangles = |&g: &u32| match &scene.geometries()[g as usize].shape {
            SceneShape::Mesh(mesh) => mesh.len() as u64,
            SceneShape::Sphere(_) => 0,
        };
        let own = object.geometries.iter().map(triangles).sum();
        object.instances.iter().fold((own, 0, 0), |(sum, instances, depth), instance| {
            let (t, i, d) = instanced(scene, instance.object.index());
            (sum + t, instances + 1 + i, depth.max(1 + d))
        })
    }

    #[test]
    fn it_has_everything() {
        let scene = scene(0).expect("of fixed size");
        let (triangles, instances, depth) = instanced(&scene, 0);
        assert!((200_000..400_000).contains(&triangles), "{triangles}");
        assert!(instances > 1000 && depth >= 3, "{instances} {depth}");
        let any = |test: &dyn Fn(&Geometry) -> bool| scene.geometries().iter().any(test);
        assert!(any(&|g| g.surface == Surface::MediumBoundary && g.media.is_transition()), "fog");
        assert!(any(&|g| g.surface.has_material() && g.media.is_transition()), "a filled glass");
        assert!(any(&|g| matches!(g.surface, Surface::Material { area_light: Some(_), .. })), "lamps");
        assert!(any(&|g| matches!(g.shape, SceneShape::Sphere(_))), "spheres");
        let moving: Vec<bool> = scene
            .objects()
            .iter()
            .map(|o| o.instances.iter().any(|i| matches!(i.placement, Placement::Animated(_))))
            .collect();
        let nested = scene
            .world()
            .instances
            .iter()
            .any(|i| matches!(i.placement, Placement::Animated(_)) && moving[i.object.index()]);
        assert!(moving[0] && nested, "motion within motion");
        assert_eq!(scene.names.media, ["liquid", "fog"]);
        assert_eq!(scene.names.area_lights, ["floodlight"]);
    }

    /// A bound on the longest side over the shortest height says how thin the thinnest are.
    #[test]
    fn there_are_slivers() {
        let scene = scene(0).expect("of fixed size");
        let meshes = scene.geometries().iter().filter_map(|g| match &g.shape {
            SceneShape::Mesh(mesh) => Some(mesh),
            SceneShape::Sphere(_) => None,
        });
        let thin = meshes.flat_map(|mesh| (0..mesh.len()).map(|i| mesh.vertices(i))).filter(|&[a, b, c]| {
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let area = (b - a).cross(c - a).length();
            assert!(area > 0.0, "a triangle without area is never hit");
            longest * longest > 50.0 * area
        });
        assert!(thin.count() > 1000);
    }
}
