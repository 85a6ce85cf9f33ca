//! How sets of cells are divided.

use geometry::Axis;

use crate::parallel::join;
use crate::prim_info::Bounds3A;
use crate::recursive::Rules;
use crate::split::sah::Buckets;
use crate::subtree::Subtree;

/// The most cells along an axis; a power of two.
pub(super) const MAX_SIDE: usize = 64;

/// Sets of fewer primitives are not worth it.
pub(crate) const LEAST_DIVIDED: usize = 1 << 9;

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
pub(super) enum Division {
    /// Not any further.
    Region(Region),
    /// Along an axis.
    Parts(Axis, Box<[Division; 2]>),
}

/// A set that is not divided by cells.
#[derive(Clone, Copy)]
pub(super) struct Region {
    pub(super) cell_count: usize,
    /// How many primitives it has.
    pub(super) count: usize,
    pub(super) depth: u32,
}

impl Division {
    /// Divides `cells`, which become a node at `depth`, and puts them in the order of the regions.
    pub(super) fn of(cells: &mut [Cell], depth: u32, rules: &Rules) -> Self {
        /// With two parts of more cells, a second thread is worth waking.
        const SEQUENTIAL: usize = 1 << 10;
        let count = cells.iter().map(|cell| cell.count as usize).sum();
        let Some((axis, middle)) = boundary(cells, count, depth, rules) else {
            return Self::Region(Region { cell_count: cells.len(), count, depth });
        };
        let mut first = 0;
        for i in 0..cells.len() {
            if cells[i].place[axis.index()] < middle {
                cells.swap(i, first);
                first += 1;
            }
        }
        let (a, b) = cells.split_at_mut(first);
        let (a, b) = if a.len().min(b.len()) > SEQUENTIAL {
            join(|| Self::of(a, depth + 1, rules), || Self::of(b, depth + 1, rules))
        } else {
            (Self::of(a, depth + 1, rules), Self::of(b, depth + 1, rules))
        };
        Self::Parts(axis, Box::new([a, b]))
    }

    /// Appends all regions, in order.
    pub(super) fn append_regions(&self, regions: &mut Vec<Region>) {
        match self {
            Self::Region(region) => regions.push(*region),
            Self::Parts(_, parts) => parts.iter().for_each(|part| part.append_regions(regions)),
        }
    }

    /// The tree over the subtrees of all regions.
    pub(super) fn assemble(self, subtrees: &mut impl Iterator<Item = Subtree>) -> Subtree {
        match self {
            Self::Region(_) => subtrees.next().unwrap_or_default(),
            Self::Parts(axis, parts) => {
                let [a, b] = *parts;
                let a = a.assemble(subtrees);
                Subtree::interior(axis, a, b.assemble(subtrees))
            }
        }
    }
}

/// The boundary between cells where the heuristic divides: the axis, and the first cell behind it. `None` where the
/// set has few primitives, or spans few cells.
#[inline(never)] // Its arrays are large.
fn boundary(cells: &[Cell], count: usize, depth: u32, rules: &Rules) -> Option<(Axis, u8)> {
    let Rules { config, limit, .. } = rules;
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
