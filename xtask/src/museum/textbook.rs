//! The tracer that most first drafts are: what the museum's bugs live in.
//!
//! A binary tree, split at the middle of the centroids' longest axis, with leaves that are counted in 16 bits;
//! traversal with a stack of 64; bounds and box tests in plain f32. Nothing of it is strawman: each [`Habits`] is the
//! code of a project whose thread the exhibit names. What would write over memory in C is lost here, what would not
//! end is refused.

use std::sync::Arc;

use bvh_flat::geometry::exact::intersect_triangle_exact;
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::naive::{enter_unpadded, moller_trumbore};
use bvh_flat::geometry::{Bounds3, Hit, Interval, Shape, Sphere, TraversalRay, TriangleMesh};

/// What is traced.
#[derive(Clone)]
pub enum Shapes {
    Triangles(Arc<TriangleMesh>),
    Spheres(Arc<Vec<Sphere>>),
}

impl Shapes {
    fn len(&self) -> usize {
        match self {
            Self::Triangles(mesh) => mesh.len(),
            Self::Spheres(spheres) => spheres.len(),
        }
    }

    fn bounds(&self, i: usize) -> Bounds3 {
        match self {
            Self::Triangles(mesh) => {
                let [a, b, c] = mesh.vertices(i);
                union(union(point(a), point(b)), point(c))
            }
            Self::Spheres(spheres) => spheres[i].object_bound(),
        }
    }
}

fn point(p: Vec3) -> Bounds3 {
    Bounds3 { min: p, max: p }
}

/// Each end by a comparison: where the new one is no number it wins, and is forgotten for the next.
fn union(old: Bounds3, new: Bounds3) -> Bounds3 {
    let ends = |least: fn(f32, f32) -> bool, old: Vec3, new: Vec3| {
        Vec3::from_array([0, 1, 2].map(|k| if least(old[k], new[k]) { old[k] } else { new[k] }))
    };
    Bounds3 { min: ends(|a, b| a < b, old.min, new.min), max: ends(|a, b| a > b, old.max, new.max) }
}

/// How the tracer tests, and what it takes for granted.
#[derive(Clone, Copy, Debug)]
pub struct Habits {
    pub box_test: BoxTest,
    pub triangle_test: TriangleTest,
    /// Splits until one primitive is left, whether or not the centroids differ.
    pub splits_until_one: bool,
    /// Begins with the root's children, without asking whether it has any.
    pub root_has_children: bool,
}

/// How a box is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxTest {
    /// The library's own, so that another habit is seen alone.
    Padded,
    /// The slab test without padding, in which NaN bounds nothing.
    Unpadded,
    /// The slab test whose comparisons fail where the first axis gives 0 · ∞ = NaN.
    NanOfFirstAxis,
    /// The slab test that takes which plane is near from the sign of the direction, and −0 for positive.
    NearBySignOfDirection,
}

/// How a triangle is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleTest {
    /// The library's own, so that another habit is seen alone.
    Exact,
    /// Möller and Trumbore in f32.
    MollerTrumbore,
    /// The same, which takes a determinant below 10⁻⁷ for a parallel ray.
    DeterminantEpsilon,
    /// The same, which divides by any determinant and leaves where a comparison holds: no NaN ever leaves.
    Unguarded,
}

/// Why there is no tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    EndlessRecursion,
    NoRoot,
    RootWithoutChildren,
}

impl Trouble {
    pub fn words(self) -> &'static str {
        match self {
            Self::EndlessRecursion => "the build does not end",
            Self::NoRoot => "reads a root that is not there",
            Self::RootWithoutChildren => "reads children that are not there",
        }
    }
}

/// The tree of a scene of the museum may be this deep; a deeper one would go on for ever.
const ENDLESS: usize = 1000;
const STACK: usize = 64;
const MAX_LEAF: usize = 4;

pub struct Textbook {
    shapes: Shapes,
    habits: Habits,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// In depth-first order: the left child of an inner node comes next.
struct Node {
    bounds: Bounds3,
    kind: Kind,
}

enum Kind {
    Leaf { first: usize, count: u16 },
    Inner { right: usize, axis: usize },
}

impl Textbook {
    pub fn build(shapes: Shapes, habits: Habits) -> Result<Self, Trouble> {
        let order: Vec<u32> = (0..shapes.len() as u32).collect();
        let mut tracer = Self { nodes: Vec::new(), shapes, habits, order };
        let bounds: Vec<Bounds3> = (0..tracer.shapes.len()).map(|i| tracer.shapes.bounds(i)).collect();
        tracer.split(&bounds, 0, bounds.len(), 0)?;
        match tracer.nodes[0].kind {
            Kind::Leaf { .. } if habits.root_has_children => Err(Trouble::RootWithoutChildren),
            _ => Ok(tracer),
        }
    }

    fn split(&mut self, bounds: &[Bounds3], first: usize, end: usize, depth: usize) -> Result<(), Trouble> {
        if depth > ENDLESS {
            return Err(Trouble::EndlessRecursion);
        }
        let of = |i: &u32| bounds[*i as usize];
        let centroid = |i: &u32| 0.5 * (of(i).min + of(i).max);
        let some = &self.order[first..end];
        let Some(head) = some.first() else { return Err(Trouble::NoRoot) };
        let (mut all, mut centroids) = (of(head), point(centroid(head)));
        for i in some {
            all = union(all, of(i));
            centroids = union(centroids, point(centroid(i)));
        }
        let extent = centroids.diagonal();
        let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
        let middle = 0.5 * (centroids.min[axis] + centroids.max[axis]);
        let (left, right): (Vec<u32>, Vec<u32>) = some.iter().partition(|i| centroid(i)[axis] < middle);
        let is_leaf = if self.habits.splits_until_one {
            some.len() == 1
        } else {
            some.len() <= MAX_LEAF || left.is_empty() || right.is_empty()
        };
        let place = self.nodes.len();
        let kind = Kind::Leaf { first, count: some.len() as u16 };
        self.nodes.push(Node { bounds: all, kind });
        if is_leaf {
            return Ok(());
        }
        let middle = first + left.len();
        self.order[first..middle].copy_from_slice(&left);
        self.order[middle..end].copy_from_slice(&right);
        if first < middle {
            self.split(bounds, first, middle, depth + 1)?;
        }
        let right = self.nodes.len();
        self.split(bounds, middle, end, depth + 1)?;
        self.nodes[place].kind = Kind::Inner { right, axis };
        Ok(())
    }

    /// The closest hit, as this tracer sees it.
    pub fn intersect(&self, ray: &TraversalRay) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let mut stack = Vec::with_capacity(STACK);
        let mut next = Some(0);
        while let Some(place) = next {
            let t_max = closest.map_or(f32::INFINITY, |hit| hit.t);
            next = None;
            let node = &self.nodes[place];
            if self.enters(ray, &node.bounds, t_max) {
                match node.kind {
                    Kind::Leaf { first, count } => {
                        for &i in &self.order[first..first + usize::from(count)] {
                            let t_max = closest.map_or(f32::INFINITY, |hit| hit.t);
                            closest = self.hit(ray, i, t_max).or(closest);
                        }
                    }
                    Kind::Inner { right, axis } => {
                        let (near, far) = (place + 1, right);
                        let (near, far) = if ray.ray().direction[axis] < 0.0 { (far, near) } else { (near, far) };
                        if stack.len() < STACK {
                            stack.push(far);
                        }
                        next = Some(near);
                    }
                }
            }
            next = next.or_else(|| stack.pop());
        }
        closest
    }

    fn enters(&self, ray: &TraversalRay, bounds: &Bounds3, t_max: f32) -> bool {
        let interval = Interval::up_to(t_max);
        match self.habits.box_test {
            BoxTest::Padded => ray.enter(bounds, interval).is_some(),
            BoxTest::Unpadded => enter_unpadded(ray, bounds, interval).is_some(),
            BoxTest::NanOfFirstAxis => slab(ray, bounds, t_max, |_, reciprocal| reciprocal < 0.0),
            BoxTest::NearBySignOfDirection => slab(ray, bounds, t_max, |direction, _| direction < 0.0),
        }
    }

    fn hit(&self, ray: &TraversalRay, i: u32, t_max: f32) -> Option<Hit> {
        let interval = Interval::up_to(t_max);
        let found = match &self.shapes {
            Shapes::Spheres(spheres) => spheres[i as usize].intersect(ray, interval).map(|hit| hit.t),
            Shapes::Triangles(mesh) => {
                let vertices = mesh.vertices(i as usize);
                match self.habits.triangle_test {
                    TriangleTest::Exact => intersect_triangle_exact(ray, &vertices, interval).map(|hit| hit.t),
                    TriangleTest::MollerTrumbore => moller_trumbore(ray, &vertices, interval).map(|hit| hit.t),
                    TriangleTest::DeterminantEpsilon => {
                        let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]);
                        let is_parallel = ray.ray().direction.dot(normal).abs() < 1e-7;
                        moller_trumbore(ray, &vertices, interval).filter(|_| !is_parallel).map(|hit| hit.t)
                    }
                    TriangleTest::Unguarded => unguarded(ray, &vertices, t_max),
                }
            }
        };
        found.map(|t| Hit { t, u: 0.0, v: 0.0, primitive: u64::from(i) })
    }
}

/// The slab test axis by axis, each with comparisons that leave what is before where there is NaN. So a NaN of the
/// first axis stays, and fails the last comparison.
fn slab(ray: &TraversalRay, bounds: &Bounds3, t_max: f32, is_reversed: fn(f32, f32) -> bool) -> bool {
    let (origin, direction) = (ray.ray().origin, ray.ray().direction);
    let planes = |k: usize| {
        let reciprocal = 1.0 / direction[k];
        let [near, far] = if is_reversed(direction[k], reciprocal) {
            [bounds.max[k], bounds.min[k]]
        } else {
            [bounds.min[k], bounds.max[k]]
        };
        [(near - origin[k]) * reciprocal, (far - origin[k]) * reciprocal]
    };
    let [mut entry, mut exit] = planes(0);
    for k in 1..3 {
        let [near, far] = planes(k);
        if entry > far || near > exit {
            return false;
        }
        if near > entry {
            entry = near;
        }
        if far < exit {
            exit = far;
        }
    }
    entry < t_max && exit > 0.0
}

/// Möller and Trumbore's test that says no where a comparison holds.
#[expect(clippy::manual_range_contains, reason = "the comparisons are the exhibit")]
fn unguarded(ray: &TraversalRay, vertices: &[Vec3; 3], t_max: f32) -> Option<f32> {
    let (origin, direction) = (ray.ray().origin, ray.ray().direction);
    let (e1, e2) = (vertices[1] - vertices[0], vertices[2] - vertices[0]);
    let p = direction.cross(e2);
    let reciprocal = 1.0 / e1.dot(p);
    let s = origin - vertices[0];
    let u = reciprocal * s.dot(p);
    let q = s.cross(e1);
    let v = reciprocal * direction.dot(q);
    let t = reciprocal * e2.dot(q);
    let is_outside = u < 0.0 || u > 1.0 || v < 0.0 || u + v > 1.0 || t <= 0.0 || t >= t_max;
    (!is_outside).then_some(t)
}
