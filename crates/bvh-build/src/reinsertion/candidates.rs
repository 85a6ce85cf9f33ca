//! Which subtrees are worth a search.

use std::cmp::Reverse;
use std::ops::Range;

use super::topology::{ROOT, Topology};
use crate::{Cancelled, ProgressReporter, parallel};

/// Small trees are examined as a whole.
pub(super) const LEAST: usize = 64;

/// How many slots one thread rates at a time.
const CHUNK: usize = 1 << 14;

/// The slots of the subtrees that could gain most from a move, `fraction` of all nodes or [`LEAST`]; the best first, of
/// equals the first in the order of slots. Fewer where others could gain nothing.
pub(super) fn choose(topology: &Topology, fraction: f32, progress: &ProgressReporter) -> Result<Vec<u32>, Cancelled> {
    let root_area = topology.bounds(ROOT).surface_area();
    let end = topology.slot_count();
    let chunks = (0..end.div_ceil(CHUNK)).map(|i| i * CHUNK..end.min((i + 1) * CHUNK)).collect();
    let mut keys = parallel::map(chunks, |slots: Range<usize>| {
        progress.check()?;
        // The first pair is the root with nothing beside it.
        let slots = slots.filter(|&slot| slot > 1).map(|slot| slot as u32);
        let rated = slots.map(|slot| (most_gain(topology, slot), slot));
        // Positive numbers compare as their bits do; the slot goes with them.
        let key = |(gain, slot): (f64, u32)| {
            Reverse(u64::from(((gain / root_area) as f32).to_bits()) << 32 | u64::from(!slot))
        };
        Ok(rated.filter(|&(gain, _)| gain > 0.0).map(key).collect::<Vec<_>>())
    })?
    .concat();
    let count = most(end, fraction);
    if count < keys.len() {
        keys.select_nth_unstable(count);
        keys.truncate(count);
    }
    keys.sort_unstable();
    Ok(keys.into_iter().map(|Reverse(key)| !(key as u32)).collect())
}

/// How many candidates are chosen at most, of so many slots.
pub(super) fn most(slot_count: usize, fraction: f32) -> usize {
    ((f64::from(fraction) * slot_count as f64) as usize).max(LEAST)
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
