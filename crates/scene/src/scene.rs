//! A scene as plain data: what the loaders make and the builders take.

use std::sync::Arc;

use geometry::{Bounds3, Shape, Sphere, TriangleMesh};
use primitive::{MediumInterface, Placement, Surface};
use thiserror::Error;

use crate::Camera;

/// Everything that a scene file says and this project models.
///
/// Geometries are numbered in scene order, over all objects; object 0 is the world. An object only instances objects
/// whose definition is complete, so there are no cycles, by construction in [`SceneBuilder`].
#[derive(Clone, Debug, Default)]
pub struct Scene {
    geometries: Vec<Geometry>,
    objects: Vec<Object>,
    /// The names behind material, area light and medium ids.
    pub names: Names,
    /// The view that the file asks for.
    pub camera: Option<Camera>,
    /// What was skipped or looks wrong, in words, once for each kind.
    pub warnings: Vec<String>,
}

/// The tables behind the ids: entry `i` is the name of id `i`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// Of materials.
    pub materials: Vec<String>,
    /// Of area lights.
    pub area_lights: Vec<String>,
    /// Of media.
    pub media: Vec<String>,
}

/// A shape in the space of its object, with what its surface is.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// The shape.
    pub shape: SceneShape,
    /// What its surface is.
    pub surface: Surface,
    /// The media on both sides.
    pub media: MediumInterface,
}

/// The closed set of shapes in scenes.
#[derive(Clone, Debug)]
pub enum SceneShape {
    /// A triangle mesh, shared by all that use it.
    Mesh(Arc<TriangleMesh>),
    /// A sphere.
    Sphere(Sphere),
}

impl SceneShape {
    /// How many primitives it consists of.
    pub fn primitive_count(&self) -> u64 {
        match self {
            Self::Mesh(mesh) => mesh.primitive_count(),
            Self::Sphere(_) => 1,
        }
    }

    /// Its box, in the space of its object.
    pub fn bounds(&self) -> Bounds3 {
        match self {
            Self::Mesh(mesh) => mesh.object_bound(),
            Self::Sphere(sphere) => sphere.object_bound(),
        }
    }
}

/// The number of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(u32);

impl ObjectId {
    /// The world.
    pub const WORLD: Self = Self(0);

    /// Its place in [`Scene::objects`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Shapes and instances that are placed together.
#[derive(Clone, Debug, Default)]
pub struct Object {
    /// What the file calls it; empty for the world.
    pub name: String,
    /// The numbers of its geometries, in scene order.
    pub geometries: Vec<u32>,
    /// Its instances of other objects, in scene order.
    pub instances: Vec<Instance>,
}

/// An object placed in another.
#[derive(Clone, Debug)]
pub struct Instance {
    /// What is placed.
    pub object: ObjectId,
    /// Where.
    pub placement: Placement,
}

impl Scene {
    /// All geometries, in scene order.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// All objects; the first is the world.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The world.
    pub fn world(&self) -> &Object {
        &self.objects[0]
    }

    /// How many triangles are in memory: each mesh of each geometry once.
    pub fn triangle_count(&self) -> u64 {
        let meshes = self.geometries.iter().filter(|g| matches!(g.shape, SceneShape::Mesh(_)));
        meshes.map(|g| g.shape.primitive_count()).sum()
    }
}

/// Why a scene cannot be put together.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneError {
    /// An instance names an object that is not complete where it stands: itself, or one around it.
    #[error("object \"{0}\" is used inside of its own definition")]
    Cycle(String),
    /// More geometries or objects than 32-bit numbers can name.
    #[error("more than 2^32 geometries or objects")]
    TooLarge,
    /// Instances of instances add up to more primitives, or paths, than can be numbered.
    #[error("the instances add up to more than 2^62 primitives")]
    TooManyInstances,
}

/// Puts a scene together: geometries and instances go into the object that is open, the world at first.
#[derive(Debug)]
pub struct SceneBuilder {
    scene: Scene,
    /// The objects being defined, the innermost last; the world is the first.
    open: Vec<ObjectId>,
    /// For each object how many primitives and instance paths it has, instances counted like copies.
    sizes: Vec<u64>,
}

/// The most primitives and instance paths together.
const MAX_SIZE: u64 = 1 << 62;

impl Default for SceneBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl SceneBuilder {
    /// An empty world.
    pub fn new() -> Self {
        let scene = Scene { objects: vec![Object::default()], ..Scene::default() };
        Self { scene, open: vec![ObjectId::WORLD], sizes: vec![0] }
    }

    /// The tables of names, camera and warnings so far.
    pub fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// Adds a geometry to the open object; its number.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`], [`SceneError::TooManyInstances`].
    pub fn add_geometry(&mut self, geometry: Geometry) -> Result<u32, SceneError> {
        let number = u32::try_from(self.scene.geometries.len()).map_err(|_| SceneError::TooLarge)?;
        self.grow_open_object(geometry.shape.primitive_count())?;
        self.scene.geometries.push(geometry);
        self.open_object().geometries.push(number);
        Ok(number)
    }

    /// Places an object in the open one.
    ///
    /// # Errors
    /// [`SceneError::Cycle`] where `object` is still open; [`SceneError::TooManyInstances`].
    pub fn add_instance(&mut self, object: ObjectId, placement: impl Into<Placement>) -> Result<(), SceneError> {
        if self.open.contains(&object) {
            return Err(SceneError::Cycle(self.scene.objects[object.index()].name.clone()));
        }
        self.grow_open_object(self.sizes[object.index()] + 1)?;
        let instance = Instance { object, placement: placement.into() };
        self.open_object().instances.push(instance);
        Ok(())
    }

    /// Begins an object: what is added from now on goes into it.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`].
    pub fn begin_object(&mut self, name: impl Into<String>) -> Result<ObjectId, SceneError> {
        let id = ObjectId(u32::try_from(self.scene.objects.len()).map_err(|_| SceneError::TooLarge)?);
        self.scene.objects.push(Object { name: name.into(), ..Object::default() });
        self.open.push(id);
        self.sizes.push(0);
        Ok(id)
    }

    /// Ends the object begun last; does nothing where only the world is open.
    pub fn end_object(&mut self) {
        if self.open.len() > 1 {
            self.open.pop();
        }
    }

    /// Notes something that was skipped or looks wrong; the same words only once.
    pub fn warn(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if !self.scene.warnings.contains(&warning) {
            self.scene.warnings.push(warning);
        }
    }

    /// The scene. Counts the triangles that cannot be hit because a coordinate is NaN, infinite or too large, and
    /// warns of them.
    pub fn finish(mut self) -> Scene {
        let inactive: usize = self
            .scene
            .geometries
            .iter()
            .filter_map(|g| match &g.shape {
                SceneShape::Mesh(mesh) => Some(mesh),
                SceneShape::Sphere(_) => None,
            })
            .map(|mesh| (0..mesh.len()).filter(|&i| !mesh.triangle_bounds(i).is_valid()).count())
            .sum();
        if inactive > 0 {
            self.warn(format!(
                "{inactive} triangles have a coordinate that is NaN, infinite or beyond 2^60: they keep their index and are never hit"
            ));
        }
        self.scene
    }

    fn grow_open_object(&mut self, by: u64) -> Result<(), SceneError> {
        let open = self.open.last().map_or(0, |id| id.index());
        let size = self.sizes[open].saturating_add(by);
        if size > MAX_SIZE {
            return Err(SceneError::TooManyInstances);
        }
        self.sizes[open] = size;
        Ok(())
    }

    fn open_object(&mut self) -> &mut Object {
        let open = self.open.last().map_or(0, |id| id.index());
        &mut self.scene.objects[open]
    }
}
