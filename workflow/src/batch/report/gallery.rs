//! Small pictures of assets, as they stand in their folders.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use guard::folder::{Caps, Folder, Kind};
use image::ImageFormat;
use image::imageops::FilterType;

use super::figures::Figures;
use crate::batch::folder::{ASSETS, QUARANTINE};

/// The side that is shown.
const SIDE: &str = "views/front_right.png";
/// Width and height, pixels.
const SIZE: u32 = 224;

/// A small JPEG of each shown item that has a picture, by id.
pub(super) fn pictures(root: &Path, figures: &Figures) -> BTreeMap<String, Vec<u8>> {
    // A picture of that size has a tenth of a megabyte; the report embeds some dozens.
    let caps = Caps { entries: usize::MAX, file: 64 << 20, ..Caps::default() };
    let Ok(root) = &Folder::open(root, caps) else { return BTreeMap::new() };
    let shown = |folder: &'static str, items: &'_ [super::figures::Shown]| {
        let picture = |id: &str| Some((id.to_owned(), small(&find(root, folder, id)?)?));
        items.iter().filter_map(|i| picture(&i.id)).collect::<Vec<_>>()
    };
    let mut all: BTreeMap<_, _> = shown(ASSETS, &figures.gallery).into_iter().collect();
    all.extend(shown(QUARANTINE, &figures.refused));
    all
}

/// The picture's bytes, in the batch's folder or one of its shards', and nowhere else.
fn find(root: &Folder, folder: &str, id: &str) -> Option<Vec<u8>> {
    let shards = root.list(Path::new(".")).into_iter().flatten();
    let shards = shards.filter(|e| e.kind == Kind::Folder).map(|e| e.path);
    let mut places = std::iter::once(PathBuf::new()).chain(shards);
    places.find_map(|place| root.read(&place.join(folder).join(id).join(SIDE)).ok())
}

fn small(png: &[u8]) -> Option<Vec<u8>> {
    let picture = image::load_from_memory(png).ok()?.to_rgb8();
    let small = image::imageops::resize(&picture, SIZE, SIZE, FilterType::Triangle);
    let mut jpeg = Cursor::new(Vec::new());
    small.write_to(&mut jpeg, ImageFormat::Jpeg).ok()?;
    Some(jpeg.into_inner())
}
