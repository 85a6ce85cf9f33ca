//! Indexed triangle meshes.

use std::ops::ControlFlow;

use glam::{Vec2, Vec3};
use thiserror::Error;

use crate::{
    Bounds3, Hit, HitVisitor, Interval, Shape, SurfacePoint, TraversalRay, Visit, Work, intersect_triangle,
    triangle_bounds, triangle_surface_point, watertight_triangle_bounds,
};

/// Triangles over shared vertices. Every index is in range by construction.
///
/// A triangle with a coordinate that is NaN, infinite or beyond [`MAX_COORDINATE`](crate::MAX_COORDINATE) is inactive:
/// it keeps its index and is never hit. Triangles without area are never hit either.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    uvs: Option<Vec<Vec2>>,
}

/// Why arrays are not a mesh.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshError {
    /// An index names no vertex.
    #[error("triangle {triangle} uses vertex {index}, but there are only {vertex_count} vertices, counted from 0")]
    IndexOutOfRange {
        /// The triangle with the index.
        triangle: usize,
        /// The index.
        index: u32,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// There are more vertices or triangles than 32-bit indices can name.
    #[error("{count} {what} are more than a 32-bit index can name; split the mesh")]
    TooLarge {
        /// "vertices" or "triangles".
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// Positions are to take the place of another number of them.
    #[error("{found} positions cannot replace {expected}: there must be one for each vertex")]
    PositionCount {
        /// How many there were.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// There is not one texture coordinate for each vertex.
    #[error("{uv_count} texture coordinates for {vertex_count} vertices: there must be one for each")]
    UvCount {
        /// How many texture coordinates.
        uv_count: usize,
        /// How many vertices.
        vertex_count: usize,
    },
}

impl TriangleMesh {
    /// A mesh of `triangles` over `positions`. Flat arrays, as loaders give them, are taken apart on the way:
    ///
    /// ```
    /// # use geometry::TriangleMesh;
    /// let positions: Vec<f32> = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    /// let indices: Vec<u32> = vec![0, 1, 2];
    /// let corners = positions.as_chunks::<3>().0.iter().copied();
    /// let mesh = TriangleMesh::new(corners, indices.as_chunks().0.to_vec())?;
    /// # assert_eq!((mesh.len(), mesh.positions().len()), (1, 3));
    /// # Ok::<(), geometry::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::IndexOutOfRange`] for the first index that names no vertex, [`MeshError::TooLarge`].
    pub fn new(
        positions: impl IntoIterator<Item = impl Into<Vec3>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        let positions: Vec<Vec3> = positions.into_iter().map(Into::into).collect();
        for (what, count) in [("vertices", positions.len()), ("triangles", triangles.len())] {
            if u32::try_from(count).is_err() {
                return Err(MeshError::TooLarge { what, count });
            }
        }
        let vertex_count = positions.len();
        for (triangle, indices) in triangles.iter().enumerate() {
            if let Some(&index) = indices.iter().find(|&&i| i as usize >= vertex_count) {
                return Err(MeshError::IndexOutOfRange { triangle, index, vertex_count });
            }
        }
        Ok(Self { positions, triangles, uvs: None })
    }

    /// The same mesh with a texture coordinate for each vertex.
    ///
    /// # Errors
    /// [`MeshError::UvCount`] where their number is not that of the vertices.
    pub fn with_uvs(self, uvs: impl IntoIterator<Item = impl Into<Vec2>>) -> Result<Self, MeshError> {
        let uvs: Vec<Vec2> = uvs.into_iter().map(Into::into).collect();
        if uvs.len() != self.positions.len() {
            return Err(MeshError::UvCount { uv_count: uvs.len(), vertex_count: self.positions.len() });
        }
        Ok(Self { uvs: Some(uvs), ..self })
    }

    /// The same triangles and texture coordinates where the vertices are elsewhere: the next frame of a mesh that
    /// deforms.
    ///
    /// # Errors
    /// [`MeshError::PositionCount`] where their number is not that of the vertices.
    pub fn with_positions(self, positions: impl IntoIterator<Item = impl Into<Vec3>>) -> Result<Self, MeshError> {
        let (positions, expected): (Vec<Vec3>, _) =
            (positions.into_iter().map(Into::into).collect(), self.positions.len());
        if positions.len() != expected {
            return Err(MeshError::PositionCount { expected, found: positions.len() });
        }
        Ok(Self { positions, ..self })
    }

    /// The vertices' positions.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The vertices of each triangle, as indices into [`positions`](Self::positions).
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The vertices' texture coordinates, if there are any.
    pub fn uvs(&self) -> Option<&[Vec2]> {
        self.uvs.as_deref()
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The vertices of triangle `i`.
    ///
    /// # Panics
    /// Where `i` is not below [`len`](Self::len).
    #[inline]
    pub fn vertices(&self, i: usize) -> [Vec3; 3] {
        self.triangles[i].map(|v| self.positions[v as usize])
    }

    /// The [box](crate::triangle_bounds) of triangle `i`, not [valid](Bounds3::is_valid) where the triangle is
    /// inactive.
    ///
    /// # Panics
    /// Where `i` is not below [`len`](Self::len).
    #[inline]
    pub fn triangle_bounds(&self, i: usize) -> Bounds3 {
        triangle_bounds(&self.vertices(i))
    }

    /// The box of triangle `i` for trees that are asked by the [watertight test](crate::intersect_triangle): it is
    /// [grown](crate::watertight_triangle_bounds) by what that may see beside the triangle.
    ///
    /// # Panics
    /// Where `i` is not below [`len`](Self::len).
    pub fn watertight_bounds(&self, i: usize) -> Bounds3 {
        watertight_triangle_bounds(&self.vertices(i))
    }

    /// The surface of triangle `i` where `ray` meets its plane.
    ///
    /// # Panics
    /// Where `i` is not below [`len`](Self::len).
    pub fn triangle_surface_point(&self, i: usize, ray: &TraversalRay) -> SurfacePoint {
        triangle_surface_point(ray, &self.vertices(i), &self.corner_uvs(i))
    }

    /// The surface of triangle `i` at (1 − u − v) a + u b + v c, where no ray has been: a place on an area light. `u`
    /// and `v` are at least 0, and their sum is at most 1 but for rounding. For places spread evenly over the triangle,
    /// of two numbers r and s in [0, 1): u = 1 − √r, v = s √r.
    ///
    /// # Panics
    /// Where `i` is not below [`len`](Self::len).
    pub fn surface_at(&self, i: usize, u: f32, v: f32) -> SurfacePoint {
        let [a, b, c] = self.vertices(i).map(Vec3::as_dvec3);
        let [uv_a, uv_b, uv_c] = self.corner_uvs(i);
        let n = (b - a).cross(c - a).normalize_or_zero();
        let uv = (1.0 - u - v) * uv_a + u * uv_b + v * uv_c;
        let [u, v] = [u, v].map(f64::from);
        let p = (1.0 - u - v) * a + u * b + v * c;
        // Two roundings of the first weight, one of each product, two of the sums, of 2⁻⁵³ each.
        let size = a.abs().max(b.abs()).max(c.abs());
        SurfacePoint { p, p_error: size * (4.0 * f64::EPSILON), n, uv }
    }

    /// The texture coordinates of the corners of triangle `i`.
    fn corner_uvs(&self, i: usize) -> [Vec2; 3] {
        match &self.uvs {
            Some(uvs) => self.triangles[i].map(|v| uvs[v as usize]),
            None => [Vec2::ZERO, Vec2::X, Vec2::Y],
        }
    }
}

/// The naive shape: every triangle is tested. The reference for every tree over a mesh.
impl Shape for TriangleMesh {
    fn object_bound(&self) -> Bounds3 {
        (0..self.len())
            .map(|i| self.watertight_bounds(i))
            .filter(Bounds3::is_valid)
            .fold(Bounds3::EMPTY, |all, b| all.union(&b))
    }

    fn primitive_count(&self) -> u64 {
        self.triangles.len() as u64
    }

    fn visit_hits(&self, ray: &TraversalRay, mut interval: Interval, visitor: &mut dyn HitVisitor) -> Visit {
        visitor.work(Work { nodes: 0, primitives: self.primitive_count() });
        for i in 0..self.len() {
            let vertices = self.vertices(i);
            let Some(h) = intersect_triangle(ray, &vertices, interval) else { continue };
            if !triangle_bounds(&vertices).is_valid() {
                continue;
            }
            let t_max = visitor.hit(Hit { t: h.t, u: h.u, v: h.v, primitive: i as u64 })?;
            interval = interval.with_t_max(t_max);
        }
        ControlFlow::Continue(interval.t_max())
    }

    fn surface_point(&self, ray: &TraversalRay, hit: &Hit) -> SurfacePoint {
        self.triangle_surface_point(hit.primitive as usize, ray)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;

    fn quad(z: &[f32]) -> TriangleMesh {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for &z in z {
            let first = positions.len() as u32;
            positions.extend([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]].map(Vec3::from));
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        TriangleMesh::new(positions, triangles).expect("indices are in range")
    }

    fn down(x: f32, y: f32) -> TraversalRay {
        TraversalRay::new(&Ray::new([x, y, 10.0], [0.0, 0.0, -1.0])).expect("valid")
    }

    #[test]
    fn indices_are_checked() {
        let e = TriangleMesh::new(vec![Vec3::ZERO; 3], vec![[0, 1, 2], [0, 3, 1]]).expect_err("3 is out of range");
        assert_eq!(e, MeshError::IndexOutOfRange { triangle: 1, index: 3, vertex_count: 3 });
        assert!(e.to_string().contains("triangle 1 uses vertex 3"));
        assert!(quad(&[0.0]).with_uvs(vec![Vec2::ZERO]).is_err());
    }

    #[test]
    fn vertices_move_and_keep_everything_else() {
        let quads = quad(&[0.0, 1.0]).with_uvs([[0.25, 0.5]; 8]).expect("as many");
        let moved = quads.clone().with_positions(quads.positions().iter().map(|&p| p + Vec3::Z)).expect("as many");
        assert_eq!(moved, quad(&[1.0, 2.0]).with_uvs([[0.25, 0.5]; 8]).expect("as many"));
        assert_eq!(quads.with_positions([[0.0; 3]]), Err(MeshError::PositionCount { expected: 8, found: 1 }));
    }

    /// Of corners and weights that are integers over powers of two, in integers.
    #[test]
    fn surfaces_are_within_their_error_of_the_exact_place() {
        let mut state = 1_u64;
        let mut next = move |bits: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> (64 - bits)) as i128
        };
        for _ in 0..10_000 {
            let corners = [0; 3].map(|_| [0; 3].map(|_| next(24) - (1 << 23)));
            let mesh = TriangleMesh::new(corners.map(|p| p.map(|x| x as f32)), vec![[0, 1, 2]]).expect("in range");
            let u = next(24);
            let v = next(24).min((1 << 24) - u);
            let [u32, v32] = [u, v].map(|x| x as f32 / (1 << 24) as f32);
            let point = mesh.surface_at(0, u32, v32);
            for i in 0..3 {
                let [a, b, c] = corners.map(|p| p[i]);
                let exact = (((1 << 24) - u - v) * a + u * b + v * c) << 16;
                let distance = (point.p[i] * 2.0_f64.powi(40)) as i128 - exact;
                assert!(distance.abs() as f64 <= point.p_error[i] * 2.0_f64.powi(40), "{point:?}");
            }
            assert_eq!(point.uv, Vec2::new(u32, v32));
            assert!((point.n.length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn closest_wins_whatever_the_order() {
        for z in [[0.0, 1.0, 2.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]] {
            let hit = quad(&z).intersect(&down(0.7, 0.2), Interval::FULL).expect("above the quads");
            assert_eq!(hit.t, 8.0);
            assert_eq!(z[hit.primitive as usize / 2], 2.0);
        }
    }

    #[test]
    fn ties_go_to_the_smallest_index() {
        let hit = quad(&[1.0, 1.0]).intersect(&down(0.5, 0.5), Interval::FULL).expect("above the quads");
        assert_eq!((hit.t, hit.primitive), (9.0, 0));
    }

    #[test]
    fn all_hits_are_visited_and_a_visitor_may_stop() {
        let mut seen = Vec::new();
        let mesh = quad(&[0.0, 1.0, 2.0]);
        let _ = mesh.visit_hits(&down(0.7, 0.2), Interval::FULL, &mut |h: Hit| {
            seen.push(h.primitive);
            ControlFlow::Continue(f32::INFINITY)
        });
        assert_eq!(seen, [0, 2, 4]);
        seen.clear();
        let end = mesh.visit_hits(&down(0.7, 0.2), Interval::FULL, &mut |h: Hit| {
            seen.push(h.primitive);
            ControlFlow::Break(())
        });
        assert!(end.is_break() && seen.len() == 1);
    }

    #[test]
    fn inactive_triangles_keep_their_index() {
        let mut positions = quad(&[0.0]).positions().to_vec();
        positions.push(Vec3::new(f32::NAN, 0.0, 0.0));
        let mesh = TriangleMesh::new(positions, vec![[4, 1, 2], [0, 1, 2]]).expect("indices are in range");
        let hit = mesh.intersect(&down(0.7, 0.2), Interval::FULL).expect("the second triangle");
        assert_eq!(hit.primitive, 1);
        assert!(mesh.object_bound().is_valid());
    }
}
