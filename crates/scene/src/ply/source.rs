//! Where the numbers of a PLY body come from.

use std::str::FromStr;

use super::header::{Element, Kind, Scalar};
use crate::Place;

/// A run of numbers. `None` from a method means that the file ends, or that what comes is no such number; then
/// [`why`](Self::why) tells which.
pub(super) trait Source {
    /// The next number. Every type of PLY fits into an f64.
    fn next(&mut self, scalar: Scalar) -> Option<f64>;

    /// Goes past `count` numbers.
    fn skip_scalars(&mut self, scalar: Scalar, count: u64) -> Option<()>;

    /// Goes past a property.
    fn skip(&mut self, kind: Kind) -> Option<()> {
        match kind {
            Kind::Scalar(scalar) => self.skip_scalars(scalar, 1),
            Kind::List { count, items } => {
                let count = self.next(count)?;
                self.skip_scalars(items, count as u64)
            }
        }
    }

    /// How many bytes there are still.
    fn remaining(&self) -> usize;

    /// Whether there is anything but white space still.
    fn has_more(&self) -> bool;

    /// The bytes that an element takes at least.
    fn least_len(element: &Element) -> u64;

    /// Here: where the last number stood, or should have.
    fn place(&self) -> Place;

    /// Why there is no number.
    fn why(&self) -> String;
}

/// Numbers as they are in memory.
pub(super) struct Binary<'a, const BIG_ENDIAN: bool> {
    len: usize,
    rest: &'a [u8],
}

impl<'a, const BIG_ENDIAN: bool> Binary<'a, BIG_ENDIAN> {
    pub(super) fn new(bytes: &'a [u8], start: usize) -> Self {
        Self { len: bytes.len(), rest: bytes.get(start..).unwrap_or_default() }
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        let mut bytes = *bytes;
        if BIG_ENDIAN {
            bytes.reverse();
        }
        Some(bytes)
    }
}

impl<const BIG_ENDIAN: bool> Source for Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn next(&mut self, scalar: Scalar) -> Option<f64> {
        Some(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn skip_scalars(&mut self, scalar: Scalar, count: u64) -> Option<()> {
        let len = usize::try_from(count).ok()?.checked_mul(scalar.size())?;
        self.rest = self.rest.get(len..)?;
        Some(())
    }

    fn remaining(&self) -> usize {
        self.rest.len()
    }

    fn has_more(&self) -> bool {
        !self.rest.trim_ascii_start().is_empty()
    }

    fn least_len(element: &Element) -> u64 {
        let len = |kind| match kind {
            Kind::Scalar(scalar) => scalar.size() as u64,
            Kind::List { count, .. } => count.size() as u64,
        };
        element.properties.iter().map(|p| len(p.kind)).sum()
    }

    fn place(&self) -> Place {
        Place::Byte((self.len - self.rest.len()) as u64)
    }

    fn why(&self) -> String {
        "the file ends".to_owned()
    }
}

/// Numbers as words. Where lines end does not matter.
pub(super) struct Ascii<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The last word, and what it should have been.
    word: &'a [u8],
    scalar: Scalar,
}

impl<'a> Ascii<'a> {
    pub(super) fn new(bytes: &'a [u8], start: usize) -> Self {
        Self { bytes, at: start, word: &[], scalar: Scalar::F32 }
    }

    fn next_word(&mut self) -> Option<&'a str> {
        let is_word = |b: &u8| !b.is_ascii_whitespace();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let start = rest.iter().position(is_word).unwrap_or(rest.len());
        let len = rest[start..].iter().position(|b| !is_word(b)).unwrap_or(rest.len() - start);
        self.word = &rest[start..start + len];
        self.at += start + len;
        if len == 0 { None } else { std::str::from_utf8(self.word).ok() }
    }
}

impl Source for Ascii<'_> {
    fn next(&mut self, scalar: Scalar) -> Option<f64> {
        fn number<T: FromStr + Into<f64>>(word: &str) -> Option<f64> {
            word.parse::<T>().ok().map(Into::into)
        }
        self.scalar = scalar;
        let word = self.next_word()?;
        match scalar {
            Scalar::I8 => number::<i8>(word),
            Scalar::U8 => number::<u8>(word),
            Scalar::I16 => number::<i16>(word),
            Scalar::U16 => number::<u16>(word),
            Scalar::I32 => number::<i32>(word),
            Scalar::U32 => number::<u32>(word),
            Scalar::F32 => number::<f32>(word),
            Scalar::F64 => number::<f64>(word),
        }
    }

    fn skip_scalars(&mut self, scalar: Scalar, count: u64) -> Option<()> {
        self.scalar = scalar;
        for _ in 0..count {
            self.next_word()?;
        }
        Some(())
    }

    /// As if the last line had an end, which it need not have.
    fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at) + 1
    }

    fn has_more(&self) -> bool {
        !self.bytes.get(self.at..).unwrap_or_default().trim_ascii().is_empty()
    }

    /// A digit for each property, and something behind it.
    fn least_len(element: &Element) -> u64 {
        2 * element.properties.len() as u64
    }

    fn place(&self) -> Place {
        let before = &self.bytes[..self.at.min(self.bytes.len()) - self.word.len()];
        let count = |end| before.iter().filter(|&&b| b == end).count();
        Place::Line(1 + count(if self.bytes.contains(&b'\n') { b'\n' } else { b'\r' }))
    }

    fn why(&self) -> String {
        if self.word.is_empty() {
            "the file ends".to_owned()
        } else {
            let word = &self.word[..self.word.len().min(40)];
            format!("\"{}\" is no {}", word.escape_ascii(), self.scalar.name())
        }
    }
}
