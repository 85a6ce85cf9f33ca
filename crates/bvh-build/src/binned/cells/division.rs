//! How sets of cells are divided.

use geometry::Axis;

use crate::prim_info::Bounds3A;
use crate::recursive::Rules;
use crate::split::sah::Buckets;
use crate::subtree::Subtree;

/// The most cells along an axis; a power of two.
pub(super) const MAX_SIDE: usize = 64;

/// Sets of fewer primitives are not worth it.
pub(super) const LEAST_DIVIDED: usize = 1 << 9;

/// A cell with primitives.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) bounds: Bounds3A,
    pub(super) count: u32,
    pub(super) number: u32,
    /// Below [`MAX_SIDE`].
    pub(super) place: [u8; 3],
}

/// How a set is divided by cells.
pub(in crate::binned) enum Division {
    /// Not any further.
    Region,
    /// Along an axis; so many primitives are in the first part.
    Parts(Axis, usize, Box<[Division; 2]>),
}

impl Division {
    /// Appends the regions of a set of `count` primitives at `depth`: of each its primitives and its depth.
    pub(super) fn regions(&self, depth: u32, count: usize, regions: &mut Vec<(usize, u32)>) {
        match self {
            Self::Region => regions.push((count, depth)),
            Self::Parts(_, middle, parts) => {
                parts[0].regions(depth + 1, *middle, regions);
                parts[1].regions(depth + 1, count - middle, regions);
            }
        }
    }

    /// The tree over the subtrees of all regions.
    pub(super) fn assemble(self, subtrees: &mut impl Iterator<Item = Subtree>) -> Subtree {
        match self {
            Self::Region => subtrees.next().unwrap_or_default(),
            Self::Parts(axis, _, parts) => {
                let [a, b] = *parts;
                let a = a.assemble(subtrees);
                Subtree::interior(axis, a, b.assemble(subtrees))
            }
        }
    }
}

/// Divides sets of cells.
pub(super) struct Divider<'a> {
    pub(super) rules: &'a Rules<'a>,
    /// The region that each cell is in.
    pub(super) region_of: Vec<u32>,
    /// How many primitives each region has.
    pub(super) regions: Vec<usize>,
}

impl Divider<'_> {
    /// The division of `cells`, which become a node at `depth`.
    pub(super) fn divide(&mut self, cells: &mut [Cell], depth: u32) -> Division {
        let count = cells.iter().map(|cell| cell.count as usize).sum();
        let Some((axis, middle)) = self.boundary(cells, count, depth) else {
            for cell in cells {
                self.region_of[cell.number as usize] = self.regions.len() as u32;
            }
            self.regions.push(count);
            return Division::Region;
        };
        let mut first = 0;
        for i in 0..cells.len() {
            if cells[i].place[axis.index()] < middle {
                cells.swap(i, first);
                first += 1;
            }
        }
        let (a, b) = cells.split_at_mut(first);
        let in_first = a.iter().map(|cell| cell.count as usize).sum();
        let parts = [self.divide(a, depth + 1), self.divide(b, depth + 1)];
        Division::Parts(axis, in_first, Box::new(parts))
    }

    /// The boundary between cells where the heuristic divides: the axis, and the first cell behind it. `None` where the
    /// set has few primitives, or spans few cells.
    #[inline(never)] // Its arrays are large.
    fn boundary(&self, cells: &[Cell], count: usize, depth: u32) -> Option<(Axis, u8)> {
        let Rules { config, limit, .. } = self.rules;
        let mut low = [u8::MAX; 3];
        let mut high = [0; 3];
        let mut bounds = Bounds3A::EMPTY;
        for cell in cells {
            bounds = bounds.union(&cell.bounds);
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(cell.place[axis]), high[axis].max(cell.place[axis]));
            }
        }
        let span = (0..3).map(|axis| usize::from(high[axis] - low[axis]) + 1).max()?;
        let is_divided = count >= LEAST_DIVIDED
            && count > config.max_primitives_in_leaf as usize
            && span >= (3 * config.buckets as usize / 16).max(2)
            && limit.allows_any_split(depth, count)
            && bounds.surface_area() > 0.0;
        if !is_divided {
            return None;
        }
        let mut buckets = Buckets::<MAX_SIDE>::EMPTY;
        for cell in cells {
            let at = [0, 1, 2].map(|axis| usize::from(cell.place[axis] - low[axis]));
            buckets.add_many(at, cell.count, &cell.bounds);
        }
        let (axis, boundary) = buckets.cheapest_boundary(span, &bounds);
        (boundary.weight < f64::INFINITY).then(|| (axis, low[axis.index()] + boundary.place as u8))
    }
}
