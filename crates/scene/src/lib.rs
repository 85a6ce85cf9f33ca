//! Scene files, procedural scenes, cameras and ray sets. Unpublished: the library's crates know no file.
//!
//! [`load`] reads a file into a [`Scene`]: shapes, objects and instances as plain data, nothing built yet.
//!
//! Invariants of this crate: it opens only the path it was given and the files that this one names; it prints nothing
//! and reads no clock. What a file says and this project does not model becomes a warning in the scene, once for each
//! kind; what makes no sense is an error that names the file, the place and the reason.

mod camera;
mod gltf;
mod load;
mod obj;
mod pbrt;
mod ply;
mod procedural;
mod rays;
mod scene;
mod stl;

pub use camera::Camera;
pub use load::{LoadError, Place, load};
pub use procedural::{BuiltIn, BuiltInError};
pub use rays::{RaySegment, RaySets};
pub use scene::{Geometry, Instance, Names, Object, ObjectId, Scene, SceneBuilder, SceneError, SceneShape};
