//! How good a tree is, in numbers.

mod boxes;

use geometry::TriangleMesh;

use crate::{FlatBvh, WideMesh};

pub(crate) use boxes::Boxes;

/// What a node costs a ray that meets it, where testing a primitive costs 1: pbrt's t_trav, as in the default
/// configuration.
const NODE_COST: f64 = 0.5;

/// How good a tree is: by its boxes alone, so on a mean over random rays; less is better. All is relative to the root's
/// surface area, hence without a unit and always finite.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TreeQuality {
    /// The expected cost of a random ray through the root's box, by the surface area heuristic: the sum over all nodes
    /// of what a node costs times its surface area, as a part of the root's (MacDonald and Booth 1990; pbrt's third
    /// edition, section 4.3.2). 0 where the root has no area.
    pub sah_cost: f64,
    /// By how much children overlap: the surface areas of what any two children of a node have in common, over all
    /// interior nodes, as a part of the root's. 0 where the root has no area.
    pub overlap: f64,
    /// How many leaves have 0, 1, 2, … primitives, up to the largest.
    pub leaf_histogram: Vec<u32>,
}

impl FlatBvh {
    /// How good the tree is, as far as its boxes tell. An interior node costs 1/2 and a leaf the number of its
    /// primitives, as in the default configuration, whatever the tree was built with. Linear in the number of nodes.
    pub fn quality(&self) -> TreeQuality {
        self.boxes().quality()
    }

    /// The effective primitive overlap of the tree over a mesh: the surface of the triangles that lies in the box of a
    /// node without belonging to it, times what the node costs, over all nodes, as a part of all surface. Of two trees
    /// of equal [`sah_cost`](TreeQuality::sah_cost), rays from one surface to the next are the faster in that of less
    /// (Aila, Karras and Laine, *On Quality Metrics of Bounding Volume Hierarchies*, High Performance Graphics 2013,
    /// equation 4). Triangles that are in no leaf do not count. 0 where there is no surface.
    ///
    /// Each triangle is cut by every box that it meets, in f64: this takes longer than the build. On all threads of the
    /// current rayon pool with the feature `parallel`, and with the same result on any number.
    ///
    /// `None` where the mesh has another number of triangles than the tree has primitives.
    pub fn effective_primitive_overlap(&self, mesh: &TriangleMesh) -> Option<f64> {
        let is_built_over_as_many = mesh.len() == self.primitive_count() as usize;
        is_built_over_as_many.then(|| self.boxes().effective_primitive_overlap(mesh))
    }

    fn boxes(&self) -> Boxes {
        let mut boxes = Boxes::default();
        // Interior nodes that are begun, each with how many of its children are still to come.
        let mut open: Vec<(usize, u8)> = Vec::new();
        for node in self.nodes() {
            if !node.is_leaf() {
                open.push((boxes.begin(node.bounds(), NODE_COST), 2));
                continue;
            }
            let primitives = &self.order()[node.range()];
            boxes.leaf(node.bounds(), primitives.len() as f64, primitives.iter().copied());
            while let Some((parent, to_come)) = open.last_mut() {
                *to_come -= 1;
                if *to_come > 0 {
                    break;
                }
                boxes.end(*parent);
                open.pop();
            }
        }
        boxes
    }
}

impl WideMesh {
    /// How good the tree is, as far as its boxes tell. A node costs 1, and a leaf of n triangles 1.5 + 0.1 n, as in the
    /// build: not to be compared with [`FlatBvh::quality`]. Compact nodes count with their quantised boxes. Linear in
    /// the number of nodes.
    pub fn quality(&self) -> TreeQuality {
        self.boxes().quality()
    }

    /// The effective primitive overlap, as [`FlatBvh::effective_primitive_overlap`] has it, at the costs of
    /// [`quality`](Self::quality).
    pub fn effective_primitive_overlap(&self) -> f64 {
        self.boxes().effective_primitive_overlap(self.mesh())
    }
}

#[cfg(all(test, feature = "build"))]
mod tests {
    use geometry::glam::Vec3;

    use super::*;
    use crate::{BuildConfig, SplitMethod};

    fn tree(mesh: &TriangleMesh, config: &BuildConfig) -> FlatBvh {
        let bounds: Vec<_> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
        FlatBvh::build(&bounds, config, &()).expect("valid")
    }

    /// Right triangles along x, two apart, with legs of length `leg`.
    fn row(count: u32, leg: f32) -> TriangleMesh {
        let corners = |i: u32| [[0.0, 0.0], [leg, 0.0], [0.0, leg]].map(|[x, y]| Vec3::new(2.0 * i as f32 + x, y, 0.0));
        let indices = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        TriangleMesh::new((0..count).flat_map(corners), indices).expect("in range")
    }

    #[test]
    fn the_numbers_of_a_known_tree() {
        let config = BuildConfig::new(SplitMethod::EqualCounts).with_max_primitives_in_leaf(1);
        let apart = row(4, 1.0);
        let bvh = tree(&apart, &config);
        let quality = bvh.quality();
        assert_eq!(quality.leaf_histogram, [0, 4]);
        assert_eq!(quality.overlap, 0.0);
        // Flat boxes of height 1, and widths 7 of the root, 3 of two nodes, 1 of four leaves; nearly, since they are
        // padded.
        let expected = 0.5 * (7.0 + 2.0 * 3.0) / 7.0 + 4.0 / 7.0;
        assert!((quality.sah_cost - expected).abs() < 1e-3, "{quality:?}");
        assert_eq!(bvh.effective_primitive_overlap(&apart), Some(0.0));
        assert_eq!(bvh.effective_primitive_overlap(&row(3, 1.0)), None);

        // With legs of 3, each of two neighbours reaches one further than where the other begins.
        let wide = row(2, 3.0);
        let bvh = tree(&wide, &config);
        let overlap = bvh.effective_primitive_overlap(&wide).expect("as many");
        // Of the first triangle, the tip right of x = 2, of area 1/2, is in the other's leaf; of the second the part up
        // to x = 3, (3 + 2) / 2, in the first one's; of 2 · 9/2 in all.
        assert!((overlap - (0.5 + 2.5) / 9.0).abs() < 1e-4, "{overlap}");
        assert!((bvh.quality().overlap - 1.0 / 5.0).abs() < 1e-3, "{:?}", bvh.quality());
    }

    #[test]
    fn better_trees_have_better_numbers() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 16_777_216.0
        };
        let mut vector = || Vec3::new(random(), random(), random());
        let corners = (0..600).flat_map(|_| {
            let p = vector();
            [p, p + 0.1 * vector(), p + 0.1 * vector()]
        });
        let positions: Vec<Vec3> = corners.collect();
        let mesh = TriangleMesh::new(positions, (0..600).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        let mesh = mesh.expect("in range");
        let [good, bad] = [BuildConfig::default(), BuildConfig::new(SplitMethod::EqualCounts)].map(|config| {
            let bvh = tree(&mesh, &config);
            (bvh.quality(), bvh.effective_primitive_overlap(&mesh).expect("as many"))
        });
        assert!(good.0.sah_cost < bad.0.sah_cost && good.1 < bad.1, "{good:?} {bad:?}");
        let [wide, bad_wide] = [BuildConfig::default(), BuildConfig::new(SplitMethod::EqualCounts)].map(|config| {
            let wide = WideMesh::build(mesh.clone(), &config).expect("valid");
            (wide.quality(), wide.effective_primitive_overlap())
        });
        assert!(wide.0.sah_cost < bad_wide.0.sah_cost && wide.1 < bad_wide.1, "{wide:?} {bad_wide:?}");
        assert_eq!(good.0.leaf_histogram.iter().enumerate().map(|(n, &c)| n as u32 * c).sum::<u32>(), 600);
    }

    /// What a wide tree says of itself is what its build has worked for: the cost that is kept with it.
    #[cfg(feature = "cache")]
    #[test]
    fn wide_trees_cost_what_they_are_expected_to() {
        let mesh = std::sync::Arc::new(row(500, 3.0));
        for layout in crate::WideLayout::ALL {
            let config = BuildConfig::default();
            let wide = WideMesh::build_observed(std::sync::Arc::clone(&mesh), &config, layout, &()).expect("valid");
            let (quality, steps) = (wide.quality(), wide.tree().expected_steps);
            // Quantised boxes are larger than those that the build weighed.
            let more = if layout == crate::WideLayout::Compact { 1.1 } else { 1.0 + 1e-9 };
            assert!(
                (steps * (1.0 - 1e-9)..steps * more).contains(&quality.sah_cost),
                "{layout:?}: {quality:?} {steps}"
            );
            let counts = (0..).zip(&quality.leaf_histogram);
            assert_eq!(counts.map(|(n, &count)| n * count).sum::<u32>(), 500);
            assert!(quality.leaf_histogram.len() <= 9 && quality.overlap > 0.0);
            assert!(wide.effective_primitive_overlap() > 0.0);
        }
    }
}
