//! How good a tree is, in numbers.

use std::ops::Range;

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, TriangleMesh};

use crate::parallel::join;
use crate::{FlatBvh, LinearBvhNode};

/// What a node costs a ray that meets it, where testing a primitive costs 1: pbrt's t_trav, as in the default configuration.
const NODE_COST: f64 = 0.5;

/// How good a tree is.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TreeQuality {
    /// The expected cost of a random ray through the root's box: the sum of p · 1/2 over the interior nodes and of p · n over the
    /// leaves of n primitives, where p is a node's surface area as a part of the root's. 0 where the root has no area.
    pub sah_cost: f64,
    /// By how much children overlap: the surface areas of what both children of a node have in common, over all interior
    /// nodes, as a part of the root's. 0 where the root has no area.
    pub overlap: f64,
    /// How many leaves have 0, 1, 2, … primitives, up to the largest.
    pub leaf_histogram: Vec<u32>,
}

impl FlatBvh {
    /// How good the tree is, as far as its boxes tell. Linear in the number of nodes.
    pub fn quality(&self) -> TreeQuality {
        let mut quality = TreeQuality::default();
        for (i, node) in self.nodes().iter().enumerate() {
            if node.is_leaf() {
                let count = node.range().len();
                if quality.leaf_histogram.len() <= count {
                    quality.leaf_histogram.resize(count + 1, 0);
                }
                quality.leaf_histogram[count] += 1;
            } else {
                let [a, b] = [i + 1, node.second_child()].map(|child| self.nodes()[child].bounds());
                quality.overlap += Bounds3::new(a.min.max(b.min), a.max.min(b.max)).surface_area();
            }
            quality.sah_cost += cost(node) * node.bounds().surface_area();
        }
        let area = self.bounds().surface_area();
        let part = |sum: f64| if area > 0.0 { sum / area } else { 0.0 };
        TreeQuality { sah_cost: part(quality.sah_cost), overlap: part(quality.overlap), ..quality }
    }

    /// The effective primitive overlap of the tree over a mesh: the surface of the triangles that lies in the box of a node
    /// without belonging to it, times what the node costs, over all nodes, as a part of all surface. Of two trees of equal
    /// [`sah_cost`](TreeQuality::sah_cost), rays from one surface to the next are the faster in that of less (Aila, Karras
    /// and Laine, *On Quality Metrics of Bounding Volume Hierarchies*, High Performance Graphics 2013, equation 4). 0 where
    /// there is no surface.
    ///
    /// Each triangle is cut by every box that it meets, in f64: this takes longer than the build. On all threads of the current
    /// rayon pool with the feature `parallel`, and with the same result on any number.
    ///
    /// `None` where the mesh has another number of triangles than the tree has primitives.
    pub fn effective_primitive_overlap(&self, mesh: &TriangleMesh) -> Option<f64> {
        if mesh.len() != self.primitive_count() as usize {
            return None;
        }
        let mut references: Vec<(u32, u32)> = (0..).zip(self.order()).map(|(place, &i)| (i, place)).collect();
        references.sort_unstable();
        let ranges = ranges(self.nodes());
        let overlap = Overlap { nodes: self.nodes(), ranges: &ranges, mesh };
        let triangles: Vec<&[(u32, u32)]> = references.chunk_by(|a, b| a.0 == b.0).collect();
        let [overlapping, all] = overlap.sum(&triangles);
        Some(if all > 0.0 { overlapping / all } else { 0.0 })
    }
}

/// What a node costs a ray that meets it.
fn cost(node: &LinearBvhNode) -> f64 {
    if node.is_leaf() { node.range().len() as f64 } else { NODE_COST }
}

/// The places in the order of all that is below each node.
fn ranges(nodes: &[LinearBvhNode]) -> Vec<Range<u32>> {
    let mut ranges = vec![0..0; nodes.len()];
    // Children lie behind their parents, so from the back every child is ready before its parent.
    for (i, node) in nodes.iter().enumerate().rev() {
        ranges[i] = if node.is_leaf() {
            node.range().start as u32..node.range().end as u32
        } else {
            ranges[i + 1].start..ranges[node.second_child()].end
        };
    }
    ranges
}

struct Overlap<'a> {
    nodes: &'a [LinearBvhNode],
    ranges: &'a [Range<u32>],
    mesh: &'a TriangleMesh,
}

impl Overlap<'_> {
    /// The overlap of triangles, each with its places in the order, and their area.
    fn sum(&self, triangles: &[&[(u32, u32)]]) -> [f64; 2] {
        const SEQUENTIAL: usize = 256;
        if triangles.len() <= SEQUENTIAL {
            return triangles.iter().fold([0.0; 2], |sum, references| {
                let vertices = self.mesh.vertices(references[0].0 as usize);
                [sum[0] + self.of(&vertices, references), sum[1] + area(&vertices.map(Vec3::as_dvec3))]
            });
        }
        let (a, b) = triangles.split_at(triangles.len() / 2);
        let (a, b) = join(|| self.sum(a), || self.sum(b));
        [a[0] + b[0], a[1] + b[1]]
    }

    /// The overlap of one triangle.
    fn of(&self, vertices: &[Vec3; 3], references: &[(u32, u32)]) -> f64 {
        let mut sum = 0.0;
        let mut pending = vec![0];
        while let Some(i) = pending.pop() {
            let node = &self.nodes[i];
            let inside = area_within(vertices, &node.bounds());
            if inside == 0.0 {
                continue;
            }
            if !references.iter().any(|(_, place)| self.ranges[i].contains(place)) {
                sum += cost(node) * inside;
            }
            if !node.is_leaf() {
                pending.extend([node.second_child(), i + 1]);
            }
        }
        sum
    }
}

/// The area of the part of a triangle that is within bounds: Sutherland and Hodgman's clipping, in f64.
fn area_within(vertices: &[Vec3; 3], bounds: &Bounds3) -> f64 {
    let mut polygon: Vec<DVec3> = vertices.map(Vec3::as_dvec3).into();
    for axis in 0..3 {
        for (plane, sign) in [(f64::from(bounds.min[axis]), 1.0), (f64::from(bounds.max[axis]), -1.0)] {
            let inside = |p: DVec3| sign * (p[axis] - plane);
            let mut clipped = Vec::with_capacity(polygon.len() + 1);
            for (i, &p) in polygon.iter().enumerate() {
                let before = polygon[(i + polygon.len() - 1) % polygon.len()];
                let (d, d_before) = (inside(p), inside(before));
                if (d < 0.0) != (d_before < 0.0) {
                    clipped.push(before + (p - before) * (d_before / (d_before - d)));
                }
                if d >= 0.0 {
                    clipped.push(p);
                }
            }
            polygon = clipped;
        }
    }
    area(&polygon)
}

/// The area of a plane polygon; 0 of fewer than three points.
fn area(polygon: &[DVec3]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    let edges = polygon.windows(2).map(|edge| (edge[0] - first).cross(edge[1] - first));
    0.5 * edges.sum::<DVec3>().length()
}

#[cfg(all(test, feature = "build"))]
mod tests {
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
    fn the_part_of_a_triangle_in_a_box_has_the_area_it_has() {
        let triangle = [Vec3::ZERO, 2.0 * Vec3::X, 2.0 * Vec3::Y];
        let within = |min: [f32; 3], max: [f32; 3]| area_within(&triangle, &Bounds3::new(min, max));
        assert_eq!(within([0.0; 3], [2.0; 3]), 2.0);
        assert_eq!(within([0.0; 3], [1.0; 3]), 1.0);
        assert_eq!(within([0.5, 0.5, -1.0], [9.0; 3]), 0.5);
        assert_eq!(within([0.0, 0.0, 0.1], [2.0; 3]), 0.0);
        assert_eq!(within([1.5, 1.5, -1.0], [2.0, 2.0, 1.0]), 0.0);
    }

    #[test]
    fn the_numbers_of_a_known_tree() {
        let config = BuildConfig::new(SplitMethod::EqualCounts).with_max_primitives_in_leaf(1);
        let apart = row(4, 1.0);
        let bvh = tree(&apart, &config);
        let quality = bvh.quality();
        assert_eq!(quality.leaf_histogram, [0, 4]);
        assert_eq!(quality.overlap, 0.0);
        // Flat boxes of height 1, and widths 7 of the root, 3 of two nodes, 1 of four leaves; nearly, since they are padded.
        let expected = 0.5 * (7.0 + 2.0 * 3.0) / 7.0 + 4.0 / 7.0;
        assert!((quality.sah_cost - expected).abs() < 1e-3, "{quality:?}");
        assert_eq!(bvh.effective_primitive_overlap(&apart), Some(0.0));
        assert_eq!(bvh.effective_primitive_overlap(&row(3, 1.0)), None);

        // With legs of 3, each of two neighbours reaches one further than where the other begins.
        let wide = row(2, 3.0);
        let bvh = tree(&wide, &config);
        let overlap = bvh.effective_primitive_overlap(&wide).expect("as many");
        // Of the first triangle, the tip right of x = 2, of area 1/2, is in the other's leaf; of the second the part up to
        // x = 3, (3 + 2) / 2, in the first one's; of 2 · 9/2 in all.
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
        assert_eq!(good.0.leaf_histogram.iter().enumerate().map(|(n, &c)| n as u32 * c).sum::<u32>(), 600);
    }
}
