//! Numbers in buffers.

use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::USize64;
use gltf::json::{Accessor, Index, buffer};

use super::container::{Document, valid};
use crate::LoadError;

/// An accessor whose every element is there.
pub(super) struct Elements<'a> {
    len: usize,
    component: ComponentType,
    normalized: bool,
    /// Bytes of an element.
    size: usize,
    /// From the first element on, and the distance from one to the next; without data all elements are zero.
    data: Option<(&'a [u8], usize)>,
    /// The elements that are replaced, in ascending order, and by what.
    replaced: Vec<u32>,
    replacements: &'a [u8],
}

impl<'a> Elements<'a> {
    /// The elements of an accessor that has to be of this type, with components of one of these.
    pub(super) fn new(
        document: &'a Document<'_>,
        index: Index<Accessor>,
        of: Type,
        components: &[ComponentType],
    ) -> Result<Self, LoadError> {
        let error = |reason: String| document.malformed(format!("accessor {}", index.value()), reason);
        let accessor = document.root.get(index).ok_or_else(|| error("there is no such accessor".to_owned()))?;
        let component = valid(accessor.component_type).map(|c| c.0).filter(|c| components.contains(c));
        let (Some(component), true) = (component, valid(accessor.type_) == Some(of)) else {
            return Err(error(format!("it is not of type {of:?} with components {components:?}")));
        };
        let size = component.size() * of.multiplicity();
        let len = accessor.count.0;
        if accessor.buffer_view.is_none() && len > MAX_ZEROS + document.data_len() {
            return Err(error(format!("{len} elements without data are too many")));
        }
        let section = |view, offset, len, size, stride| section(document, &error, (view, offset), len, (size, stride));
        let mut data = None;
        if let Some(view) = accessor.buffer_view {
            let stride = document.root.get(view).and_then(|v| v.byte_stride).map_or(size, |s| s.0);
            if stride < size {
                return Err(error(format!("elements of {size} bytes are {stride} bytes apart")));
            }
            data = Some((section(view, accessor.byte_offset.unwrap_or_default(), len, size, stride)?, stride));
        }
        let (mut replaced, mut replacements) = (Vec::new(), &[][..]);
        if let Some(Sparse { count, indices, values, .. }) = &accessor.sparse {
            let component = valid(indices.component_type).map(|c| c.0);
            let component = component.ok_or_else(|| error("its sparse indices are of no known type".to_owned()))?;
            let bytes = component.size();
            let indices = section(indices.buffer_view, indices.byte_offset, count.0, bytes, bytes)?;
            replaced = indices.chunks_exact(bytes).take(count.0 as usize).map(|i| integer(i, component)).collect();
            if !replaced.is_sorted_by(|a, b| a < b) || replaced.last().is_some_and(|&last| u64::from(last) >= len) {
                return Err(error("its sparse indices do not ascend, or go beyond the last element".to_owned()));
            }
            replacements = section(values.buffer_view, values.byte_offset, count.0, size, size)?;
        }
        let len = usize::try_from(len).map_err(|e| error(e.to_string()))?;
        Ok(Self { len, component, normalized: accessor.normalized, size, data, replaced, replacements })
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Element `i` as an unsigned integer.
    pub(super) fn index(&self, i: usize) -> u32 {
        self.element(i).map_or(0, |bytes| integer(bytes, self.component))
    }

    /// Element `i` as a vector.
    pub(super) fn vector<const N: usize>(&self, i: usize) -> [f32; N] {
        let Some(element) = self.element(i) else { return [0.0; N] };
        let mut components = element.chunks_exact(self.component.size());
        [0.0; N].map(|zero| components.next().map_or(zero, |bytes| real(bytes, self.component, self.normalized)))
    }

    /// The bytes of element `i`, if it is not zero for want of any.
    fn element(&self, i: usize) -> Option<&[u8]> {
        if let Ok(k) = self.replaced.binary_search(&(i as u32)) {
            return self.replacements.get(k * self.size..(k + 1) * self.size);
        }
        self.data.and_then(|(data, stride)| data.get(i * stride..i * stride + self.size))
    }
}

/// So many elements may be made of nothing in any file, and so many more as it has bytes.
const MAX_ZEROS: u64 = 1 << 16;

/// The bytes from an offset in a view on, where `len` elements of this size and distance are there.
fn section<'a>(
    document: &'a Document<'_>,
    error: &dyn Fn(String) -> LoadError,
    (view, offset): (Index<buffer::View>, USize64),
    len: u64,
    (size, stride): (usize, usize),
) -> Result<&'a [u8], LoadError> {
    let bytes = document.view(view)?;
    let section = usize::try_from(offset.0).ok().and_then(|offset| bytes.get(offset..)).unwrap_or_default();
    let needed = len.checked_sub(1).map_or(0, |last| last.saturating_mul(stride as u64).saturating_add(size as u64));
    if section.len() as u64 >= needed {
        return Ok(section);
    }
    let (view, has) = (view.value(), bytes.len());
    Err(error(format!("{len} elements from byte {} on go beyond the {has} bytes of bufferView {view}", offset.0)))
}

fn integer(bytes: &[u8], component: ComponentType) -> u32 {
    match (component, bytes) {
        (ComponentType::U8, &[a]) => a.into(),
        (ComponentType::U16, &[a, b]) => u16::from_le_bytes([a, b]).into(),
        (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

/// Section 3.11 of the specification: the normalised value of an integer c is c / max, and not below -1.
fn real(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, max) = match (component, bytes) {
        (ComponentType::I8, &[a]) => (f32::from(a as i8), f32::from(i8::MAX)),
        (ComponentType::U8, &[a]) => (f32::from(a), f32::from(u8::MAX)),
        (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), f32::from(i16::MAX)),
        (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), f32::from(u16::MAX)),
        (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        _ => (0.0, 1.0),
    };
    if normalized { (value / max).max(-1.0) } else { value }
}
