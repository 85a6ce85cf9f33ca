//! Scene files, procedural scenes, cameras and ray sets. Unpublished: the library's crates know no file.
//!
//! [`load`] reads a file into a [`Scene`]: shapes, objects and instances as plain data, nothing built yet; [`BuiltIn`]
//! makes one without a file. [`CompiledScene`] has the trees over it and answers rays, which [`Camera`] and [`RaySets`]
//! make.
//!
//! Invariants of this crate: it opens only the path it was given and the files that this one names; it prints nothing
//! and reads no clock. What a file says and this project does not model becomes a warning in the scene, once for each
//! kind; what makes no sense is an error that names the file, the place and the reason.

mod camera;
mod compile;
mod gltf;
mod load;
mod obj;
mod pbrt;
mod ply;
mod procedural;
mod rays;
mod scene;
mod spelling;
mod stl;

pub use camera::{Camera, CameraError, CameraSettings, CameraView};
pub use compile::{CompiledScene, MeshTree, ObjectAggregate, PrimitiveName, ScenePrimitive};
pub use load::{LoadError, Place, load};
pub use procedural::{BuiltIn, BuiltInError, MAX_TRIANGLES, meshes};
pub use rays::{RayFileError, RaySets, SceneRay, read_rays, write_rays};
pub use scene::{Geometry, Instance, Names, Object, ObjectId, Scene, SceneBuilder, SceneError, SceneShape};
pub use spelling::did_you_mean;
