//! Several levels at once: primitives are gathered in the cells of a grid, and the cells are divided instead of them.
//!
//! Of a set that spans many cells the boundaries between cells are as good as those between buckets. So all levels down
//! to sets that span few take two passes over the primitives, one to gather them and one to move them, instead of two
//! for each level.

mod division;

use std::ops::Range;

use super::Group;
use crate::parallel;
use crate::prim_info::{Bounds3A, Extent, PrimInfo};
use crate::recursive::Rules;
use crate::split::sah::Grid;
use crate::subtree::Subtree;
use crate::{Cancelled, ProgressReporter};
pub(crate) use division::LEAST_DIVIDED;
use division::{Cell, Division, MAX_SIDE, Region};

/// Sets of fewer primitives are not worth it.
pub(super) const LEAST: usize = 1 << 11;

/// A grid of as many cells along each axis over the centroids of a set.
///
/// Rejected: cubic cells. Architecture has its short axis divided too coarsely then: the trees of sponza and kitchen
/// cost 1.07 and 1.09 of these.
struct CellGrid {
    grid: Grid,
    side: usize,
}

impl CellGrid {
    /// For `count` primitives: no more cells, most of which are empty.
    fn new(extent: &Extent, count: usize) -> Self {
        let fits = |side: &usize| side.pow(3) <= count;
        let side = (1..=MAX_SIDE).rev().find(fits).unwrap_or(1);
        Self { grid: Grid::new(extent, side as u32), side }
    }

    fn cell_count(&self) -> usize {
        self.side.pow(3)
    }

    #[inline(always)]
    fn cell(&self, p: &PrimInfo) -> usize {
        let [x, y, z] = self.grid.buckets::<MAX_SIDE>(p.centroid2());
        x + self.side * (y + self.side * z)
    }

    fn place(&self, cell: usize) -> [u8; 3] {
        [cell % self.side, cell / self.side % self.side, cell / self.side.pow(2)].map(|place| place as u8)
    }
}

/// What is in each cell of a grid.
struct Cells {
    counts: Vec<u32>,
    bounds: Vec<Bounds3A>,
}

impl Cells {
    /// Those of `prims`, of which each one's cell is written to `cells`.
    fn of(
        prims: &[PrimInfo],
        cells: &mut [u32],
        grid: &CellGrid,
        progress: &ProgressReporter,
    ) -> Result<Self, Cancelled> {
        let mut all = Self { counts: vec![0; grid.cell_count()], bounds: vec![Bounds3A::EMPTY; grid.cell_count()] };
        for (prims, cells) in prims.chunks(parallel::SEQUENTIAL).zip(cells.chunks_mut(parallel::SEQUENTIAL)) {
            progress.check()?;
            for (p, to) in prims.iter().zip(cells) {
                let cell = grid.cell(p);
                *to = cell as u32;
                all.counts[cell] += 1;
                all.bounds[cell] = all.bounds[cell].union(&p.bounds());
            }
        }
        Ok(all)
    }
}

/// How a group is divided, and all regions in order.
pub(super) struct Divided {
    division: Division,
    regions: Vec<Region>,
}

/// Divides the primitives of `group`, a node at `depth`, and moves them accordingly. `None`, and nothing has changed,
/// where more than half of all would be in one region: the passes are not worth it, and regions in regions take up the
/// stack. Requires that the centroids are not all one point.
pub(super) fn divide(group: &mut Group, depth: u32) -> Result<Option<Divided>, Cancelled> {
    let Group { prims, other, rules, .. } = group;
    let Rules { progress, .. } = rules;
    let grid = CellGrid::new(&group.extent, prims.len());
    let mut cell_of = vec![0; prims.len()];
    let part = prims.len().div_ceil(parallel::threads()).max(LEAST_DIVIDED);
    let parts: Vec<_> = prims.chunks(part).zip(cell_of.chunks_mut(part)).collect();
    let parts = parallel::map(parts, |(prims, cells)| Cells::of(prims, cells, &grid, progress))?;
    let mut cells = all_cells(&parts, &grid)?;
    let division = Division::of(&mut cells, depth, rules);
    let mut regions = Vec::new();
    division.append_regions(&mut regions);
    if regions.iter().any(|region| 2 * region.count > prims.len()) {
        return Ok(None);
    }
    let mut region_of = vec![0; grid.cell_count()];
    let mut rest = &cells[..];
    for (number, region) in (0..).zip(&regions) {
        let (own, behind) = rest.split_at(region.cell_count);
        own.iter().for_each(|cell| region_of[cell.number as usize] = number);
        rest = behind;
    }
    // Each part has room in each region, behind that of the part before.
    let counts = parallel::map(parts, |part| Ok(counts_in(&part, &region_of, regions.len())))?;
    let mut rooms: Vec<Vec<&mut [PrimInfo]>> = counts.iter().map(|_| Vec::with_capacity(regions.len())).collect();
    let mut rest = &mut **other;
    for region in 0..regions.len() {
        for (rooms, counts) in rooms.iter_mut().zip(&counts) {
            let (room, behind) = rest.split_at_mut(counts[region]);
            rooms.push(room);
            rest = behind;
        }
    }
    let work: Vec<_> = prims.chunks(part).zip(cell_of.chunks(part)).zip(rooms).collect();
    parallel::map(work, |((prims, cells), mut rooms)| {
        let mut next = vec![0; rooms.len()];
        for (prims, cells) in prims.chunks(parallel::SEQUENTIAL).zip(cells.chunks(parallel::SEQUENTIAL)) {
            progress.check()?;
            for (p, &cell) in prims.iter().zip(cells) {
                let region = region_of[cell as usize] as usize;
                rooms[region][next[region]] = *p;
                next[region] += 1;
            }
        }
        Ok(())
    })?;
    std::mem::swap(prims, other);
    Ok(Some(Divided { division, regions }))
}

/// How many primitives are in each of so many regions, of the cells of a part.
fn counts_in(part: &Cells, region_of: &[u32], region_count: usize) -> Vec<usize> {
    let mut counts = vec![0; region_count];
    for (&region, &count) in region_of.iter().zip(&part.counts) {
        counts[region as usize] += count as usize;
    }
    counts
}

/// The cells with primitives in any of `parts`.
fn all_cells(parts: &[Cells], grid: &CellGrid) -> Result<Vec<Cell>, Cancelled> {
    let cell = |number: usize| {
        let count = parts.iter().map(|part| part.counts[number]).sum();
        let bounds = || parts.iter().fold(Bounds3A::EMPTY, |all, part| all.union(&part.bounds[number]));
        (count > 0).then(|| Cell { bounds: bounds(), count, number: number as u32, place: grid.place(number) })
    };
    let (count, block) = (grid.cell_count(), parallel::SEQUENTIAL);
    let blocks = (0..count).step_by(block).map(|begin| begin..count.min(begin + block)).collect();
    let cells = parallel::map(blocks, |numbers: Range<usize>| Ok(numbers.filter_map(cell).collect::<Vec<_>>()))?;
    Ok(cells.concat())
}

/// The subtree of a group that is divided already.
pub(super) fn grow(group: Group, Divided { division, regions }: Divided) -> Result<Subtree, Cancelled> {
    let Group { prims, other, rules, .. } = group;
    let mut rest = (prims, other);
    let groups = regions.into_iter().map(|Region { count, depth, .. }| {
        let (prims, other) = std::mem::take(&mut rest);
        let ((prims, behind), (other, other_behind)) = (prims.split_at_mut(count), other.split_at_mut(count));
        rest = (behind, other_behind);
        (Group { prims, other, extent: Extent::EMPTY, rules }, depth)
    });
    let subtrees = parallel::map(groups.collect(), |(group, depth)| {
        let extent = Extent::of_many(group.prims, rules.progress)?;
        Subtree::grow(Group { extent, ..group }, depth, rules)
    })?;
    Ok(division.assemble(&mut subtrees.into_iter()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::MAX_DEPTH;
    use crate::{BuildConfig, ProgressReporter};
    use geometry::Bounds3;
    use geometry::glam::Vec3;

    /// Boxes on a surface, where `size` is a power of what their places are: the larger it is, the closer they crowd.
    fn boxes(count: u32, size: i32) -> Vec<PrimInfo> {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        let place = |x: f32| x.powi(size);
        (0..count)
            .map(|i| {
                let (x, y) = (random(), random());
                let min = Vec3::new(place(x), place(y), place(x * y));
                PrimInfo::new(&Bounds3::new(min, min + Vec3::splat(0.01 * random())), i)
            })
            .collect()
    }

    /// The division of `prims`, with the primitives as it left them, and how many each region has.
    fn divided(prims: &[PrimInfo], threads: usize) -> Option<(Vec<PrimInfo>, Vec<usize>)> {
        let work = || {
            let (mut prims, mut other) = (prims.to_vec(), prims.to_vec());
            let (config, progress) = (BuildConfig::balanced(), ProgressReporter::unobserved());
            let rules = Rules::new(&config, MAX_DEPTH, &progress);
            let extent = Extent::of(&prims);
            let mut group = Group { prims: &mut prims, other: &mut other, extent, rules: &rules };
            let Divided { regions, .. } = divide(&mut group, 1).expect("nobody cancels")?;
            Some((group.prims.to_vec(), regions.into_iter().map(|region| region.count).collect()))
        };
        #[cfg(feature = "parallel")]
        return rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can start").install(work);
        #[cfg(not(feature = "parallel"))]
        return {
            let _ = threads;
            work()
        };
    }

    #[test]
    fn regions_have_all_primitives_and_are_the_same_for_all_threads() {
        let prims = boxes(30_000, 1);
        let (one, regions) = divided(&prims, 1).expect("evenly spread");
        assert!(regions.len() > 20, "{regions:?}");
        assert_eq!(regions.iter().sum::<usize>(), prims.len());
        assert!(regions.iter().all(|&count| count > 0));
        let sorted = |prims: &[PrimInfo]| {
            let mut indices: Vec<u32> = prims.iter().map(|p| p.index()).collect();
            indices.sort_unstable();
            indices
        };
        assert_eq!(sorted(&one), (0..30_000).collect::<Vec<_>>());
        let (two, other_regions) = divided(&prims, 2).expect("evenly spread");
        assert_eq!(regions, other_regions);
        let mut begin = 0;
        for count in regions {
            let region = begin..begin + count;
            assert_eq!(sorted(&one[region.clone()]), sorted(&two[region]));
            begin += count;
        }
    }

    #[test]
    fn a_crowd_in_one_cell_is_left_alone() {
        assert!(divided(&boxes(30_000, 40), 1).is_none());
    }
}
