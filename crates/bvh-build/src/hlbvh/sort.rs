//! Sorting by code: radix sort from the highest bits, in parallel, and from the lowest ones where few are left.
//!
//! With radsort for all codes at once, one thread took 29 ms for dragon's 870 000 of 30 bits and 73 ms for kitchen's
//! 1.4 million of 63, the primitives' own moves included; this took 9 and 32 ms, and 7 and 10 more for the moves, by
//! treelets, on the same machine.

use std::mem::take;

use super::coded::Coded;
use crate::room::Room;
use crate::{Cancelled, ProgressReporter, parallel};

/// Up to so many are sorted by one thread, from the lowest bits.
const SEQUENTIAL: usize = 1 << 13;

/// Up to so many are sorted by comparing.
const FEW: usize = 64;

/// How many bits are a digit of the sort from the highest bits.
const DIGIT_BITS: u32 = 11;

/// Sorts by code; of equal codes the smaller number, which must come first already, stays first.
pub(super) fn sort<C: Coded>(coded: &mut [C], progress: &ProgressReporter) -> Result<(), Cancelled> {
    if coded.len() <= SEQUENTIAL {
        sort_few(coded);
        return progress.update(coded.len());
    }
    let first = coded[0].code();
    let differing = parallel::fold(coded, progress, &|part| differing(part, first), &|a, b| a | b)?;
    let Some(bits) = bit_count(differing) else { return progress.update(coded.len()) };
    let shift = bits.saturating_sub(DIGIT_BITS);
    let digit = |c: C| (c.code() >> shift) as usize & ((1 << DIGIT_BITS) - 1);
    let mut sorted = Room::zeroed(coded.len());
    let ends = distribute(coded, &mut sorted, digit, progress)?;
    let (mut parts, mut rest) = (Vec::new(), (coded, &mut *sorted));
    let mut begin = 0;
    for end in ends {
        let (a, behind_a) = take(&mut rest.0).split_at_mut(end - begin);
        let (b, behind_b) = take(&mut rest.1).split_at_mut(end - begin);
        (begin, rest) = (end, (behind_a, behind_b));
        if !a.is_empty() {
            parts.push((a, b));
        }
    }
    parallel::map(parts, |(to, from)| {
        to.copy_from_slice(from);
        if shift > 0 { sort(to, progress) } else { progress.update(to.len()) }
    })?;
    Ok(())
}

/// The same by one thread: by the highest of the bits that differ, and then each run of those that agree in these. (All
/// bits at once took kitchen's sort of 63 bits 1.1 times as long.)
fn sort_few<C: Coded>(coded: &mut [C]) {
    if coded.len() <= FEW {
        return coded.sort_unstable();
    }
    let Some(bits) = bit_count(differing(coded, coded[0].code())) else { return };
    // Each digit of 8 bits is a pass. Three are as fast as two and what is left to do after them.
    if bits <= 24 {
        return radsort::sort_by_key(coded, |c| c.code() as u32);
    }
    let low_bits = bits - u16::BITS;
    radsort::sort_by_key(coded, |c| (c.code() >> low_bits) as u16);
    let runs = coded.chunk_by_mut(|a, b| a.code() >> low_bits == b.code() >> low_bits);
    runs.filter(|run| run.len() > 1).for_each(sort_few);
}

/// The bits in which any code differs from `code`.
fn differing<C: Coded>(coded: &[C], code: u64) -> u64 {
    coded.iter().fold(0, |all, c| all | (c.code() ^ code))
}

/// How many of the lowest bits have all that are set; `None` where none is.
fn bit_count(bits: u64) -> Option<u32> {
    bits.checked_ilog2().map(|bit| bit + 1)
}

/// Writes `coded` to `sorted` by digits, of equal ones in the order in which they are; where each digit's end.
fn distribute<C: Coded>(
    coded: &[C],
    sorted: &mut [C],
    digit: impl Fn(C) -> usize + Sync,
    progress: &ProgressReporter,
) -> Result<Vec<usize>, Cancelled> {
    // Each thread has a chunk, and in the run of each digit the place behind that of the chunk before.
    let chunks: Vec<&[C]> = coded.chunks(coded.len().div_ceil(parallel::threads()).max(SEQUENTIAL)).collect();
    let counts = parallel::map(chunks.clone(), |chunk| {
        let mut counts = vec![0_usize; 1 << DIGIT_BITS];
        for part in chunk.chunks(SEQUENTIAL) {
            progress.check()?;
            part.iter().for_each(|&c| counts[digit(c)] += 1);
        }
        Ok(counts)
    })?;
    let mut rooms: Vec<Vec<&mut [C]>> = chunks.iter().map(|_| Vec::with_capacity(1 << DIGIT_BITS)).collect();
    let mut ends = Vec::with_capacity(1 << DIGIT_BITS);
    let (mut rest, mut end) = (sorted, 0);
    for digit in 0..1 << DIGIT_BITS {
        for (rooms, counts) in rooms.iter_mut().zip(&counts) {
            let (room, behind) = rest.split_at_mut(counts[digit]);
            rooms.push(room);
            (rest, end) = (behind, end + counts[digit]);
        }
        ends.push(end);
    }
    parallel::map(chunks.into_iter().zip(rooms).collect(), |(chunk, mut rooms)| {
        for part in chunk.chunks(SEQUENTIAL) {
            progress.check()?;
            for &c in part {
                if let Some((first, behind)) = take(&mut rooms[digit(c)]).split_first_mut() {
                    *first = c;
                    rooms[digit(c)] = behind;
                }
            }
        }
        Ok(())
    })?;
    Ok(ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hlbvh::coded::Packed;

    fn check<C: Coded>(n: u32, mask: u64) {
        let mut state = 7_u64;
        let coded: Vec<C> = (0..n)
            .map(|number| {
                state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
                C::new((state >> 20 ^ state) & mask, number)
            })
            .collect();
        let (mut sorted, mut naive) = (coded.clone(), coded);
        sort(&mut sorted, &ProgressReporter::unobserved()).expect("nobody cancels");
        naive.sort_by_key(|c| (c.code(), c.number()));
        assert!(sorted == naive, "{n} {mask:x}");
    }

    #[test]
    fn the_sort_is_the_stable_one() {
        // One cell far from the others, as large scenes of small detail have: the highest bits say nothing.
        let masks = [0, 1, 7, 0x7ff, 0x3fff_ffff, 0x2000_00ff];
        for n in [0, 1, 2, 63, 64, 65, 1000, 5000, 8192, 8193, 100_000] {
            for mask in masks {
                check::<Packed<32>>(n, mask);
                check::<Packed<22>>(n, mask << 12 | 3);
                check::<u128>(n, mask);
            }
            check::<u128>(n, u64::MAX >> 1);
            check::<u128>(n, 1 << 62 | 0xffff);
            check::<u128>(n, 1 << 62 | 0x3fff_ffff);
        }
    }
}
