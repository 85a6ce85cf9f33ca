//! Makes the sums of a cache file right again after something was changed in it: by FORMAT.md, not by the library's own
//! code.

use xxhash_rust::xxh3::xxh3_128;

const HEADER: usize = 512;
const PIECE: usize = 1 << 20;
const OPTIONS_KEY: usize = 88;
const SECTIONS: [usize; 2] = [184, 216];
const DESCRIPTION: usize = 256;

/// The u64 at `at`; 0 beyond the end.
fn read(file: &[u8], at: usize) -> u64 {
    file.get(at..at + 8).and_then(|bytes| bytes.try_into().ok()).map_or(0, u64::from_le_bytes)
}

/// The sum of a section.
fn sum_of_pieces(bytes: &[u8]) -> u128 {
    let sums: Vec<u8> = bytes.chunks(PIECE).flat_map(|piece| xxh3_128(piece).to_le_bytes()).collect();
    xxh3_128(&sums)
}

/// Makes right the sums of the sections where those are inside of the file, the options key, and the sum of the header;
/// what is shorter than a header has none.
pub fn reseal(file: &mut [u8]) {
    if file.len() < HEADER {
        return;
    }
    for at in SECTIONS {
        let (offset, length) = (read(file, at), read(file, at + 8));
        let section = (offset as usize)..(offset as usize).saturating_add(length as usize);
        if let Some(section) = file.get(section)
            && length > 0
        {
            let sum = sum_of_pieces(section).to_le_bytes();
            file[at + 16..at + 32].copy_from_slice(&sum);
        }
    }
    let length = (read(file, 248) as usize).min(HEADER - DESCRIPTION);
    let key = xxh3_128(&[&file[64..68], &file[DESCRIPTION..DESCRIPTION + length]].concat());
    file[OPTIONS_KEY..OPTIONS_KEY + 16].copy_from_slice(&key.to_le_bytes());
    let sum = xxh3_128(&[&file[..16], &file[32..HEADER]].concat());
    file[16..32].copy_from_slice(&sum.to_le_bytes());
}

/// The file with each count, offset and length of its header in turn beyond all memory, and the sums right.
pub fn files_with_huge_counts(file: &[u8]) -> Vec<Vec<u8>> {
    let fields = [32, 104, 112, 120, 128, 136, 184, 192, 216, 224, 248].map(|at| (at, 8)).into_iter();
    let fields = fields.chain([40, 144, 148].map(|at| (at, 4)));
    let values = [u64::from(u32::MAX), 1 << 63, u64::MAX, u64::MAX - 511, 1 << 40];
    let mut files = Vec::new();
    for ((at, size), value) in fields.flat_map(|field| values.map(|value| (field, value))) {
        let mut file = file.to_vec();
        file[at..at + size].copy_from_slice(&value.to_le_bytes()[..size]);
        if file[at..at + size].iter().all(|&byte| byte == 0) {
            continue;
        }
        reseal(&mut file);
        files.push(file);
    }
    // All of them at once, as they would belong together.
    for count in [u64::from(u32::MAX), 1 << 63] {
        let mut file = file.to_vec();
        for at in [32, 104, 112, 128, 136, 192] {
            file[at..at + 8].copy_from_slice(&count.to_le_bytes());
        }
        file[192..200].copy_from_slice(&(count / 64 * 64).to_le_bytes());
        file[32..40].copy_from_slice(&(512 + count / 64 * 64).to_le_bytes());
        reseal(&mut file);
        files.push(file);
    }
    files
}
