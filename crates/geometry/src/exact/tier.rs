//! Who decided.

/// The tier that took a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Tier {
    /// f64, against the error bound of the ray.
    Filter,
    /// f64, against the error bound of the triangle.
    Certificate,
    /// Exact integers.
    Exact,
}

/// Is told who decided, once for every test of a triangle, every comparison of two hits, and every rounding of values.
/// `()` is told and does nothing, which costs nothing.
pub trait TierObserver {
    /// Takes note.
    fn decided(&mut self, tier: Tier);
}

impl TierObserver for () {
    #[inline]
    fn decided(&mut self, _: Tier) {}
}

/// How many decisions each tier took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TierCounts {
    /// By [`Tier::Filter`].
    pub filter: u64,
    /// By [`Tier::Certificate`].
    pub certificate: u64,
    /// By [`Tier::Exact`].
    pub exact: u64,
}

impl TierObserver for TierCounts {
    fn decided(&mut self, tier: Tier) {
        match tier {
            Tier::Filter => self.filter += 1,
            Tier::Certificate => self.certificate += 1,
            Tier::Exact => self.exact += 1,
        }
    }
}
