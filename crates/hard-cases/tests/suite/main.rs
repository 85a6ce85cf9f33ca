//! The tests of the catalogue, in one program.

mod catalogue;
mod findings;
mod meshes;
mod mutations;
