//! The Shape directive.

use std::path::PathBuf;
use std::sync::Arc;

use geometry::glam::{DVec3, Vec2, Vec3};
use geometry::{Sphere, Transform, TriangleMesh};
use primitive::Placement;

use super::parameters::Parameters;
use super::state::uniform_scale;
use crate::{LoadError, SceneShape, ply};

/// A shape in its own space.
#[derive(Debug)]
pub(super) enum ObjectShape {
    /// A mesh whose points are as exact as in the file.
    Points { points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>, uvs: Option<Vec<Vec2>> },
    /// A mesh of a file of its own.
    Mesh(Arc<TriangleMesh>),
    /// A sphere around the origin.
    Sphere { radius: f64 },
}

/// A shape that was read, with what there is to say about it.
pub(super) type Read = (ObjectShape, Vec<String>);

/// Reads `Shape "kind"`; `None` where the kind is not known. `resolve` finds the files it names.
pub(super) fn read(
    kind: &str,
    parameters: &mut Parameters<'_>,
    resolve: impl FnOnce(&str) -> Result<PathBuf, LoadError>,
) -> Result<Option<Read>, LoadError> {
    match kind {
        "trianglemesh" => points(parameters, Vec::new()).map(Some),
        "loopsubdiv" => {
            for levels in ["levels", "nlevels"] {
                parameters.numbers(levels, &["integer"])?;
            }
            let warning = "Shape \"loopsubdiv\": the control cage stands for the surface, which is not subdivided";
            points(parameters, vec![warning.to_owned()]).map(Some)
        }
        "plymesh" => ply_mesh(parameters, resolve).map(Some),
        "sphere" => sphere(parameters).map(Some),
        _ => Ok(None),
    }
}

fn points(parameters: &mut Parameters<'_>, mut warnings: Vec<String>) -> Result<Read, LoadError> {
    let points = parameters.points("P")?;
    let points = parameters.require("P", points)?;
    let triangles = match parameters.triangles("indices")? {
        // pbrt-v4: the indices of a single triangle need not be written.
        None if points.len() == 3 => vec![[0, 1, 2]],
        triangles => parameters.require("indices", triangles)?,
    };
    let mut uvs = None;
    for name in ["uv", "st"] {
        let Some(numbers) = parameters.numbers(name, &["point2", "float"])? else { continue };
        if numbers.len() == 2 * points.len() {
            uvs = Some(numbers.chunks_exact(2).map(|uv| Vec2::new(uv[0] as f32, uv[1] as f32)).collect());
        } else {
            warnings.push(format!("a mesh's {name} are ignored, since there is not one for each of its vertices"));
        }
    }
    Ok((ObjectShape::Points { points, triangles, uvs }, warnings))
}

fn ply_mesh(
    parameters: &mut Parameters<'_>,
    resolve: impl FnOnce(&str) -> Result<PathBuf, LoadError>,
) -> Result<Read, LoadError> {
    let filename = parameters.string("filename")?;
    let filename = parameters.require("filename", filename)?;
    let scene = ply::load(&resolve(&filename)?)?;
    match scene.geometries().first().map(|geometry| &geometry.shape) {
        Some(SceneShape::Mesh(mesh)) => {
            let warnings = scene.warnings.iter().map(|warning| format!("{filename}: {warning}")).collect();
            Ok((ObjectShape::Mesh(Arc::clone(mesh)), warnings))
        }
        _ => Err(parameters.malformed(format!("there is no mesh in \"{filename}\""))),
    }
}

fn sphere(parameters: &mut Parameters<'_>) -> Result<Read, LoadError> {
    let radius = parameters.float("radius")?.unwrap_or(1.0);
    let mut limit = |name, whole: f64| Ok(parameters.float(name)?.unwrap_or(whole));
    let (zmin, zmax, phimax) = (limit("zmin", -radius)?, limit("zmax", radius)?, limit("phimax", 360.0)?);
    let mut warnings = Vec::new();
    if zmin > -radius || zmax < radius || phimax < 360.0 {
        warnings.push("a part of a sphere is not known as a shape: the whole sphere stands for it".to_owned());
    }
    Ok((ObjectShape::Sphere { radius }, warnings))
}

impl ObjectShape {
    /// The transform that it can be carried through once and for all, where it stands at `placement`; `None` where it
    /// needs to be instanced there. Every mesh that stands still can.
    ///
    /// A sphere can where its image is one up to 2⁻²⁵ of the radius, half of that one's own rounding to f32. (Its
    /// texture coordinates do not turn with it.)
    pub(super) fn carries(&self, placement: &Placement) -> Option<Transform> {
        match (self, placement) {
            (_, Placement::Animated(_)) => None,
            (Self::Sphere { .. }, Placement::Static(transform)) => {
                uniform_scale(transform, 2.0_f64.powi(-24)).map(|_| *transform)
            }
            (_, Placement::Static(transform)) => Some(*transform),
        }
    }

    /// The shape in the space that `transform` carries it to, which must be one that it [`carries`](Self::carries):
    /// computed in f64 and rounded once.
    ///
    /// A mesh's outside is where its triangles are seen counter-clockwise, and a mirroring turns that around; so the
    /// triangles are wound the other way where `transform` mirrors or the outside is `reversed`, but not both.
    ///
    /// # Errors
    /// In words.
    pub(super) fn carried(self, transform: &Transform, reversed: bool) -> Result<SceneShape, String> {
        let rewind = reversed != transform.swaps_handedness();
        let mesh = match self {
            Self::Sphere { radius } => {
                let scale = uniform_scale(transform, f64::INFINITY).unwrap_or(1.0);
                let center = transform.point(DVec3::ZERO).as_vec3();
                let sphere = Sphere::new(center, (radius * scale) as f32).map_err(|error| error.to_string())?;
                return Ok(SceneShape::Sphere(sphere));
            }
            Self::Mesh(mesh) if !rewind && *transform == Transform::IDENTITY => return Ok(SceneShape::Mesh(mesh)),
            Self::Mesh(mesh) => {
                let points = mesh.positions().iter().map(|p| p.as_dvec3());
                carried_mesh(points, mesh.triangles().to_vec(), mesh.uvs().map(<[Vec2]>::to_vec), transform, rewind)
            }
            Self::Points { points, triangles, uvs } => {
                carried_mesh(points.into_iter().map(DVec3::from), triangles, uvs, transform, rewind)
            }
        };
        mesh.map(|mesh| SceneShape::Mesh(Arc::new(mesh)))
    }
}

fn carried_mesh(
    points: impl Iterator<Item = DVec3>,
    mut triangles: Vec<[u32; 3]>,
    uvs: Option<Vec<Vec2>>,
    transform: &Transform,
    rewind: bool,
) -> Result<TriangleMesh, String> {
    let positions: Vec<Vec3> = points.map(|p| transform.point(p).as_vec3()).collect();
    if rewind {
        triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    }
    let mesh = TriangleMesh::new(positions, triangles);
    let mesh = match uvs {
        Some(uvs) => mesh.and_then(|mesh| mesh.with_uvs(uvs)),
        None => mesh,
    };
    mesh.map_err(|error| error.to_string())
}
