//! What is compared: trees, and kernels on the same trees.

use std::sync::Arc;

use anyhow::Result;
use bvh_flat::MeshBvh;
use bvh_flat::geometry::{MollerTrumboreTriangles, Naive, Shape, UnpaddedBoxes};
use bvh_flat::primitive::Primitive;
use clap::ValueEnum;
use scene::CompiledScene;

/// Box test and triangle test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KernelName {
    /// Padded boxes, watertight triangles: the library's default
    Watertight,
    /// Unpadded boxes before watertight triangles
    UnpaddedBoxes,
    /// Padded boxes before the triangle test of Möller and Trumbore
    MollerTrumbore,
    /// Unpadded boxes, Möller and Trumbore: what most ray tracers have
    Naive,
}

impl KernelName {
    /// The names in tables: of the box test and of the triangle test.
    pub fn tests(self) -> [&'static str; 2] {
        match self {
            Self::Watertight => ["padded", "watertight"],
            Self::UnpaddedBoxes => ["unpadded", "watertight"],
            Self::MollerTrumbore => ["padded", "moller-trumbore"],
            Self::Naive => ["unpadded", "moller-trumbore"],
        }
    }

    /// Whether it promises that no ray leaks and that the answer does not depend on the tree.
    pub fn is_sound(self) -> bool {
        self == Self::Watertight
    }
}

/// A scene with its trees and one choice of kernels, ready to be asked.
pub struct Subject {
    pub world: Arc<dyn Primitive + Send + Sync>,
    /// Each mesh by itself, in its own space.
    pub meshes: Vec<Box<dyn Shape + Send + Sync>>,
}

impl Subject {
    /// `compiled`, traversed with `kernels`.
    pub fn new(compiled: &CompiledScene, kernels: KernelName) -> Result<Self> {
        match kernels {
            KernelName::Watertight => Self::with_meshes(compiled, MeshBvh::clone),
            KernelName::UnpaddedBoxes => Self::with_meshes(compiled, MeshBvh::with_kernels::<UnpaddedBoxes>),
            KernelName::MollerTrumbore => Self::with_meshes(compiled, MeshBvh::with_kernels::<MollerTrumboreTriangles>),
            KernelName::Naive => Self::with_meshes(compiled, MeshBvh::with_kernels::<Naive>),
        }
    }

    fn with_meshes<M: Shape + Clone + Send + Sync + 'static>(
        compiled: &CompiledScene,
        shape: impl Fn(&MeshBvh) -> M,
    ) -> Result<Self> {
        let boxed = |mesh| Box::new(shape(mesh)) as Box<dyn Shape + Send + Sync>;
        let meshes = compiled.meshes().iter().map(boxed).collect();
        Ok(Self { world: compiled.with_meshes(&shape)?.shared_world(), meshes })
    }
}
