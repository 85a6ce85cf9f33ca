//! The first 512 bytes: encoded, decoded, and looked through in the order of FORMAT.md. The only file that uses
//! bincode.

use geometry::{Bounds3, glam::Vec3};
use serde::{Deserialize, Serialize};

use super::checksum::sum;
use super::source::Source;
use super::{CacheError, GeometryKey, InvalidTree, Section, TreeLayout, TreeOptions};

/// Of the format as a whole.
pub(crate) const VERSION: u32 = 1;

/// Where the first section begins.
pub(crate) const HEADER_BYTES: usize = 512;

/// Sections begin at multiples of it.
pub(crate) const ALIGNMENT: u64 = 64;

const MAGIC: [u8; 8] = *b"\x89BVH\r\n\x1a\n";
const BYTE_ORDER: u32 = 0x0102_0304;
const FOREVER_BYTES: usize = 16;
const SUM_AT: usize = 16;
const FIELDS_AT: usize = 32;
const RECORD_AT: usize = 64;
const MAX_RECORD: usize = HEADER_BYTES - RECORD_AT;

/// The most bytes of a description of options: what the rest of a header leaves.
#[cfg(feature = "build")]
pub(crate) const MAX_DESCRIPTION: usize = HEADER_BYTES - 256;

/// What the header says of a tree; its sections are where they follow from it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    pub(crate) options: TreeOptions,
    pub(crate) geometry: GeometryKey,
    pub(crate) counts: Counts,
    pub(crate) bounds: Bounds3,
    pub(crate) expected_steps: f64,
    pub(crate) sections: [SectionRecord; 2],
}

/// The numbers of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Counts {
    pub(crate) primitives: u64,
    pub(crate) references: u64,
    pub(crate) repeats: u64,
    pub(crate) nodes: u64,
    pub(crate) leaves: u64,
    pub(crate) depth: u32,
    pub(crate) root_leaf: u32,
}

impl Counts {
    /// An error where the tree has other counts than these.
    pub(crate) fn expect(&self, found: &Self) -> Result<(), InvalidTree> {
        let pairs = [
            ("primitives", self.primitives, found.primitives),
            ("references", self.references, found.references),
            ("repeats", self.repeats, found.repeats),
            ("nodes", self.nodes, found.nodes),
            ("leaves", self.leaves, found.leaves),
            ("levels", self.depth.into(), found.depth.into()),
            ("primitives in the root", self.root_leaf.into(), found.root_leaf.into()),
        ];
        match pairs.into_iter().find(|(_, recorded, found)| recorded != found) {
            Some((what, recorded, found)) => Err(InvalidTree::Recorded { what, recorded, found }),
            None => Ok(()),
        }
    }
}

/// Where a section is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SectionRecord {
    pub(crate) offset: u64,
    pub(crate) length: u64,
    pub(crate) sum: u128,
}

/// What bincode encodes: the fields as FORMAT.md has them.
#[derive(Serialize, Deserialize)]
struct Record {
    layout: u32,
    layout_version: u32,
    geometry_key: u128,
    options_key: u128,
    counts: Counts,
    bounds: [f32; 6],
    expected_steps: f64,
    sections: [SectionRecord; 2],
    description: String,
}

fn configuration() -> impl bincode::config::Config {
    bincode::config::standard().with_fixed_int_encoding().with_limit::<MAX_RECORD>()
}

impl SectionRecord {
    /// Where the next one begins.
    fn next(&self) -> Option<u64> {
        self.offset.checked_add(self.length)?.checked_next_multiple_of(ALIGNMENT)
    }
}

impl Header {
    /// Sections of such lengths and sums, one behind the other.
    pub(crate) fn lay_out(sections: &[(u64, u128)]) -> [SectionRecord; 2] {
        let mut offset = HEADER_BYTES as u64;
        let mut records = [SectionRecord::default(); 2];
        for (record, &(length, sum)) in records.iter_mut().zip(sections) {
            *record = SectionRecord { offset, length, sum };
            offset = (offset + length).next_multiple_of(ALIGNMENT);
        }
        records
    }

    /// The length of the file; `None` for sections that follow each other in no file.
    pub(crate) fn file_length(&self) -> Option<u64> {
        let [first, second] = &self.sections;
        match self.options.layout {
            TreeLayout::Binary => {
                (first.offset == HEADER_BYTES as u64 && Some(second.offset) == first.next()).then(|| second.next())?
            }
            TreeLayout::Wide(_) => {
                let is_alone = first.offset == HEADER_BYTES as u64 && *second == SectionRecord::default();
                is_alone.then(|| first.next())?
            }
        }
    }

    pub(crate) fn encode(&self) -> Result<[u8; HEADER_BYTES], CacheError> {
        let record = Record {
            layout: self.options.layout.code(),
            layout_version: self.options.layout.version(),
            geometry_key: self.geometry.0,
            options_key: self.options.key(),
            counts: self.counts,
            bounds: bytemuck::must_cast([self.bounds.min.to_array(), self.bounds.max.to_array()]),
            expected_steps: self.expected_steps,
            sections: self.sections,
            description: self.options.description.clone(),
        };
        let mut header = [0; HEADER_BYTES];
        // A description is made to fit, and bytes in memory have no more than 2⁶³.
        let too_long = |_| CacheError::Header("the description of the options is too long");
        let record_length = bincode::serde::encode_into_slice(record, &mut header[RECORD_AT..], configuration());
        let record_length = record_length.map_err(too_long)?;
        header[..8].copy_from_slice(&MAGIC);
        header[8..12].copy_from_slice(&BYTE_ORDER.to_ne_bytes());
        header[12..16].copy_from_slice(&VERSION.to_le_bytes());
        let file_length = self.file_length().ok_or(CacheError::Header("the sections are too long"))?;
        header[32..40].copy_from_slice(&file_length.to_le_bytes());
        header[40..44].copy_from_slice(&(record_length as u32).to_le_bytes());
        let header_sum = sum_of_header(&header);
        header[SUM_AT..FIELDS_AT].copy_from_slice(&header_sum.to_le_bytes());
        Ok(header)
    }

    /// Steps 1 to 6.
    pub(crate) fn read(source: &impl Source) -> Result<Self, CacheError> {
        let found = source.len();
        let mut header = [0; HEADER_BYTES];
        let available = &mut header[..found.min(HEADER_BYTES as u64) as usize];
        source.read_exact_at(0, available)?;
        // A file that begins like another kind is that, even if it is short.
        if !begins_like_ours(available) {
            return Err(CacheError::NotACache);
        }
        if found < FOREVER_BYTES as u64 {
            return Err(CacheError::Truncated { expected: HEADER_BYTES as u64, found });
        }
        if word(&header, 8) == BYTE_ORDER.swap_bytes().to_ne_bytes() {
            return Err(CacheError::ByteOrder);
        }
        check_version("format version", u32::from_le_bytes(word(&header, 12)), VERSION)?;
        if found < HEADER_BYTES as u64 {
            return Err(CacheError::Truncated { expected: HEADER_BYTES as u64, found });
        }
        if u128::from_le_bytes(word(&header, SUM_AT)) != sum_of_header(&header) {
            return Err(CacheError::Checksum { section: Section::Header });
        }
        let this = Self::decode(&header)?;
        let expected = u64::from_le_bytes(word(&header, 32));
        if this.file_length() != Some(expected) {
            return Err(CacheError::Header("its sections do not follow each other up to the length of the file"));
        }
        match found {
            _ if found < expected => Err(CacheError::Truncated { expected, found }),
            _ if found > expected => Err(CacheError::TrailingBytes { expected, found }),
            _ => Ok(this),
        }
    }

    /// Steps 3 to 5 of a header whose sum is right, but for where its sections lie.
    fn decode(header: &[u8; HEADER_BYTES]) -> Result<Self, CacheError> {
        let length = u32::from_le_bytes(word(header, 40)) as usize;
        let record = header[RECORD_AT..].get(..length).ok_or(CacheError::Header("its record is too long"))?;
        let zero = header[44..RECORD_AT].iter().chain(&header[RECORD_AT + length..]).all(|&byte| byte == 0);
        let (record, used): (Record, usize) = bincode::serde::decode_from_slice(record, configuration())
            .map_err(|_| CacheError::Header("its record cannot be decoded"))?;
        if used != length || !zero || word(header, 8) != BYTE_ORDER.to_ne_bytes() {
            return Err(CacheError::Header("there is something where nothing should be"));
        }
        // It is printed, to terminals too.
        if record.description.contains(char::is_control) {
            return Err(CacheError::Header("the description of its options has characters that are not printed"));
        }
        let layout = TreeLayout::from_code(record.layout).ok_or(CacheError::Header("its layout is unknown"))?;
        check_version("layout version", record.layout_version, layout.version())?;
        let options = TreeOptions { layout, description: record.description };
        if options.key() != record.options_key {
            return Err(CacheError::Header("the key of its options is not that of their description"));
        }
        let [min, max]: [[f32; 3]; 2] = bytemuck::must_cast(record.bounds);
        Ok(Self {
            options,
            geometry: GeometryKey(record.geometry_key),
            counts: record.counts,
            bounds: Bounds3::new(Vec3::from_array(min), Vec3::from_array(max)),
            expected_steps: record.expected_steps,
            sections: record.sections,
        })
    }

    /// Step 8: whether it is the tree that was asked for.
    pub(crate) fn expect(
        &self,
        geometry: Option<GeometryKey>,
        options: Option<&TreeOptions>,
    ) -> Result<(), CacheError> {
        if geometry.is_some_and(|geometry| geometry != self.geometry) {
            return Err(CacheError::StaleGeometry);
        }
        match options {
            Some(expected) if *expected != self.options => Err(CacheError::StaleOptions {
                expected: format!("{}, {}", expected.layout, expected.description),
                found: format!("{}, {}", self.options.layout, self.options.description),
            }),
            _ => Ok(()),
        }
    }
}

/// Whether bytes begin with the magic, or are fewer and as it begins.
pub(crate) fn begins_like_ours(bytes: &[u8]) -> bool {
    MAGIC.starts_with(&bytes[..bytes.len().min(MAGIC.len())])
}

/// The bytes from `at` on, inside of the header.
fn word<const N: usize>(header: &[u8; HEADER_BYTES], at: usize) -> [u8; N] {
    std::array::from_fn(|i| header[at + i])
}

fn sum_of_header(header: &[u8; HEADER_BYTES]) -> u128 {
    sum(&[&header[..SUM_AT], &header[FIELDS_AT..]].concat())
}

fn check_version(what: &'static str, found: u32, supported: u32) -> Result<(), CacheError> {
    match found {
        _ if found > supported => Err(CacheError::NewerVersion { what, found, supported }),
        _ if found < supported => Err(CacheError::OlderVersion { what, found, supported }),
        _ => Ok(()),
    }
}
