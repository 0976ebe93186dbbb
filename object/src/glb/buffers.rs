//! The bytes behind buffers and buffer views, meshopt streams already unpacked.

use std::borrow::Cow;
use std::collections::BTreeMap;

use draco_gltf::meshopt::{MeshoptFilter, MeshoptMode, decode_buffer_view};

use super::decoding::{guarded, most_unpacked};
use super::document::{BufferView, Document, Meshopt};
use super::error::GlbError;

/// Every buffer view of a file, checked to lie inside its buffer when asked for.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    views: &'a [BufferView],
    buffers: Vec<Cow<'a, [u8]>>,
    unpacked: BTreeMap<usize, Vec<u8>>,
    /// Bytes of the file.
    file: usize,
}

impl<'a> Buffers<'a> {
    /// Finds every buffer's bytes (the BIN chunk or a data URI) and unpacks meshopt views.
    pub(super) fn load(
        document: &'a Document,
        bin: Option<&'a [u8]>,
        file: usize,
    ) -> Result<Self, GlbError> {
        let buffers = (0..document.buffers.len()).map(|b| buffer_bytes(document, b, bin));
        let buffers = buffers.collect::<Result<_, _>>()?;
        let views = &document.buffer_views;
        let mut loaded = Self { views, buffers, unpacked: BTreeMap::new(), file };
        loaded.unpack_meshopt()?;
        Ok(loaded)
    }

    /// Bytes of the file.
    pub(super) fn file_bytes(&self) -> usize {
        self.file
    }

    /// Most bytes that compressed or left-out data may come to.
    pub(super) fn most_unpacked(&self) -> usize {
        most_unpacked(self.file)
    }

    /// The bytes of a view.
    pub(super) fn view(&self, index: usize, place: &str) -> Result<&[u8], GlbError> {
        let missing = || GlbError::reference(place, "buffer view", index, self.views.len());
        let view = self.views.get(index).ok_or_else(missing)?;
        match self.unpacked.get(&index) {
            Some(bytes) => Ok(bytes),
            None => self.range(
                &format!("buffer view {index}"),
                view.buffer,
                view.byte_offset,
                view.byte_length,
            ),
        }
    }

    /// The stride a view declares, in bytes.
    pub(super) fn stride(&self, index: usize) -> Option<usize> {
        self.views.get(index).and_then(|v| v.byte_stride)
    }

    fn range(
        &self,
        place: &str,
        buffer: usize,
        offset: usize,
        length: usize,
    ) -> Result<&[u8], GlbError> {
        let missing = || GlbError::reference(place, "buffer", buffer, self.buffers.len());
        let bytes = self.buffers.get(buffer).ok_or_else(missing)?;
        let end = offset.checked_add(length);
        end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            let found = format!("{length} bytes at {offset} of {}", bytes.len());
            GlbError::rule(place, "its range must lie inside its buffer", found)
        })
    }

    fn unpack_meshopt(&mut self) -> Result<(), GlbError> {
        let mut total = 0usize;
        for (index, view) in self.views.iter().enumerate() {
            let Some(packed) = &view.extensions.meshopt else { continue };
            let place = format!("buffer view {index}");
            total = total.saturating_add(view.byte_length);
            if total > self.most_unpacked() {
                let rule =
                    "meshopt views may unpack to 16 MiB and 2000 times the file, 512 MiB at most";
                return Err(GlbError::rule(place, rule, format!("{total} bytes")));
            }
            let bytes = self.unpack(&place, packed, view.byte_length)?;
            self.unpacked.insert(index, bytes);
        }
        Ok(())
    }

    fn unpack(&self, place: &str, m: &Meshopt, length: usize) -> Result<Vec<u8>, GlbError> {
        if m.count.checked_mul(m.byte_stride) != Some(length) {
            let found = format!("{} · {} for {length} bytes", m.count, m.byte_stride);
            return Err(GlbError::rule(place, "meshopt count · stride fills the view", found));
        }
        let source = self.range(place, m.buffer, m.byte_offset, m.byte_length)?;
        guarded(place, "meshopt", || {
            let mode = MeshoptMode::from_name(&m.mode)?;
            let filter = MeshoptFilter::from_name(m.filter.as_deref().unwrap_or("NONE"))?;
            let mut bytes = vec![0; length];
            decode_buffer_view(&mut bytes, source, mode, filter, m.count, m.byte_stride)?;
            Ok::<_, draco_gltf::GltfError>(bytes)
        })
    }
}

/// A buffer's bytes: its data URI, or the BIN chunk for the first buffer; else none, which is an
/// error only for a view that reads it (a meshopt fallback is never read).
fn buffer_bytes<'a>(
    document: &Document,
    index: usize,
    bin: Option<&'a [u8]>,
) -> Result<Cow<'a, [u8]>, GlbError> {
    let Some(buffer) = document.buffers.get(index) else { return Ok(Cow::Borrowed(&[])) };
    let place = || format!("buffer {index}");
    let bytes = match (&buffer.uri, bin) {
        (Some(uri), _) => Cow::Owned(data_uri(&place(), uri)?),
        (None, Some(bin)) if index == 0 => Cow::Borrowed(bin),
        (None, _) => return Ok(Cow::Borrowed(&[])),
    };
    let (declared, present) = (buffer.byte_length, bytes.len());
    if declared > present {
        let found = format!("{declared} declared, {present} present");
        return Err(GlbError::rule(place(), "the declared bytes must be there", found));
    }
    Ok(match bytes {
        Cow::Borrowed(b) => Cow::Borrowed(b.get(..declared).unwrap_or(b)),
        Cow::Owned(mut b) => {
            b.truncate(declared);
            Cow::Owned(b)
        }
    })
}

/// Decodes a `data:` URI.
pub(super) fn data_uri(place: &str, uri: &str) -> Result<Vec<u8>, GlbError> {
    guarded(place, "data URI", || {
        draco_gltf::decode_data_uri(uri, Some(super::container::MAX_JSON))
    })
}
