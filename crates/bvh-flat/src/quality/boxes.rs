//! A tree as its quality sees it.

use std::ops::Range;

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, TriangleMesh};

use super::TreeQuality;
use crate::parallel::join;

/// The boxes of a tree with any number of children a node, depth first.
#[derive(Default)]
pub(crate) struct Boxes {
    nodes: Vec<Node>,
    /// The primitives in the leaves, from the first leaf to the last.
    order: Vec<u32>,
}

struct Node {
    bounds: Bounds3,
    /// What it costs a ray that meets it.
    cost: f64,
    /// The places in the order of all that is below.
    places: Range<u32>,
    /// The node behind all that is below: the next child of its parent, where that has one. A leaf's is the next one.
    end: u32,
}

impl Boxes {
    /// Adds a leaf.
    pub(crate) fn leaf(&mut self, bounds: Bounds3, cost: f64, primitives: impl IntoIterator<Item = u32>) {
        let first = self.order.len() as u32;
        self.order.extend(primitives);
        let end = self.nodes.len() as u32 + 1;
        self.nodes.push(Node { bounds, cost, places: first..self.order.len() as u32, end });
    }

    /// Begins an interior node: what is added until its [`end`](Self::end) is below.
    pub(crate) fn begin(&mut self, bounds: Bounds3, cost: f64) -> usize {
        let first = self.order.len() as u32;
        self.nodes.push(Node { bounds, cost, places: first..first, end: 0 });
        self.nodes.len() - 1
    }

    /// Ends the node that [`begin`](Self::begin) has begun.
    pub(crate) fn end(&mut self, node: usize) {
        let end = self.nodes.len() as u32;
        (self.nodes[node].end, self.nodes[node].places.end) = (end, self.order.len() as u32);
    }

    /// The children of a node; none of a leaf.
    fn children(&self, node: usize) -> impl Iterator<Item = usize> {
        let end = self.nodes[node].end as usize;
        let next = move |child: usize| (child < end).then_some(child);
        std::iter::successors(next(node + 1), move |&child| next(self.nodes[child].end as usize))
    }

    pub(crate) fn quality(&self) -> TreeQuality {
        let mut quality = TreeQuality::default();
        for (i, node) in self.nodes.iter().enumerate() {
            quality.sah_cost += node.cost * node.bounds.surface_area();
            if node.end as usize == i + 1 {
                let count = node.places.len();
                if quality.leaf_histogram.len() <= count {
                    quality.leaf_histogram.resize(count + 1, 0);
                }
                quality.leaf_histogram[count] += 1;
            }
            for child in self.children(i) {
                let Bounds3 { min, max } = self.nodes[child].bounds;
                for other in self.children(i).take_while(|&other| other < child) {
                    let other = self.nodes[other].bounds;
                    quality.overlap += Bounds3::new(min.max(other.min), max.min(other.max)).surface_area();
                }
            }
        }
        let area = self.nodes.first().map_or(0.0, |root| root.bounds.surface_area());
        let part = |sum: f64| if area > 0.0 { sum / area } else { 0.0 };
        TreeQuality { sah_cost: part(quality.sah_cost), overlap: part(quality.overlap), ..quality }
    }

    /// See [`FlatBvh::effective_primitive_overlap`](crate::FlatBvh::effective_primitive_overlap).
    pub(crate) fn effective_primitive_overlap(&self, mesh: &TriangleMesh) -> f64 {
        let mut references: Vec<(u32, u32)> = (0..).zip(&self.order).map(|(place, &i)| (i, place)).collect();
        references.sort_unstable();
        let triangles: Vec<&[(u32, u32)]> = references.chunk_by(|a, b| a.0 == b.0).collect();
        let [overlapping, all] = self.overlap(mesh, &triangles);
        if all > 0.0 { overlapping / all } else { 0.0 }
    }

    /// The overlap of triangles, each with its places in the order, and their area.
    fn overlap(&self, mesh: &TriangleMesh, triangles: &[&[(u32, u32)]]) -> [f64; 2] {
        const SEQUENTIAL: usize = 256;
        if triangles.len() <= SEQUENTIAL {
            return triangles.iter().fold([0.0; 2], |sum, references| {
                let vertices = mesh.vertices(references[0].0 as usize);
                [sum[0] + self.overlap_of(&vertices, references), sum[1] + area(&vertices.map(Vec3::as_dvec3))]
            });
        }
        let (a, b) = triangles.split_at(triangles.len() / 2);
        let (a, b) = join(|| self.overlap(mesh, a), || self.overlap(mesh, b));
        [a[0] + b[0], a[1] + b[1]]
    }

    /// The overlap of one triangle.
    fn overlap_of(&self, vertices: &[Vec3; 3], references: &[(u32, u32)]) -> f64 {
        let (mut sum, mut next) = (0.0, 0);
        while let Some(node) = self.nodes.get(next) {
            let inside = area_within(vertices, &node.bounds);
            if inside > 0.0 && !references.iter().any(|(_, place)| node.places.contains(place)) {
                sum += node.cost * inside;
            }
            next = if inside > 0.0 { next + 1 } else { node.end as usize };
        }
        sum
    }
}

/// The area of the part of a triangle that is within bounds: Sutherland and Hodgman's clipping, in f64.
fn area_within(vertices: &[Vec3; 3], bounds: &Bounds3) -> f64 {
    let [a, b, c] = *vertices;
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    if min.cmpgt(bounds.max).any() || max.cmplt(bounds.min).any() {
        return 0.0;
    }
    let mut polygon: Vec<DVec3> = vertices.map(Vec3::as_dvec3).into();
    for axis in 0..3 {
        let planes = [(bounds.min, min, 1.0), (bounds.max, max, -1.0)];
        // Most planes cut nothing off.
        for (plane, _, sign) in planes.into_iter().filter(|(plane, end, sign)| sign * (end[axis] - plane[axis]) < 0.0) {
            let inside = |p: DVec3| f64::from(sign) * (p[axis] - f64::from(plane[axis]));
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
