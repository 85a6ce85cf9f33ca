//! Which subtrees are worth a search.

use std::ops::Range;

use super::topology::{ROOT, Topology};
use crate::{Cancelled, ProgressReporter, parallel};

/// Small trees are examined as a whole.
pub(super) const LEAST: usize = 64;

/// How many slots one thread rates at a time.
const CHUNK: usize = 1 << 14;

/// The slots of the subtrees that could gain most from a move, together about `share` of what all could, and [`LEAST`]
/// in any case; the best first, of equals the first in the order of slots. Fewer where others could gain nothing.
pub(super) fn choose(topology: &Topology, share: f32, progress: &ProgressReporter) -> Result<Vec<u32>, Cancelled> {
    let root_area = topology.bounds(ROOT).surface_area();
    let end = topology.slot_count();
    let chunks = (0..end.div_ceil(CHUNK)).map(|i| i * CHUNK..end.min((i + 1) * CHUNK)).collect();
    let rated = parallel::map(chunks, |slots: Range<usize>| {
        progress.check()?;
        // The first pair is the root with nothing beside it.
        let slots = slots.filter(|&slot| slot > 1).map(|slot| slot as u32);
        let rated = slots.map(|slot| Rated { gain: (most_gain(topology, slot) / root_area) as f32, slot });
        Ok(rated.filter(|rated| rated.gain > 0.0).collect::<Vec<_>>())
    })?;
    progress.check()?;
    let least = least_bin(&rated, share);
    let chosen = rated.iter().flatten().filter(|rated| rated.bin() >= least);
    let mut chosen: Vec<Rated> = chosen.copied().collect();
    chosen.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.slot.cmp(&b.slot)));
    Ok(chosen.into_iter().map(|rated| rated.slot).collect())
}

/// A slot, and the most that moving what is there could gain, as a part of the root's area; more than 0.
#[derive(Clone, Copy)]
struct Rated {
    gain: f32,
    slot: u32,
}

impl Rated {
    /// How many bins there are for gains.
    const BINS: usize = 1 << 11;

    /// The bin of the gain: the higher, the more. Eight for each power of two.
    fn bin(&self) -> usize {
        (self.gain.to_bits() >> 20) as usize
    }
}

/// The lowest bin that must be taken for `share` of all gains, and [`LEAST`] of them.
fn least_bin(rated: &[Vec<Rated>], share: f32) -> usize {
    if share >= 1.0 {
        return 0; // However sums are rounded.
    }
    let mut bins = vec![(0.0, 0); Rated::BINS];
    for rated in rated.iter().flatten() {
        let (gain, count) = &mut bins[rated.bin()];
        *gain += f64::from(rated.gain);
        *count += 1;
    }
    let all: f64 = bins.iter().map(|(gain, _)| gain).sum();
    let (mut gain, mut count) = (0.0, 0);
    for (bin, (gain_here, count_here)) in bins.iter().enumerate().rev() {
        (gain, count) = (gain + gain_here, count + count_here);
        if gain >= f64::from(share) * all && count >= LEAST {
            return bin;
        }
    }
    0
}

/// No move of the subtree at `slot` gains more: it saves what its parent has, and what those above shrink by, and costs
/// the area of a new parent, which is no less than its own.
pub(super) fn most_gain(topology: &Topology, slot: u32) -> f64 {
    let mut above = topology.parent(slot);
    let mut shrunk = topology.bounds(slot ^ 1);
    let mut saved = topology.bounds(above).surface_area();
    while above != ROOT {
        shrunk = shrunk.union(&topology.bounds(above ^ 1));
        above = topology.parent(above);
        let bounds = topology.bounds(above);
        // Those above shrink no more either.
        if bounds == shrunk {
            break;
        }
        saved += bounds.surface_area() - shrunk.surface_area();
    }
    saved - topology.bounds(slot).surface_area()
}
