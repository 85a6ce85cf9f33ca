//! Queries that also tell what they cost.

use std::ops::ControlFlow;

use geometry::{Hit, HitVisitor, Interval, TraversalRay, Visit, Work};

use crate::{HitKind, Primitive};

/// The closest hit, as [`Primitive::intersect`] finds it, and the work of finding it.
pub fn intersect_counted<P: Primitive + ?Sized>(
    primitive: &P,
    ray: &TraversalRay,
    interval: Interval,
) -> (Option<Hit>, Work) {
    let mut closest = Counting { hit: None, work: Work::default(), t_max: interval.t_max(), stops: false };
    let _ = primitive.visit_hits(ray, interval, HitKind::Material, &mut closest);
    (closest.hit, closest.work)
}

/// The first hit found, as [`Primitive::intersect_p`] finds it, and the work of finding it.
pub fn intersect_p_counted<P: Primitive + ?Sized>(
    primitive: &P,
    ray: &TraversalRay,
    interval: Interval,
) -> (Option<Hit>, Work) {
    let mut first = Counting { hit: None, work: Work::default(), t_max: interval.t_max(), stops: true };
    let _ = primitive.visit_hits(ray, interval, HitKind::Material, &mut first);
    (first.hit, first.work)
}

struct Counting {
    hit: Option<Hit>,
    work: Work,
    t_max: f32,
    stops: bool,
}

impl HitVisitor for Counting {
    fn hit(&mut self, hit: Hit) -> Visit {
        if self.hit.as_ref().is_none_or(|best| hit.is_before(best)) {
            self.t_max = hit.t_max_for_ties();
            self.hit = Some(hit);
        }
        if self.stops { ControlFlow::Break(()) } else { ControlFlow::Continue(self.t_max) }
    }

    fn work(&mut self, work: Work) {
        self.work += work;
    }
}
