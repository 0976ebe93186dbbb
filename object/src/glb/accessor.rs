//! Accessors: typed arrays over buffer views, dense or sparse, read into plain numbers.

use super::buffers::Buffers;
use super::document::{Accessor, Document, Sparse, SparsePart};
use super::error::GlbError;

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    pub(super) fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes` (zero where they end early); `normalized` integers
    /// become −1…1 or 0…1 as the specification says.
    pub(super) fn number(self, bytes: &[u8], normalized: bool) -> f64 {
        let signed = |v: f64, most: f64| if normalized { (v / most).max(-1.0) } else { v };
        let unsigned = |v: f64, most: f64| if normalized { v / most } else { v };
        let first = |n: usize| {
            let mut word = [0u8; 4];
            word.iter_mut().zip(bytes).take(n).for_each(|(w, b)| *w = *b);
            word
        };
        match self {
            Self::I8 => signed(f64::from(first(1)[0] as i8), 127.0),
            Self::U8 => unsigned(f64::from(first(1)[0]), 255.0),
            Self::I16 => signed(f64::from(u32::from_le_bytes(first(2)) as u16 as i16), 32767.0),
            Self::U16 => unsigned(f64::from(u32::from_le_bytes(first(2)) as u16), 65535.0),
            Self::U32 => unsigned(f64::from(u32::from_le_bytes(first(4))), 4_294_967_295.0),
            Self::F32 => f64::from(f32::from_le_bytes(first(4))),
        }
    }

    /// Reads rows of `N` numbers from tightly packed bytes.
    pub(super) fn rows<const N: usize>(self, bytes: &[u8], normalized: bool) -> Vec<[f64; N]> {
        let size = self.size();
        let number =
            |row: &[u8], i: usize| self.number(row.get(i * size..).unwrap_or(&[]), normalized);
        bytes.chunks_exact(size * N).map(|row| std::array::from_fn(|i| number(row, i))).collect()
    }
}

/// The accessors of a file with the bytes behind them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accessors<'a> {
    pub document: &'a Document,
    pub buffers: &'a Buffers<'a>,
}

impl<'a> Accessors<'a> {
    /// The declaration of an accessor.
    pub(super) fn get(&self, index: usize, place: &str) -> Result<&'a Accessor, GlbError> {
        let all = &self.document.accessors;
        all.get(index).ok_or_else(|| GlbError::reference(place, "accessor", index, all.len()))
    }

    /// Rows of `N` numbers; `place` names who asks.
    pub(super) fn rows<const N: usize>(
        &self,
        index: usize,
        place: &str,
    ) -> Result<Vec<[f64; N]>, GlbError> {
        let accessor = self.get(index, place)?;
        let component = component(accessor, index)?;
        let (bytes, normalized) = (self.packed(index, N)?, accessor.normalized);
        Ok(component.rows(&bytes, normalized))
    }

    /// The first row alone, of an accessor with a view of its own; none without one.
    pub(super) fn first<const N: usize>(
        &self,
        index: usize,
        place: &str,
    ) -> Result<Option<[f64; N]>, GlbError> {
        let accessor = self.get(index, place)?;
        let (expected, component) = (shape_name(N), component(accessor, index)?);
        if accessor.shape != expected {
            let found = format!("{} instead of {expected}", accessor.shape);
            return Err(GlbError::rule(named(index), "its type must fit its use", found));
        }
        let Some(view) = accessor.buffer_view else { return Ok(None) };
        let bytes = self.buffers.view(view, place)?;
        let end = accessor.byte_offset.checked_add(component.size() * N);
        let row = end.and_then(|end| bytes.get(accessor.byte_offset..end));
        Ok(row.and_then(|row| component.rows(row, accessor.normalized).first().copied()))
    }

    /// Vertex indices: unsigned whole numbers.
    pub(super) fn indices(&self, index: usize, place: &str) -> Result<Vec<u32>, GlbError> {
        let accessor = self.get(index, place)?;
        let component = component(accessor, index)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            let found = format!("component type {}", accessor.component_type);
            return Err(GlbError::rule(named(index), "indices must be u8, u16 or u32", found));
        }
        let bytes = self.packed(index, 1)?;
        let whole = |word: &[u8]| component.number(word, false) as u32;
        Ok(bytes.chunks_exact(component.size()).map(whole).collect())
    }

    /// The accessor's elements without gaps, sparse ones patched in.
    fn packed(&self, index: usize, width: usize) -> Result<Vec<u8>, GlbError> {
        let (accessor, place) = (self.get(index, "accessor")?, named(index));
        let expected = shape_name(width);
        if accessor.shape != expected {
            let found = format!("{} instead of {expected}", accessor.shape);
            return Err(GlbError::rule(place, "its type must fit its use", found));
        }
        let size = component(accessor, index)?.size() * width;
        let most = self.buffers.most_unpacked();
        let length = accessor.count.checked_mul(size).filter(|&l| l <= most);
        let Some(length) = length else {
            let found = format!("{} elements of {size} bytes", accessor.count);
            let rule = "an accessor has 16 MiB and 2000 times the file, 512 MiB at most";
            return Err(GlbError::rule(place, rule, found));
        };
        let mut bytes = match accessor.buffer_view {
            Some(view) => self.gather(index, view, size)?,
            None => vec![0; length],
        };
        if let Some(sparse) = &accessor.sparse {
            self.patch(&mut bytes, sparse, &place, size)?;
        }
        Ok(bytes)
    }

    /// Copies `count` elements of `size` bytes out of a view, stepping by its stride.
    fn gather(&self, index: usize, view: usize, size: usize) -> Result<Vec<u8>, GlbError> {
        let (accessor, place) = (self.get(index, "accessor")?, named(index));
        let stride = self.buffers.stride(view).unwrap_or(size);
        if stride < size {
            let found = format!("stride {stride} for {size} bytes");
            return Err(GlbError::rule(place, "the stride must hold an element", found));
        }
        let bytes = self.buffers.view(view, &place)?;
        let Some(last) = accessor.count.checked_sub(1) else { return Ok(Vec::new()) };
        let needed = last.checked_mul(stride).and_then(|n| n.checked_add(size));
        let end = needed.and_then(|n| n.checked_add(accessor.byte_offset));
        let Some(range) = end.and_then(|end| bytes.get(accessor.byte_offset..end)) else {
            let (count, offset) = (accessor.count, accessor.byte_offset);
            let found = format!("{count} × {stride} bytes at {offset} of {}", bytes.len());
            return Err(GlbError::rule(place, "its elements must lie inside its view", found));
        };
        if stride == size {
            return Ok(range.to_vec());
        }
        Ok(range.chunks(stride).filter_map(|row| row.get(..size)).flatten().copied().collect())
    }

    fn patch(
        &self,
        bytes: &mut [u8],
        sparse: &Sparse,
        place: &str,
        size: usize,
    ) -> Result<(), GlbError> {
        let code = sparse.indices.component_type.and_then(Component::from_code);
        let Some(component @ (Component::U8 | Component::U16 | Component::U32)) = code else {
            let found = format!("component type {:?}", sparse.indices.component_type);
            return Err(GlbError::rule(place, "sparse indices must be u8, u16 or u32", found));
        };
        let indices = self.sparse_part(&sparse.indices, sparse.count, component.size(), place)?;
        let values = self.sparse_part(&sparse.values, sparse.count, size, place)?;
        let mut next = 0;
        for (word, value) in indices.chunks_exact(component.size()).zip(values.chunks_exact(size)) {
            let at = component.number(word, false) as usize;
            let row = at.checked_mul(size).and_then(|o| bytes.get_mut(o..o.checked_add(size)?));
            match row {
                Some(row) if at >= next => row.copy_from_slice(value),
                _ => {
                    let rule = "sparse indices must rise and name an element";
                    return Err(GlbError::rule(place, rule, format!("{at} after {next}")));
                }
            }
            next = at + 1;
        }
        Ok(())
    }

    fn sparse_part(
        &self,
        part: &SparsePart,
        count: usize,
        size: usize,
        place: &str,
    ) -> Result<&'a [u8], GlbError> {
        let bytes = self.buffers.view(part.buffer_view, place)?;
        let end = count.checked_mul(size).and_then(|l| l.checked_add(part.byte_offset));
        end.and_then(|end| bytes.get(part.byte_offset..end)).ok_or_else(|| {
            let found =
                format!("{count} × {size} bytes at {} of {}", part.byte_offset, bytes.len());
            GlbError::rule(place, "sparse data must lie inside its view", found)
        })
    }
}

fn component(accessor: &Accessor, index: usize) -> Result<Component, GlbError> {
    Component::from_code(accessor.component_type).ok_or_else(|| {
        let found = accessor.component_type.to_string();
        GlbError::rule(named(index), "the component type must be glTF 2.0's", found)
    })
}

fn named(index: usize) -> String {
    format!("accessor {index}")
}

fn shape_name(width: usize) -> &'static str {
    match width {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        16 => "MAT4",
        _ => "VEC4",
    }
}
