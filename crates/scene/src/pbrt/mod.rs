//! Loading pbrt: the part of pbrt's scene format (v3 and v4) that says what stands where.
//!
//! Read: transforms (still and moving), attributes, objects and their instances, trianglemesh, plymesh, loopsubdiv (its
//! control cage) and sphere, materials, area lights and media as names, the perspective camera, Include and Import.
//! Every other directive is skipped with its parameters and one warning for each name, which says where it stands and
//! what may have been meant if it is none of the format's; what does not even have the form of pbrt is an error.
//!
//! Sources: Pharr, Jakob and Humphreys, *Physically Based Rendering*, appendix C (4th edition; B in the 3rd), and the
//! format's references, pbrt.org/fileformat-v3 and pbrt.org/fileformat-v4. As there, Transform lists its matrix by
//! columns, a mesh is carried by the transform at its Shape into the world around, and the instance of an object by the
//! transform at its ObjectInstance.
//!
//! ```text
//! tokens       bytes → words, strings, brackets, with their lines
//! parameters   "type name" [values]
//! state        the graphics state: transforms, material, light, media
//! interpreter  what each directive does
//! files        Include and Import
//! blocks       Begin and End, and the transforms in between
//! world        shapes, objects, and the tables of names
//! shapes       Shape
//! camera       Camera
//! ```

mod blocks;
mod camera;
mod files;
mod interpreter;
mod parameters;
mod shapes;
mod state;
#[cfg(test)]
mod tests;
mod tokens;
mod world;

use std::path::Path;

use crate::{LoadError, Scene};

/// Reads a pbrt scene, and the files that it names.
pub(crate) fn load(path: &Path) -> Result<Scene, LoadError> {
    interpreter::Interpreter::new(path).scene()
}
