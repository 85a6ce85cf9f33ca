//! The Camera directive.

use geometry::glam::DVec3;

use super::parameters::Parameters;
use super::state::{TransformSet, uniform_scale};
use super::world::World;
use crate::{Camera, LoadError};

/// Sets the scene's camera from `Camera "kind"`, whose space is reached by `ctm`; only "perspective" is known.
///
/// A camera looks along +z of its space, with +x to the right and +y up. pbrt's world is left-handed; under a CTM that
/// mirrors, as by Scale -1 1 1 before LookAt, it is right-handed.
pub(super) fn set_camera(
    world: &mut World,
    kind: &str,
    mut parameters: Parameters<'_>,
    ctm: &TransformSet,
) -> Result<(), LoadError> {
    if kind != "perspective" {
        world.warn(format!("Camera \"{kind}\" is not known, only \"perspective\": the scene has no camera"));
        return Ok(());
    }
    if ctm.is_animated() {
        world.warn("the camera moves: it is used as it stands at the start of its motion");
    }
    // Printed matrices are no exact similarities; a thousandth cannot be seen.
    if uniform_scale(&ctm.start, 1e-3).is_none() {
        world.warn("the camera's transform distorts: its position and directions are used, the distortion is not");
    }
    let camera_to_world = ctm.start.inverse();
    let eye = camera_to_world.point(DVec3::ZERO);
    let forward = camera_to_world.vector(DVec3::Z).normalize_or_zero();
    // As far away as the eye from the origin: next to an eye with large coordinates, f32 keeps no direction.
    let look = eye + forward * eye.length().max(1.0);
    let up = camera_to_world.vector(DVec3::Y).normalize_or_zero();
    let fov = match parameters.float("halffov")? {
        Some(half) => 2.0 * half,
        None => parameters.float("fov")?.unwrap_or(90.0),
    };
    let mut time = |name, default| Ok(parameters.float(name)?.unwrap_or(default) as f32);
    let camera = Camera {
        eye: eye.as_vec3().to_array(),
        look: look.as_vec3().to_array(),
        up: up.as_vec3().to_array(),
        fov: fov as f32,
        shutter: [time("shutteropen", 0.0)?, time("shutterclose", 1.0)?],
        left_handed: !ctm.start.swaps_handedness(),
    };
    camera.view(1, 1).map_err(|error| parameters.malformed(error.to_string()))?;
    world.set_camera(camera);
    for warning in parameters.into_warnings() {
        world.warn(warning);
    }
    Ok(())
}
