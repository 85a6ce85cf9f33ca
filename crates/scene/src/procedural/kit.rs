//! What the built-in scenes are put together with.

use std::sync::Arc;

use geometry::glam::DVec3;
use geometry::{MeshError, Sphere, Transform, TriangleMesh};
use primitive::{AreaLightId, MaterialId, MediumId, MediumInterface, Placement, Surface};

use super::BuiltInError;
use crate::{Camera, Geometry, ObjectId, Scene, SceneBuilder, SceneError, SceneShape};

/// A [`SceneBuilder`] that knows materials, lights and media by their names.
pub(super) struct Kit(SceneBuilder);

impl Kit {
    pub(super) fn new() -> Self {
        Self(SceneBuilder::new())
    }

    pub(super) fn finish(mut self, camera: Camera) -> Scene {
        self.0.scene_mut().camera = Some(camera);
        self.0.finish()
    }

    /// Adds a mesh of one material, with vacuum around it. It takes a generator's result as it comes.
    pub(super) fn mesh(&mut self, mesh: Result<TriangleMesh, MeshError>, material: &str) -> Result<(), BuiltInError> {
        let surface = self.surface(material)?;
        self.geometry(SceneShape::Mesh(Arc::new(mesh?)), surface, MediumInterface::VACUUM)
    }

    /// Adds a mesh that emits light.
    pub(super) fn lamp(
        &mut self,
        mesh: Result<TriangleMesh, MeshError>,
        material: &str,
        light: &str,
    ) -> Result<(), BuiltInError> {
        let id = AreaLightId::from_index(position_or_add(&mut self.0.scene_mut().names.area_lights, light)?);
        let material = self.material(material)?;
        let surface = Surface::Material { material, area_light: id };
        self.geometry(SceneShape::Mesh(Arc::new(mesh?)), surface, MediumInterface::VACUUM)
    }

    /// Adds a closed mesh that only encloses a medium.
    pub(super) fn medium(&mut self, mesh: Result<TriangleMesh, MeshError>, inside: &str) -> Result<(), BuiltInError> {
        let media = self.filled_with(inside)?;
        self.geometry(SceneShape::Mesh(Arc::new(mesh?)), Surface::MediumBoundary, media)
    }

    /// Adds a sphere of one material, with a medium in it or vacuum.
    pub(super) fn sphere(
        &mut self,
        center: DVec3,
        radius: f64,
        material: &str,
        inside: Option<&str>,
    ) -> Result<(), BuiltInError> {
        let surface = self.surface(material)?;
        let media = inside.map_or(Ok(MediumInterface::VACUUM), |medium| self.filled_with(medium))?;
        let sphere = Sphere::new(center.as_vec3(), radius as f32)?;
        self.geometry(SceneShape::Sphere(sphere), surface, media)
    }

    /// An object of what `define` adds.
    pub(super) fn object(
        &mut self,
        name: &str,
        define: impl FnOnce(&mut Self) -> Result<(), BuiltInError>,
    ) -> Result<ObjectId, BuiltInError> {
        let object = self.0.begin_object(name)?;
        define(self)?;
        self.0.end_object();
        Ok(object)
    }

    /// Places an object in the one that is being defined.
    pub(super) fn place(&mut self, object: ObjectId, placement: impl Into<Placement>) -> Result<(), BuiltInError> {
        Ok(self.0.add_instance(object, placement)?)
    }

    fn geometry(&mut self, shape: SceneShape, surface: Surface, media: MediumInterface) -> Result<(), BuiltInError> {
        self.0.add_geometry(Geometry { shape, surface, media })?;
        Ok(())
    }

    fn surface(&mut self, material: &str) -> Result<Surface, BuiltInError> {
        Ok(Surface::of_material(self.material(material)?))
    }

    fn material(&mut self, name: &str) -> Result<MaterialId, BuiltInError> {
        let index = position_or_add(&mut self.0.scene_mut().names.materials, name)?;
        Ok(MaterialId::from_index(index).ok_or(SceneError::TooLarge)?)
    }

    fn filled_with(&mut self, medium: &str) -> Result<MediumInterface, BuiltInError> {
        let index = position_or_add(&mut self.0.scene_mut().names.media, medium)?;
        Ok(MediumInterface { inside: MediumId::from_index(index), outside: None })
    }
}

fn position_or_add(names: &mut Vec<String>, name: &str) -> Result<u32, SceneError> {
    let index = names.iter().position(|known| known == name).unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    });
    u32::try_from(index).map_err(|_| SceneError::TooLarge)
}

/// First turned by `degrees` around the y axis, then moved to `at`.
pub(super) fn standing(at: DVec3, degrees: f64) -> Result<Transform, BuiltInError> {
    Ok(Transform::translate(at)?.then_inside(&Transform::rotate(degrees, DVec3::Y)?)?)
}

/// The right-handed camera at `eye` that looks at `look` with y up, for the time 0 to 1.
pub(super) fn camera(eye: DVec3, look: DVec3, fov: f32) -> Camera {
    let [eye, look] = [eye, look].map(|p| p.as_vec3().to_array());
    Camera { eye, look, fov, ..Camera::default() }
}
