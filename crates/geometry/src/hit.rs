//! What a query finds: the least that names a place on a surface.

use std::ops::ControlFlow;

/// A place where a ray meets a surface: all that traversal keeps. Position, normal and the rest are computed from it on
/// demand, once, for the hit that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Hit {
    /// The ray's parameter, in multiples of its direction's length.
    pub t: f32,
    /// First surface parameter: a triangle's barycentric of its second vertex; 0 for a sphere.
    pub u: f32,
    /// Second surface parameter: a triangle's barycentric of its third vertex; 0 for a sphere.
    pub v: f32,
    /// The index of the primitive in the depth-first order of whatever was asked: a triangle's index in its mesh; in an
    /// aggregate of aggregates the children's counts add up, an instance counting like a copy.
    pub primitive: u64,
}

impl Hit {
    /// The rule of the closest hit: the smaller `t`, and of equal `t` the smaller primitive. It does not depend on the
    /// order in which hits are found, hence not on any tree.
    pub fn is_before(&self, other: &Self) -> bool {
        (self.t, self.primitive) < (other.t, other.primitive)
    }

    /// The upper end that still admits a hit at this one's `t`, as the rule of equal `t` needs.
    pub fn t_max_for_ties(&self) -> f32 {
        self.t.next_up()
    }

    /// The same hit, of a primitive that comes `count` later in the surrounding order.
    pub fn offset_by(self, count: u64) -> Self {
        Self { primitive: self.primitive + count, ..self }
    }
}

/// What a visitor of hits answers: `Continue(t_max)` to be told of further hits below `t_max`, or `Break(())` to stop.
pub type Visit = ControlFlow<(), f32>;

/// Whoever is told of hits. Every closure `|hit: Hit| -> Visit` is one.
pub trait HitVisitor {
    /// Takes a hit.
    fn hit(&mut self, hit: Hit) -> Visit;

    /// Is told what finding the hits of one aggregate cost. Whoever does not ask does not pay: plain closest-hit and
    /// any-hit queries use no visitor and count nothing.
    fn work(&mut self, work: Work) {
        let _ = work;
    }
}

impl<F: FnMut(Hit) -> Visit> HitVisitor for F {
    fn hit(&mut self, hit: Hit) -> Visit {
        self(hit)
    }
}

/// What a query cost, in steps that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Nodes of trees visited.
    pub nodes: u64,
    /// Primitives tested.
    pub primitives: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.primitives += other.primitives;
    }
}

/// A visitor that tells another one of the same hits, changed by `map`: how an aggregate passes on what its members
/// report.
pub struct MappedVisitor<'a, F> {
    visitor: &'a mut dyn HitVisitor,
    map: F,
}

impl<'a, F: Fn(Hit) -> Hit> MappedVisitor<'a, F> {
    /// Tells `visitor` of `map(hit)` for every hit.
    pub fn new(visitor: &'a mut dyn HitVisitor, map: F) -> Self {
        Self { visitor, map }
    }
}

impl<F: Fn(Hit) -> Hit> HitVisitor for MappedVisitor<'_, F> {
    fn hit(&mut self, hit: Hit) -> Visit {
        self.visitor.hit((self.map)(hit))
    }

    fn work(&mut self, work: Work) {
        self.visitor.work(work);
    }
}
