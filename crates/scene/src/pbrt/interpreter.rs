//! What each directive does.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use geometry::Transform;

use super::blocks::Block;
use super::camera::set_camera;
use super::files::resolve;
use super::parameters::Parameters;
use super::state::{GraphicsState, TransformSet};
use super::tokens::{Here, Token, Tokens, is_directive, text};
use super::world::World;
use crate::{LoadError, Scene};

/// Directives that are carried out.
pub(super) const KNOWN: [&str; 31] = [
    "ActiveTransform",
    "AreaLightSource",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Identity",
    "Import",
    "Include",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "ReverseOrientation",
    "Rotate",
    "Scale",
    "Shape",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
    "WorldEnd",
];

/// Directives that say nothing about where surfaces are; Attribute, which could, is rare.
const SKIPPED: [&str; 14] = [
    "Accelerator",
    "Attribute",
    "ColorSpace",
    "Film",
    "Integrator",
    "LightSource",
    "Option",
    "PixelFilter",
    "Renderer",
    "Sampler",
    "SurfaceIntegrator",
    "Texture",
    "Volume",
    "VolumeIntegrator",
];

/// Carries out the directives of a file and of those that it names.
#[derive(Debug)]
pub(super) struct Interpreter<'p> {
    pub(super) main: &'p Path,
    pub(super) world: World,
    pub(super) state: GraphicsState,
    /// What was begun and is not ended, the innermost last.
    pub(super) blocks: Vec<Block>,
    pub(super) coordinate_systems: HashMap<String, TransformSet>,
    /// Between which times transforms move.
    pub(super) times: [f32; 2],
    /// The files being read, the innermost last.
    pub(super) open_files: Vec<PathBuf>,
    pub(super) include_count: usize,
    has_ended: bool,
}

impl<'p> Interpreter<'p> {
    pub(super) fn new(main: &'p Path) -> Self {
        let (world, material) = World::new();
        Self {
            main,
            world,
            state: GraphicsState::new(material),
            blocks: Vec::new(),
            coordinate_systems: HashMap::new(),
            times: [0.0, 1.0],
            open_files: Vec::new(),
            include_count: 0,
            has_ended: false,
        }
    }

    /// The scene of the main file.
    pub(super) fn scene(mut self) -> Result<Scene, LoadError> {
        let io = |source| LoadError::Io { path: self.main.to_owned(), source };
        self.open_files.push(self.main.canonicalize().map_err(io)?);
        let bytes = std::fs::read(self.main).map_err(io)?;
        self.scene_of(&bytes)
    }

    /// The scene of the main file, given what is in it.
    pub(super) fn scene_of(mut self, bytes: &[u8]) -> Result<Scene, LoadError> {
        self.file(self.main, bytes)?;
        match self.blocks.last() {
            Some(block) => Err(block.never_ended()),
            None => Ok(self.world.finish()),
        }
    }

    /// Carries out the directives of one file.
    pub(super) fn file(&mut self, path: &Path, bytes: &[u8]) -> Result<(), LoadError> {
        let mut tokens = Tokens::new(path, bytes)?;
        while !tokens.is_at_end() {
            if self.has_ended {
                self.world.warn("what follows WorldEnd is not read");
                break;
            }
            let here = tokens.here();
            match tokens.expect("a directive")? {
                Token::Word(word) if is_directive(word) => {
                    let name = String::from_utf8_lossy(word);
                    self.directive(&name, here, &mut tokens)?;
                }
                other => {
                    let other = other.describe();
                    return Err(
                        here.malformed(format!("{other} stands where a directive, such as Shape, should stand"))
                    );
                }
            }
        }
        Ok(())
    }

    fn directive<'a>(&mut self, name: &str, here: Here<'a>, tokens: &mut Tokens<'a>) -> Result<(), LoadError> {
        match name {
            "Identity" => self.transform(here, name, |_| Ok(Transform::IDENTITY)),
            "Translate" => {
                let delta = tokens.expect_numbers::<3>(name)?;
                self.concat(here, name, Transform::translate(delta))
            }
            "Scale" => {
                let factors = tokens.expect_numbers::<3>(name)?;
                self.concat(here, name, Transform::scale(factors))
            }
            "Rotate" => {
                let [degrees, x, y, z] = tokens.expect_numbers(name)?;
                self.concat(here, name, Transform::rotate(degrees, [x, y, z]))
            }
            "LookAt" => {
                let [ex, ey, ez, lx, ly, lz, ux, uy, uz] = tokens.expect_numbers(name)?;
                self.concat(here, name, Transform::look_at([ex, ey, ez], [lx, ly, lz], [ux, uy, uz]))
            }
            "ConcatTransform" => self.concat(here, name, from_columns(tokens.expect_numbers(name)?)),
            "Transform" => {
                let transform = from_columns(tokens.expect_numbers(name)?);
                self.transform(here, name, |_| transform)
            }
            "CoordinateSystem" => {
                let system = tokens.expect_string("the name of a coordinate system")?;
                self.coordinate_systems.insert(system, self.state.transforms.ctm);
                Ok(())
            }
            "CoordSysTransform" => {
                let system = tokens.expect_string("the name of a coordinate system")?;
                self.coord_sys_transform(here, &system)
            }
            "ActiveTransform" => self.active_transform(tokens),
            "TransformTimes" => {
                self.times = tokens.expect_numbers::<2>(name)?.map(|time| time as f32);
                Ok(())
            }
            "ReverseOrientation" => {
                self.state.reverse_orientation ^= true;
                Ok(())
            }
            "AttributeBegin" | "TransformBegin" => self.begin(name, here),
            "AttributeEnd" | "TransformEnd" => self.end(name, here),
            "ObjectBegin" => {
                let object = tokens.expect_string("the name of an object")?;
                self.begin(name, here)?;
                self.world.begin_object(here, &object)
            }
            "ObjectEnd" => {
                self.end(name, here)?;
                self.world.end_object();
                Ok(())
            }
            "WorldBegin" => {
                self.world_begin();
                Ok(())
            }
            "WorldEnd" => {
                self.has_ended = true;
                Ok(())
            }
            "ObjectInstance" => {
                let object = tokens.expect_string("the name of an object")?;
                let placement = self.placement(here)?;
                self.world.add_instance(here, &object, placement)
            }
            "Material" => {
                let (kind, _) = named(name, here, tokens)?;
                self.state.material = self.world.material(&kind, &kind);
                Ok(())
            }
            "MakeNamedMaterial" => {
                let (material, mut parameters) = named(name, here, tokens)?;
                let kind = parameters.string("type")?;
                self.world.make_named_material(material, kind.as_deref());
                Ok(())
            }
            "NamedMaterial" => {
                let material = tokens.expect_string("the name of a material")?;
                self.state.material = self.world.named_material(&material);
                Ok(())
            }
            "AreaLightSource" => {
                let (kind, _) = named(name, here, tokens)?;
                self.state.area_light = self.world.area_light(&kind);
                Ok(())
            }
            "MakeNamedMedium" => {
                let (medium, _) = named(name, here, tokens)?;
                self.world.make_named_medium(medium);
                Ok(())
            }
            "MediumInterface" => {
                let inside = tokens.expect_string("the medium inside")?;
                let second = tokens.peek() == Some(b'"');
                let outside = if second { tokens.expect_string("the medium outside")? } else { inside.clone() };
                self.state.media = self.world.medium_interface(here, inside, outside)?;
                Ok(())
            }
            "Camera" => {
                let (kind, parameters) = named(name, here, tokens)?;
                let ctm = self.state.transforms.ctm;
                self.coordinate_systems.insert("camera".to_owned(), ctm.inverse());
                set_camera(&mut self.world, &kind, parameters, &ctm)
            }
            "Shape" => {
                let (kind, parameters) = named(name, here, tokens)?;
                let placement = self.placement(here)?;
                let main = self.main;
                self.world.add_shape(&kind, parameters, &placement, &self.state, |file| resolve(main, here, file))
            }
            "Include" | "Import" => {
                let file = tokens.expect_string("the name of a file")?;
                self.include(name, here, &file)
            }
            _ if SKIPPED.contains(&name) => {
                self.world.warn(format!("{name} is not modelled: skipped"));
                tokens.skip_arguments()
            }
            _ => {
                self.world.unknown_directive(here, name, KNOWN.into_iter().chain(SKIPPED));
                tokens.skip_arguments()
            }
        }
    }
}

/// The string that follows a directive, and the parameters.
fn named<'a>(name: &str, here: Here<'a>, tokens: &mut Tokens<'a>) -> Result<(String, Parameters<'a>), LoadError> {
    let kind = tokens.expect_string("a name")?;
    let of = format!("{name} \"{}\"", text(kind.as_bytes()));
    Ok((kind, Parameters::read(tokens, of, here)?))
}

/// The transform of a matrix that is listed by columns, as pbrt's are.
fn from_columns(m: [f64; 16]) -> Result<Transform, geometry::TransformError> {
    let row = |i: usize| [m[i], m[4 + i], m[8 + i], m[12 + i]];
    Transform::from_rows([row(0), row(1), row(2), row(3)])
}
