//! How good the trees over a scene's meshes are, as they are traversed: from trees to numbers, and to words.

use bvh_flat::{MeshBvh, TreeQuality, WideMesh};

use super::results::QualityFigures;
use super::rows::Row;
use super::subject::Trees;

/// How good a tree over a mesh is.
struct MeshQuality {
    triangles: usize,
    tree: TreeQuality,
    effective_primitive_overlap: f64,
}

impl MeshQuality {
    fn of_wide(mesh: &WideMesh) -> Self {
        let effective_primitive_overlap = mesh.effective_primitive_overlap();
        Self { triangles: mesh.mesh().len(), tree: mesh.quality(), effective_primitive_overlap }
    }

    fn of_binary(mesh: &MeshBvh) -> Self {
        let overlap = mesh.bvh().effective_primitive_overlap(mesh.mesh());
        Self {
            triangles: mesh.mesh().len(),
            tree: mesh.bvh().quality(),
            effective_primitive_overlap: overlap.unwrap_or_default(),
        }
    }
}

/// Of all meshes: means weighted by their triangles, and sums of leaves. `None` where there is no mesh.
pub fn quality(trees: &Trees) -> Option<QualityFigures> {
    let meshes: Vec<MeshQuality> = match trees {
        Trees::Wide(compiled) => compiled.meshes().iter().map(MeshQuality::of_wide).collect(),
        Trees::Binary(compiled) => compiled.meshes().iter().map(MeshQuality::of_binary).collect(),
    };
    let triangles: usize = meshes.iter().map(|mesh| mesh.triangles).sum();
    let mean = |f: fn(&MeshQuality) -> f64| {
        meshes.iter().map(|mesh| f(mesh) * mesh.triangles as f64).sum::<f64>() / triangles as f64
    };
    let mut leaves = [0; QualityFigures::SIZES];
    for (size, count) in meshes.iter().flat_map(|mesh| mesh.tree.leaf_histogram.iter().enumerate().skip(1)) {
        leaves[(size - 1).min(QualityFigures::SIZES - 1)] += u64::from(*count);
    }
    (triangles > 0).then(|| QualityFigures {
        expected_cost: mean(|mesh| mesh.tree.sah_cost),
        overlap: mean(|mesh| mesh.tree.overlap),
        effective_primitive_overlap: mean(|mesh| mesh.effective_primitive_overlap),
        leaves,
    })
}

/// What [`figures`] are.
pub const FIGURES: [&str; 6] =
    ["expected cost", "overlap", "EPO", "nodes/ray", "tests/ray", "leaves of 1, 2, … 8 and more"];

/// The quality of a row's trees, with what its rays find of it, as tables show it.
pub fn figures(row: &Row) -> Option<[String; 6]> {
    let quality = row.answers.trees.quality.as_ref()?;
    let [nodes, tests] = row.work();
    let last = quality.leaves.iter().rposition(|&count| count > 0).map_or(0, |i| i + 1);
    let leaves: Vec<String> = quality.leaves[..last].iter().map(u64::to_string).collect();
    Some([
        format!("{:.2}", quality.expected_cost),
        format!("{:.2}", quality.overlap),
        format!("{:.3}", quality.effective_primitive_overlap),
        format!("{nodes:.1}"),
        format!("{tests:.1}"),
        leaves.join(" "),
    ])
}
