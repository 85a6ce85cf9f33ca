//! What a query finds: the least that names a place on a surface.

use std::ops::ControlFlow;

use crate::Interval;

/// A place where a ray meets a surface: all that traversal keeps. Position, normal and the rest are computed from it on
/// demand, once, for the hit that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Hit {
    /// The ray's parameter, in multiples of its direction's length.
    pub t: f32,
    /// First surface parameter: a triangle's barycentric of its second vertex, in [0, 1]; 0 for a sphere. What a
    /// renderer has for each vertex (shading normals, colours) is (1 − u − v) a + u b + v c.
    pub u: f32,
    /// Second surface parameter: a triangle's barycentric of its third vertex, in [0, 1]; 0 for a sphere.
    pub v: f32,
    /// The index of the primitive in the depth-first order of whatever was asked: a triangle's index in its mesh; in an
    /// aggregate of aggregates the children's counts add up, an instance counting like a copy. An aggregate's list
    /// (`member_of`) says which member that is, and which primitive of the member.
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
        Self { primitive: self.primitive.saturating_add(count), ..self }
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

impl<F> std::fmt::Debug for MappedVisitor<'_, F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MappedVisitor").finish_non_exhaustive()
    }
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

/// The visitor that a closest-hit query is: keeps the closest of the hits that `accept` takes, and asks for closer ones
/// only.
#[derive(Clone, Debug)]
pub struct ClosestHit<F = fn(&Hit) -> bool> {
    hit: Option<Hit>,
    work: Work,
    t_max: f32,
    accept: F,
}

impl ClosestHit {
    /// The closest of all hits in the interval.
    pub fn new(interval: Interval) -> Self {
        Self::among(interval, |_| true)
    }
}

impl<F: FnMut(&Hit) -> bool> ClosestHit<F> {
    /// The closest of the hits in the interval that `accept` takes: for alpha masks, ray masks, or to ignore a
    /// primitive. `accept` is asked in no particular order and not of all hits; it must answer by the hit alone.
    pub fn among(interval: Interval, accept: F) -> Self {
        Self { hit: None, work: Work::default(), t_max: interval.t_max(), accept }
    }

    /// The closest hit.
    pub fn hit(&self) -> Option<Hit> {
        self.hit
    }

    /// What finding it cost.
    pub fn work(&self) -> Work {
        self.work
    }
}

impl<F: FnMut(&Hit) -> bool> HitVisitor for ClosestHit<F> {
    fn hit(&mut self, hit: Hit) -> Visit {
        if self.hit.as_ref().is_none_or(|closest| hit.is_before(closest)) && (self.accept)(&hit) {
            self.t_max = hit.t_max_for_ties();
            self.hit = Some(hit);
        }
        ControlFlow::Continue(self.t_max)
    }

    fn work(&mut self, work: Work) {
        self.work += work;
    }
}

/// The visitor that an any-hit query is: keeps the first hit found that `accept` takes, and stops.
#[derive(Clone, Copy, Debug)]
pub struct FirstHit<F = fn(&Hit) -> bool> {
    hit: Option<Hit>,
    work: Work,
    t_max: f32,
    accept: F,
}

/// Takes every hit, of whatever interval is asked.
impl Default for FirstHit {
    fn default() -> Self {
        Self::among(Interval::FULL, |_| true)
    }
}

impl<F: FnMut(&Hit) -> bool> FirstHit<F> {
    /// Any of the hits in the interval that `accept` takes: for shadows through alpha masks, ray masks, or to ignore a
    /// primitive. `accept` is asked in no particular order, and no more once it took a hit; it must answer by the hit
    /// alone.
    ///
    /// ```
    /// use geometry::{FirstHit, Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
    ///
    /// // Two leaves of one triangle each. The first is cut out where u > ½.
    /// let leaf = |z| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    /// let leaves = TriangleMesh::new([leaf(0.0), leaf(1.0)].concat(), vec![[0, 1, 2], [3, 4, 5]])?;
    /// let is_opaque = |hit: &Hit| hit.primitive != 0 || hit.u <= 0.5;
    ///
    /// let ray = TraversalRay::new(&Ray::new([0.75, 0.125, -1.0], [0.0, 0.0, 1.0])).expect("it has a direction");
    /// for (interval, blocker) in [(Interval::FULL, Some(1)), (Interval::up_to(1.5), None)] {
    ///     let mut shadow = FirstHit::among(interval, is_opaque);
    ///     let is_blocked = leaves.visit_hits(&ray, interval, &mut shadow).is_break();
    ///     assert_eq!((is_blocked, shadow.hit().map(|hit| hit.primitive)), (blocker.is_some(), blocker));
    /// }
    /// # Ok::<(), geometry::MeshError>(())
    /// ```
    pub fn among(interval: Interval, accept: F) -> Self {
        Self { hit: None, work: Work::default(), t_max: interval.t_max(), accept }
    }

    /// Whichever hit was found first.
    pub fn hit(&self) -> Option<Hit> {
        self.hit
    }

    /// What finding it cost.
    pub fn work(&self) -> Work {
        self.work
    }
}

impl<F: FnMut(&Hit) -> bool> HitVisitor for FirstHit<F> {
    fn hit(&mut self, hit: Hit) -> Visit {
        if !(self.accept)(&hit) {
            return ControlFlow::Continue(self.t_max);
        }
        self.hit = Some(hit);
        ControlFlow::Break(())
    }

    fn work(&mut self, work: Work) {
        self.work += work;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(t: f32, primitive: u64) -> Hit {
        Hit { t, u: 0.0, v: 0.0, primitive }
    }

    #[test]
    fn any_hit_passes_over_what_is_not_accepted_and_stops_at_what_is() {
        let interval = Interval::up_to(9.0);
        let mut asked = Vec::new();
        let mut first = FirstHit::among(interval, |hit: &Hit| {
            asked.push(hit.primitive);
            hit.primitive == 2
        });
        for (found, answer) in [
            (hit(1.0, 0), ControlFlow::Continue(9.0)),
            (hit(0.5, 1), ControlFlow::Continue(9.0)),
            (hit(5.0, 2), ControlFlow::Break(())),
        ] {
            assert_eq!(HitVisitor::hit(&mut first, found), answer);
        }
        assert_eq!(FirstHit::hit(&first), Some(hit(5.0, 2)));
        assert_eq!(asked, [0, 1, 2]);
    }

    #[test]
    fn without_a_filter_any_hit_is_the_first() {
        let mut first = FirstHit::default();
        assert_eq!(HitVisitor::hit(&mut first, hit(3.0, 7)), ControlFlow::Break(()));
        assert_eq!(FirstHit::hit(&first), Some(hit(3.0, 7)));
    }
}
