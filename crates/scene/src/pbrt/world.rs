//! The scene as it grows: shapes and objects, and the tables of what they refer to by name.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use primitive::{AreaLightId, MaterialId, MediumId, MediumInterface, Placement, Surface};

use super::parameters::Parameters;
use super::shapes::{self, ObjectShape};
use super::state::{Entries, Entry, GraphicsState};
use super::tokens::{Here, text};
use crate::spelling::did_you_mean;
use crate::{Camera, Geometry, LoadError, ObjectId, Place, Scene, SceneBuilder, SceneError};

/// No more warnings than these: a file can be wrong in any number of ways.
const MAX_WARNINGS: usize = 100;

/// What the directives have made so far.
#[derive(Debug)]
pub(super) struct World {
    builder: SceneBuilder,
    materials: Entries,
    named_materials: HashMap<String, Option<Entry>>,
    area_lights: Entries,
    media: HashMap<String, MediumId>,
    made_media: HashSet<String>,
    objects: HashMap<String, ObjectId>,
    /// The name of the object being defined.
    open_object: Option<String>,
    /// The kinds of shapes that are not known, and how many there were of each.
    unknown_shapes: Vec<(String, u64)>,
    /// The names of directives that are not known.
    unknown_directives: HashSet<String>,
}

impl World {
    /// An empty world, and its default material.
    pub(super) fn new() -> (Self, Entry) {
        let mut materials = Entries::default();
        let default = materials.add("default");
        let world = Self {
            builder: SceneBuilder::new(),
            materials,
            named_materials: HashMap::new(),
            area_lights: Entries::default(),
            media: HashMap::new(),
            made_media: HashSet::new(),
            objects: HashMap::new(),
            open_object: None,
            unknown_shapes: Vec::new(),
            unknown_directives: HashSet::new(),
        };
        (world, default)
    }

    /// The scene, with the warnings that need all of it.
    pub(super) fn finish(mut self) -> Scene {
        for (kind, count) in std::mem::take(&mut self.unknown_shapes) {
            self.warn(format!("Shape \"{kind}\" is not known: skipped, {count} in all"));
        }
        for name in self.builder.scene_mut().names.media.clone() {
            if !self.made_media.contains(&name) {
                self.warn(format!("the medium \"{name}\" is used but never made"));
            }
        }
        self.builder.finish()
    }

    /// Notes something that was skipped or looks wrong, the same words only once.
    pub(super) fn warn(&mut self, warning: impl Into<String>) {
        if self.builder.scene_mut().warnings.len() < MAX_WARNINGS {
            self.builder.warn(warning);
        }
    }

    /// Sets the view that the file asks for.
    pub(super) fn set_camera(&mut self, camera: Camera) {
        self.builder.scene_mut().camera = Some(camera);
    }

    /// A new material `name` of a kind; `None` of that which is no surface: "interface", in pbrt-v3 "none" or "".
    pub(super) fn material(&mut self, kind: &str, name: &str) -> Option<Entry> {
        let is_surface = !matches!(kind, "interface" | "none" | "");
        is_surface.then(|| self.materials.add(name))
    }

    /// MakeNamedMaterial. The names are the whole file's, as in pbrt-v4, and the latest of a name counts.
    pub(super) fn make_named_material(&mut self, name: String, kind: Option<&str>) {
        let material = self.material(kind.unwrap_or("default"), &name);
        self.named_materials.insert(name, material);
    }

    /// NamedMaterial.
    pub(super) fn named_material(&mut self, name: &str) -> Option<Entry> {
        if let Some(&material) = self.named_materials.get(name) {
            return material;
        }
        let warning =
            format!("NamedMaterial \"{}\" is used before it is made: taken for a surface", text(name.as_bytes()));
        self.warn(warning);
        self.make_named_material(name.to_owned(), None);
        self.named_materials.get(name).copied().flatten()
    }

    /// AreaLightSource; "" ends it.
    pub(super) fn area_light(&mut self, kind: &str) -> Option<Entry> {
        (!kind.is_empty()).then(|| self.area_lights.add(kind))
    }

    /// MakeNamedMedium.
    pub(super) fn make_named_medium(&mut self, name: String) {
        self.made_media.insert(name);
    }

    /// MediumInterface; "" is vacuum.
    pub(super) fn medium_interface(
        &mut self,
        here: Here<'_>,
        inside: String,
        outside: String,
    ) -> Result<MediumInterface, LoadError> {
        let [inside, outside] = [self.medium(here, inside)?, self.medium(here, outside)?];
        Ok(MediumInterface { inside, outside })
    }

    fn medium(&mut self, here: Here<'_>, name: String) -> Result<Option<MediumId>, LoadError> {
        if name.is_empty() {
            return Ok(None);
        }
        if let Some(id) = self.media.get(&name) {
            return Ok(Some(*id));
        }
        let names = &mut self.builder.scene_mut().names.media;
        let id = u32::try_from(names.len()).ok().and_then(MediumId::from_index).ok_or_else(|| too_large(here))?;
        names.push(name.clone());
        self.media.insert(name, id);
        Ok(Some(id))
    }

    /// Shape.
    pub(super) fn add_shape(
        &mut self,
        kind: &str,
        mut parameters: Parameters<'_>,
        placement: &Placement,
        state: &GraphicsState,
        resolve: impl FnOnce(&str) -> Result<PathBuf, LoadError>,
    ) -> Result<(), LoadError> {
        let here = parameters.here();
        let Some((shape, warnings)) = shapes::read(kind, &mut parameters, resolve)? else {
            self.count_unknown_shape(kind);
            return Ok(());
        };
        warnings.into_iter().for_each(|warning| self.warn(warning));
        // A mirroring leaves a sphere's outside outside, as that of a mesh. (pbrt flips the normal in object space,
        // from where the inverse transpose keeps it on its side, so that there a mirrored sphere is inside out.)
        let media = match (&shape, state.reverse_orientation) {
            (ObjectShape::Sphere { .. }, true) => {
                self.warn("ReverseOrientation of a sphere swaps its media; its normal points outward still");
                MediumInterface { inside: state.media.outside, outside: state.media.inside }
            }
            _ => state.media,
        };
        let transform = shape.carries(placement);
        let shape = shape.carried(&transform.unwrap_or_default(), state.reverse_orientation);
        let shape = shape.map_err(|reason| parameters.malformed(reason))?;
        parameters.into_warnings().for_each(|warning| self.warn(warning));
        let geometry = Geometry { shape, surface: self.surface(here, state)?, media };
        let error = |error: SceneError| here.malformed(error.to_string());
        if transform.is_some() {
            self.builder.add_geometry(geometry).map_err(error)?;
        } else {
            let object = self.builder.begin_object("").map_err(error)?;
            self.builder.add_geometry(geometry).map_err(error)?;
            self.builder.end_object();
            self.builder.add_instance(object, placement.clone()).map_err(error)?;
        }
        Ok(())
    }

    /// A directive that is none of `known`: warns of the first of each name, which may be a misspelling that changes
    /// the scene.
    pub(super) fn unknown_directive(&mut self, here: Here<'_>, name: &str, known: impl Iterator<Item = &'static str>) {
        if self.unknown_directives.len() < MAX_WARNINGS && self.unknown_directives.insert(name.to_owned()) {
            let hint = did_you_mean(name, known);
            let name = text(name.as_bytes());
            let (path, place) = (here.path.display(), Place::Line(here.line));
            self.warn(format!("{path}: {place}{name} is no known directive: skipped with its parameters{hint}"));
        }
    }

    fn count_unknown_shape(&mut self, kind: &str) {
        let kind = text(kind.as_bytes());
        let kinds = &mut self.unknown_shapes;
        if let Some((_, count)) = kinds.iter_mut().find(|(known, _)| *known == kind) {
            *count += 1;
        } else if kinds.len() < MAX_WARNINGS {
            kinds.push((kind, 1));
        }
    }

    /// The surface of a shape that is defined `here`.
    fn surface(&mut self, here: Here<'_>, state: &GraphicsState) -> Result<Surface, LoadError> {
        let Some(material) = state.material else {
            if state.area_light.is_some() {
                self.warn("an area light on a shape without a material is dropped: it cannot be seen");
            }
            return Ok(Surface::MediumBoundary);
        };
        let names = &mut self.builder.scene_mut().names;
        let material = self.materials.number(material, &mut names.materials).and_then(MaterialId::from_index);
        let material = material.ok_or_else(|| too_large(here))?;
        let Some(light) = state.area_light else { return Ok(Surface::of_material(material)) };
        let light = self.area_lights.number(light, &mut names.area_lights).and_then(AreaLightId::from_index);
        Ok(Surface::Material { material, area_light: Some(light.ok_or_else(|| too_large(here))?) })
    }

    /// ObjectBegin.
    pub(super) fn begin_object(&mut self, here: Here<'_>, name: &str) -> Result<(), LoadError> {
        let shown = text(name.as_bytes());
        if let Some(open) = &self.open_object {
            let open = text(open.as_bytes());
            return Err(here.malformed(format!("ObjectBegin \"{shown}\" stands within the object \"{open}\"")));
        }
        let object = self.builder.begin_object(name).map_err(|error| here.malformed(error.to_string()))?;
        if self.objects.insert(name.to_owned(), object).is_some() {
            self.warn(format!("the object \"{shown}\" is defined again; instances are of the latest before them"));
        }
        self.open_object = Some(name.to_owned());
        Ok(())
    }

    /// ObjectEnd.
    pub(super) fn end_object(&mut self) {
        self.builder.end_object();
        self.open_object = None;
    }

    /// ObjectInstance; in an object too, where pbrt has none.
    pub(super) fn add_instance(&mut self, here: Here<'_>, name: &str, placement: Placement) -> Result<(), LoadError> {
        let Some(&object) = self.objects.get(name) else {
            let hint = did_you_mean(name, self.objects.keys().map(String::as_str));
            let name = text(name.as_bytes());
            return Err(here.malformed(format!("ObjectInstance: there is no object \"{name}\" before this line{hint}")));
        };
        self.builder.add_instance(object, placement).map_err(|error| here.malformed(error.to_string()))
    }
}

fn too_large(here: Here<'_>) -> LoadError {
    here.malformed(SceneError::TooLarge.to_string())
}
