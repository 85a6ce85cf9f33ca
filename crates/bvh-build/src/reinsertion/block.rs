//! Blocks of candidates: searched in parallel, moved in turn.

use super::moves;
use super::search::{Move, best_place};
use super::topology::{ROOT, Topology};
use crate::{Cancelled, ProgressReporter, parallel};

/// How many candidates make the next block, after so many: few while each may be in the others' way, then ever more.
pub(super) fn size(examined: usize) -> usize {
    (examined / 16).clamp(32, 1 << 14)
}

/// A tree that is being improved.
pub(super) struct Mover {
    topology: Topology,
    /// Less than this is rounding.
    least_gain: f64,
    moved: u64,
    saved: f64,
    /// For each slot, whether its contents changed since the searches.
    is_stale: Vec<bool>,
    /// All slots for which it is so.
    stale: Vec<u32>,
}

impl Mover {
    pub(super) fn new(topology: Topology) -> Self {
        let least_gain = topology.bounds(ROOT).surface_area() * 2_f64.powi(-40);
        let is_stale = vec![false; topology.slot_count()];
        Self { topology, least_gain, moved: 0, saved: 0.0, is_stale, stale: Vec::new() }
    }

    pub(super) fn topology(&self) -> &Topology {
        &self.topology
    }

    /// How many subtrees have been moved.
    pub(super) fn moved(&self) -> u64 {
        self.moved
    }

    /// By how much the interior areas are less for that.
    pub(super) fn saved(&self) -> f64 {
        self.saved
    }

    /// Looks for a better place for each of `candidates`, and makes the moves that gain, the best first.
    pub(super) fn improve(&mut self, candidates: &[u32], progress: &ProgressReporter) -> Result<(), Cancelled> {
        let mut moves = self.search(candidates, progress)?;
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        for Move { from, to, .. } in moves {
            // What was found for these slots is of nodes that are elsewhere now.
            if self.is_stale[from as usize] || self.is_stale[to as usize] {
                continue;
            }
            if let Some(gain) = moves::gain(&self.topology, from, to)
                && gain > self.least_gain
            {
                let changed = [from ^ 1, self.topology.parent(from), to];
                changed.iter().for_each(|&slot| self.is_stale[slot as usize] = true);
                self.stale.extend(changed);
                self.topology.reinsert(from, to);
                self.moved += 1;
                self.saved += gain;
            }
        }
        self.stale.drain(..).for_each(|slot| self.is_stale[slot as usize] = false);
        Ok(())
    }

    fn search(&self, candidates: &[u32], progress: &ProgressReporter) -> Result<Vec<Move>, Cancelled> {
        const CHUNK: usize = 64;
        let search = |chunk: &[u32]| {
            let mut pending = Vec::new();
            let places =
                chunk.iter().filter_map(|&from| best_place(&self.topology, from, self.least_gain, &mut pending));
            let found = places.collect::<Vec<_>>();
            progress.update(chunk.len())?;
            Ok(found)
        };
        let chunks = candidates.chunks(CHUNK.min(candidates.len().div_ceil(2))).collect();
        Ok(parallel::map(chunks, search)?.concat())
    }
}
