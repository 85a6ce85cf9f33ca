//! The three coordinate axes.

/// A coordinate axis. Indexes vectors: `point[axis.index()]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Axis {
    /// The first axis.
    X = 0,
    /// The second axis.
    Y = 1,
    /// The third axis.
    Z = 2,
}

impl Axis {
    /// All axes in order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// 0, 1 or 2.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The axis after this one, cyclically.
    #[must_use]
    pub const fn next(self) -> Axis {
        match self {
            Axis::X => Axis::Y,
            Axis::Y => Axis::Z,
            Axis::Z => Axis::X,
        }
    }
}
