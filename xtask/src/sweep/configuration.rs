//! What is compared: trees, and ways to traverse the same trees. Names only; `subject` has what they stand for.

use bvh_flat::SimdWidth;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::input::SplitMethodName;

/// The layout of the trees over meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Eight children a node, tested at once, and exact decisions: the library's default
    Wide,
    /// The same in a third of the memory: quantised boxes, and the mesh's own vertices
    Compact,
    /// Two children a node, tested one by one
    Binary,
}

impl Layout {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide => "wide",
            Self::Compact => "compact",
            Self::Binary => "binary",
        }
    }
}

/// The instruction sets that traverse wide trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WidthName {
    /// AVX-512 (F, VL, DQ, BW)
    Avx512,
    /// AVX2 with FMA
    Avx2,
    /// What any processor has
    Portable,
}

impl WidthName {
    /// All, the widest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        }
    }

    /// `None` where the processor does not have it.
    pub fn width(self) -> Option<SimdWidth> {
        match self {
            Self::Avx512 => SimdWidth::avx512(),
            Self::Avx2 => SimdWidth::avx2(),
            Self::Portable => Some(SimdWidth::PORTABLE),
        }
    }
}

/// How rays are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Calls {
    /// A call for each ray
    Single,
    /// One call for all of a set: only where the scene is a single mesh
    Batch,
    /// A call for each ray, on all threads
    Parallel,
}

impl Calls {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Batch => "batch",
            Self::Parallel => "parallel",
        }
    }
}

/// Box test and triangle test of binary trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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

impl KernelName {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Watertight => "watertight",
            Self::UnpaddedBoxes => "unpadded-boxes",
            Self::MollerTrumbore => "moller-trumbore",
            Self::Naive => "naive",
        }
    }
}

/// How the trees of a scene are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TreeName {
    pub split_method: SplitMethodName,
    pub layout: Layout,
    /// Of binary trees, where it is not the split method's own.
    pub max_primitives_in_leaf: Option<u32>,
    /// That build, and trace where calls are parallel; all that there are where none is said.
    pub threads: Option<u32>,
}

impl TreeName {
    /// The split method, with what else is said.
    pub fn describe(&self) -> String {
        let mut text = self.split_method.name().to_owned();
        if let Some(leaf) = self.max_primitives_in_leaf {
            text += &format!(", leaves of {leaf}");
        }
        if let Some(threads) = self.threads {
            text += &format!(", {threads} thread{}", if threads == 1 { "" } else { "s" });
        }
        text
    }
}

/// A way to traverse trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Traversal {
    /// Of wide and compact trees.
    Wide {
        simd_width: WidthName,
        calls: Calls,
    },
    Binary {
        kernels: KernelName,
    },
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
    /// The name of the SIMD width of traversals of trees over meshes.
    pub fn width(self) -> &'static str {
        match self {
            Self::Wide { simd_width, .. } => simd_width.name(),
            Self::Binary { .. } => "scalar",
        }
    }

    /// How rays are asked: those of binary trees one by one.
    pub fn calls(self) -> Calls {
        match self {
            Self::Wide { calls, .. } => calls,
            Self::Binary { .. } => Calls::Single,
        }
    }

    /// The names in tables: of the box test and of the triangle test.
    pub fn tests(self) -> [&'static str; 2] {
        match self {
            Self::Wide { .. } => ["padded", "exact"],
            Self::Binary { kernels } => match kernels {
                KernelName::Exact => ["padded", "exact"],
                KernelName::Watertight => ["padded", "watertight"],
                KernelName::UnpaddedBoxes => ["unpadded", "watertight"],
                KernelName::MollerTrumbore => ["padded", "moller-trumbore"],
                KernelName::Naive => ["unpadded", "moller-trumbore"],
            },
        }
    }

    /// `None` of kernels that are there to show what they lose.
    pub fn promise(self) -> Option<Promise> {
        match self {
            Self::Wide { .. } | Self::Binary { kernels: KernelName::Exact } => Some(Promise::Exact),
            Self::Binary { kernels: KernelName::Watertight } => Some(Promise::Watertight),
            Self::Binary { .. } => None,
        }
    }
}
