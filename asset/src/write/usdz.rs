//! The USD layer and its pictures in one file: a zip without compression, each file's bytes aligned to 64
//! (OpenUSD's "Usdz File Format Specification").

use crate::asset::Asset;
use crate::write::appearance::look::AssetAppearance;

/// Where each file's bytes begin, a multiple of it.
const ALIGNED: usize = 64;
/// The first of January 1980, the earliest day a zip can say: no clock is asked.
const DATE: u16 = 0x21;
/// Version 1.0 of the format is enough.
const VERSION: u16 = 10;

impl Asset {
    /// The asset as a USDZ file: [`Asset::to_usd_with`] and the pictures it names. The same asset gives
    /// the same bytes.
    pub fn to_usdz_with(&self, appearance: &AssetAppearance) -> Vec<u8> {
        let mut zip = Zip::default();
        // The first file is the one that is opened.
        zip.add("asset.usda", self.to_usd_with(appearance).as_bytes());
        let mut used = std::collections::BTreeSet::new();
        for group in (0..self.links.len()).flat_map(|link| appearance.materials(link)) {
            used.extend(group.material.textures().into_iter().flatten().map(|t| t.picture));
        }
        for texture in used.into_iter().filter_map(|picture| appearance.textures.get(picture)) {
            zip.add(&texture.path, texture.picture.bytes());
        }
        zip.finish()
    }
}

#[derive(Default)]
struct Zip {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    count: u16,
}

fn put(out: &mut Vec<u8>, shorts: &[u16]) {
    out.extend(shorts.iter().flat_map(|s| s.to_le_bytes()));
}

fn long(out: &mut Vec<u8>, word: usize) {
    out.extend((word as u32).to_le_bytes());
}

impl Zip {
    fn add(&mut self, name: &str, content: &[u8]) {
        let at = self.bytes.len();
        let mut sums = Vec::new();
        long(&mut sums, crc32(content) as usize);
        long(&mut sums, content.len());
        long(&mut sums, content.len());
        // A field nobody reads fills the way to the next multiple; a field has a head of four bytes.
        let start = at + 30 + name.len() + 4;
        let fill = start.next_multiple_of(ALIGNED) - start;
        self.bytes.extend(b"PK\x03\x04");
        put(&mut self.bytes, &[VERSION, 0, 0, 0, DATE]);
        self.bytes.extend(&sums);
        put(&mut self.bytes, &[name.len() as u16, fill as u16 + 4]);
        self.bytes.extend(name.as_bytes());
        put(&mut self.bytes, &[0x1986, fill as u16]);
        self.bytes.resize(self.bytes.len() + fill, 0);
        self.bytes.extend(content);
        self.directory.extend(b"PK\x01\x02");
        put(&mut self.directory, &[VERSION, VERSION, 0, 0, 0, DATE]);
        self.directory.extend(&sums);
        put(&mut self.directory, &[name.len() as u16, 0, 0, 0, 0, 0, 0]);
        long(&mut self.directory, at);
        self.directory.extend(name.as_bytes());
        self.count += 1;
    }

    fn finish(self) -> Vec<u8> {
        let Self { mut bytes, directory, count } = self;
        let at = bytes.len();
        bytes.extend(&directory);
        bytes.extend(b"PK\x05\x06");
        put(&mut bytes, &[0, 0, count, count]);
        long(&mut bytes, directory.len());
        long(&mut bytes, at);
        put(&mut bytes, &[0]);
        bytes
    }
}

/// The checksum of zip (ISO 3309), bit by bit over a table of 256.
fn crc32(bytes: &[u8]) -> u32 {
    let table: [u32; 256] = std::array::from_fn(|n| {
        (0..8).fold(n as u32, |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    });
    let step = |c: u32, b: &u8| table[((c ^ u32::from(*b)) & 0xff) as usize] ^ (c >> 8);
    !bytes.iter().fold(u32::MAX, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_zip() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn every_file_begins_at_a_multiple_of_64() {
        let mut zip = Zip::default();
        zip.add("asset.usda", b"#usda 1.0\n");
        zip.add("meshes/a.png", b"second");
        let bytes = zip.finish();
        for content in [&b"#usda 1.0\n"[..], b"second"] {
            let at = bytes.windows(content.len()).position(|w| w == content).unwrap();
            assert_eq!(at % 64, 0);
        }
    }
}
