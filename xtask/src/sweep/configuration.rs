//! What is compared: trees, and ways to traverse the same trees.

use std::sync::Arc;

use anyhow::Result;
use bvh_flat::geometry::{MollerTrumboreTriangles, Naive, Shape, UnpaddedBoxes};
use bvh_flat::primitive::Primitive;
use bvh_flat::{BuildConfig, BuildError, BuildObserver, MeshBvh, SimdWidth, WideMesh};
use clap::ValueEnum;
use scene::{CompiledScene, MeshTree, Scene};

/// The layout of the trees over meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// Eight children a node, tested at once, and exact decisions: the library's default
    Wide,
    /// Two children a node, tested one by one
    Binary,
}

impl Layout {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide => "wide",
            Self::Binary => "binary",
        }
    }
}

/// The instruction sets that traverse wide trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WidthName {
    /// AVX-512 (F, VL, DQ, BW)
    Avx512,
    /// AVX2 with FMA
    Avx2,
    /// What any processor has
    Portable,
}

impl WidthName {
    /// `None` where the processor does not have it.
    pub fn width(self) -> Option<SimdWidth> {
        match self {
            Self::Avx512 => SimdWidth::avx512(),
            Self::Avx2 => SimdWidth::avx2(),
            Self::Portable => Some(SimdWidth::PORTABLE),
        }
    }
}

/// Box test and triangle test of binary trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KernelName {
    /// Padded boxes, exact triangles
    Exact,
    /// Padded boxes, watertight triangles
    Watertight,
    /// Unpadded boxes before watertight triangles
    UnpaddedBoxes,
    /// Padded boxes before the triangle test of Möller and Trumbore
    MollerTrumbore,
    /// Unpadded boxes, Möller and Trumbore: what most ray tracers have
    Naive,
}

/// A way to traverse trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    Wide(SimdWidth),
    Binary(KernelName),
}

/// What a way to traverse trees promises about every answer: all that promise the same give the same answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Promise {
    /// The decisions of real arithmetic.
    Exact,
    /// No ray leaks, and the answer does not depend on the tree.
    Watertight,
}

impl Traversal {
    pub fn layout(self) -> Layout {
        match self {
            Self::Wide(_) => Layout::Wide,
            Self::Binary(_) => Layout::Binary,
        }
    }

    /// The name of the SIMD width of traversals of trees over meshes.
    pub fn width(self) -> &'static str {
        match self {
            Self::Wide(width) => width.name(),
            Self::Binary(_) => "scalar",
        }
    }

    /// The names in tables: of the box test and of the triangle test.
    pub fn tests(self) -> [&'static str; 2] {
        match self {
            Self::Wide(_) => ["padded", "exact"],
            Self::Binary(KernelName::Exact) => ["padded", "exact"],
            Self::Binary(KernelName::Watertight) => ["padded", "watertight"],
            Self::Binary(KernelName::UnpaddedBoxes) => ["unpadded", "watertight"],
            Self::Binary(KernelName::MollerTrumbore) => ["padded", "moller-trumbore"],
            Self::Binary(KernelName::Naive) => ["unpadded", "moller-trumbore"],
        }
    }

    /// `None` of kernels that are there to show what they lose.
    pub fn promise(self) -> Option<Promise> {
        match self {
            Self::Wide(_) | Self::Binary(KernelName::Exact) => Some(Promise::Exact),
            Self::Binary(KernelName::Watertight) => Some(Promise::Watertight),
            Self::Binary(_) => None,
        }
    }
}

/// A scene with its trees, of either layout.
pub enum Trees {
    Wide(CompiledScene),
    Binary(CompiledScene<MeshBvh>),
}

impl Trees {
    pub fn build(
        scene: &Arc<Scene>,
        layout: Layout,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        let scene = Arc::clone(scene);
        Ok(match layout {
            Layout::Wide => Self::Wide(CompiledScene::build(scene, config, observer)?),
            Layout::Binary => Self::Binary(CompiledScene::build_with(scene, config, observer)?),
        })
    }

    /// How long cache files with the trees over meshes are together, in bytes.
    pub fn file_length(&self) -> u64 {
        match self {
            Self::Wide(compiled) => compiled.meshes().iter().map(MeshTree::file_length).sum(),
            Self::Binary(compiled) => compiled.meshes().iter().map(MeshTree::file_length).sum(),
        }
    }

    /// What is kept beside the scene itself, in bytes.
    pub fn memory(&self) -> usize {
        match self {
            Self::Wide(compiled) => compiled.memory(),
            Self::Binary(compiled) => compiled.memory(),
        }
    }
}

/// A scene with its trees and one way to traverse them, ready to be asked.
pub struct Subject {
    pub world: Arc<dyn Primitive + Send + Sync>,
    /// Each mesh by itself, in its own space.
    pub meshes: Vec<Box<dyn Shape + Send + Sync>>,
}

impl Subject {
    /// The library's default: wide trees at the widest.
    pub fn new(compiled: &CompiledScene) -> Result<Self> {
        Self::with_meshes(compiled, SimdWidth::widest(), WideMesh::clone)
    }

    /// The ways to traverse `trees` among `widths` and `kernels`, each with its subject.
    pub fn all(trees: &Trees, widths: &[SimdWidth], kernels: &[KernelName]) -> Result<Vec<(Traversal, Self)>> {
        match trees {
            Trees::Wide(compiled) => widths
                .iter()
                .map(|&width| {
                    let subject = Self::with_meshes(compiled, width, |mesh| mesh.with_simd_width(width))?;
                    Ok((Traversal::Wide(width), subject))
                })
                .collect(),
            Trees::Binary(compiled) => kernels
                .iter()
                .map(|&kernels| Ok((Traversal::Binary(kernels), Self::of_kernels(compiled, kernels)?)))
                .collect(),
        }
    }

    /// The trees over objects are wide, and the boxes of objects padded, whatever the kernels in meshes.
    fn of_kernels(compiled: &CompiledScene<MeshBvh>, kernels: KernelName) -> Result<Self> {
        let width = SimdWidth::widest();
        match kernels {
            KernelName::Exact => Self::with_meshes(compiled, width, MeshBvh::exact),
            KernelName::Watertight => Self::with_meshes(compiled, width, MeshBvh::clone),
            KernelName::UnpaddedBoxes => Self::with_meshes(compiled, width, MeshBvh::with_kernels::<UnpaddedBoxes>),
            KernelName::MollerTrumbore => {
                Self::with_meshes(compiled, width, MeshBvh::with_kernels::<MollerTrumboreTriangles>)
            }
            KernelName::Naive => Self::with_meshes(compiled, width, MeshBvh::with_kernels::<Naive>),
        }
    }

    fn with_meshes<M: MeshTree, N: MeshTree + Send + Sync + 'static>(
        compiled: &CompiledScene<M>,
        width: SimdWidth,
        shape: impl Fn(&M) -> N,
    ) -> Result<Self> {
        let compiled = compiled.with_meshes(width, shape)?;
        let boxed = |mesh: &N| Box::new(mesh.clone()) as Box<dyn Shape + Send + Sync>;
        let meshes = compiled.meshes().iter().map(boxed).collect();
        Ok(Self { world: compiled.shared_world(), meshes })
    }
}
