//! What assets look like, as they stand in their folders: small pictures of their parts and of their
//! joints at work, and where their pages are.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Component, Path, PathBuf};

use guard::folder::{Caps, Folder, Kind};
use image::codecs::webp::WebPDecoder;
use image::imageops::{self, FilterType};
use image::{AnimationDecoder as _, Frame, ImageDecoder as _, ImageFormat};
use rayon::prelude::*;
use runner::Artefact as _;
use view::{Film, Picture};

use super::figures::Figures;
use crate::batch::folder::{ASSETS, QUARANTINE};
use crate::stages::{Page, Pictures};

/// The side that is shown of an asset without a picture of its parts.
const SIDE: &str = "views/front_right.png";
/// Width and height of a small picture, pixels.
const SIZE: u32 = 224;
/// The same of one that moves, and how many frames it has at most.
const MOVING: u32 = 144;
const FRAMES: usize = 16;
/// Assets that move in a gallery at most: each takes some ten times the room of a picture.
const MOVED: usize = 24;
/// Frames of an animation that are read at most, and the longest side of one, pixels.
const READ: usize = 400;
const LONGEST: u32 = 2048;

/// What is shown of an item.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Look {
    /// JPEG of its parts, or of its mesh.
    pub still: Option<Vec<u8>>,
    /// Animated WebP of its joints.
    pub motion: Option<Vec<u8>>,
    /// Its page, relative to the report.
    pub page: Option<String>,
}

/// What is shown of each item that is named, by id.
pub(super) fn looks(root: &Path, figures: &Figures) -> BTreeMap<String, Look> {
    // A picture of that size has a tenth of a megabyte; the report embeds some dozens.
    let caps = Caps { entries: usize::MAX, file: 64 << 20, ..Caps::default() };
    let Ok(root) = Folder::open(root, caps) else { return BTreeMap::new() };
    let shards = root.list(Path::new(".")).into_iter().flatten();
    let shards = shards.filter(|e| e.kind == Kind::Folder).map(|e| e.path);
    let places = std::iter::once(PathBuf::new()).chain(shards).collect();
    let files = Items { root, places };
    let shown = [(ASSETS, &figures.gallery), (QUARANTINE, &figures.refused)];
    let shown = shown.iter().flat_map(|(folder, items)| {
        items.iter().enumerate().map(|(n, item)| (*folder, item.id.as_str(), n < MOVED))
    });
    let shown: Vec<_> = shown.collect();
    let look =
        |&(folder, id, moves): &(&str, &str, bool)| (id.to_owned(), files.look(folder, id, moves));
    let mut all: BTreeMap<_, _> = shown.par_iter().map(look).collect();
    let named = figures.commonest().into_iter().flat_map(|(_, reason)| &reason.ids);
    for id in named {
        let page = || Look { page: files.page(QUARANTINE, id), ..Look::default() };
        all.entry(id.clone()).or_insert_with(page);
    }
    all
}

/// The folders of a batch's items: in its own folder or one of its shards', and nowhere else.
struct Items {
    root: Folder,
    /// The batch's folder and those of its shards, relative to it.
    places: Vec<PathBuf>,
}

impl Items {
    fn look(&self, folder: &str, id: &str, moves: bool) -> Look {
        let own = self.read(folder, id, Pictures::PARTS).and_then(|png| small(&png));
        let still = own.or_else(|| small(&self.read(folder, id, SIDE)?));
        let motion = moves.then(|| self.read(folder, id, Pictures::MOTION)).flatten();
        let motion = motion.and_then(|webp| moving(&webp));
        Look { still, motion, page: self.page(folder, id) }
    }

    fn read(&self, folder: &str, id: &str, name: &str) -> Option<Vec<u8>> {
        let mut places = self.places.iter();
        places.find_map(|place| self.root.read(&place.join(folder).join(id).join(name)).ok())
    }

    /// The address of an item's page, where it has one and its name is one that ids have.
    fn page(&self, folder: &str, id: &str) -> Option<String> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
        // An id comes from a manifest: it leads nowhere but down.
        let down = Path::new(id).components().all(|c| matches!(c, Component::Normal(_)));
        if !down {
            return None;
        }
        let path = |place: &PathBuf| place.join(folder).join(id).join(Page::FILE_NAME);
        let is_page = |path: &PathBuf| matches!(self.root.kind(path), Ok(Some(Kind::File)));
        let path = self.places.iter().map(path).find(is_page)?;
        path.to_str().filter(|path| path.chars().all(plain)).map(str::to_owned)
    }
}

/// A small JPEG of a picture; of one with names beside it, of the square at its left.
fn small(png: &[u8]) -> Option<Vec<u8>> {
    let picture = image::load_from_memory(png).ok()?.to_rgb8();
    let side = picture.height().min(picture.width());
    let square = imageops::crop_imm(&picture, 0, 0, side, picture.height()).to_image();
    let small = imageops::resize(&square, SIZE, SIZE, FilterType::Triangle);
    let mut jpeg = Cursor::new(Vec::new());
    small.write_to(&mut jpeg, ImageFormat::Jpeg).ok()?;
    Some(jpeg.into_inner())
}

/// An animation made small and short; none of what has no second frame.
fn moving(webp: &[u8]) -> Option<Vec<u8>> {
    let decoder = WebPDecoder::new(Cursor::new(webp)).ok()?;
    let (width, height) = decoder.dimensions();
    if width.max(height) > LONGEST {
        return None;
    }
    let small = |frame: Frame| {
        let (numerator, denominator) = frame.delay().numer_denom_ms();
        let lasts = numerator / denominator.max(1);
        (lasts, imageops::resize(frame.buffer(), MOVING, MOVING, FilterType::Triangle))
    };
    let frames = decoder.into_frames().take(READ).map_while(Result::ok);
    let frames: Vec<_> = frames.map(small).collect();
    if frames.len() < 2 {
        return None;
    }
    let step = frames.len().div_ceil(FRAMES);
    let mut film = Film::new([MOVING; 2]).ok()?;
    for few in frames.chunks(step) {
        let mut picture = Picture::blank([MOVING; 2], [255; 4]);
        // The one that stands longest, so that joints get to their ends.
        let longest = few.iter().max_by_key(|(lasts, _)| *lasts)?;
        for (to, from) in picture.colour.iter_mut().zip(longest.1.pixels()) {
            *to = from.0;
        }
        film.push(&picture, few.iter().map(|(lasts, _)| *lasts).fold(0, u32::saturating_add))
            .ok()?;
    }
    film.finish().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(size: u32, frames: u8) -> Vec<u8> {
        let mut film = Film::new([size; 2]).unwrap();
        for shade in 0..frames {
            film.push(&Picture::blank([size; 2], [shade * 7, 90, 200, 255]), 60).unwrap();
        }
        film.finish().unwrap()
    }

    #[test]
    fn an_animation_becomes_small_and_short_and_takes_as_long() {
        let small = moving(&film(300, 33)).unwrap();
        let decoder = WebPDecoder::new(Cursor::new(&small)).unwrap();
        assert_eq!(decoder.dimensions(), (MOVING, MOVING));
        let frames = decoder.into_frames().collect_frames().unwrap();
        assert!((8..=FRAMES).contains(&frames.len()), "{}", frames.len());
        let lasts: u32 = frames.iter().map(|f| f.delay().numer_denom_ms().0).sum();
        assert_eq!(lasts, 33 * 60);
    }

    #[test]
    fn what_does_not_move_or_is_no_animation_is_left_out() {
        assert_eq!(moving(&film(20, 1)), None);
        assert_eq!(moving(&film(LONGEST + 2, 2)), None);
        assert_eq!(moving(b"RIFF and no more"), None);
    }

    #[test]
    fn only_a_page_that_stands_there_under_a_plain_name_is_linked_to() {
        let folder = tempfile::tempdir().unwrap();
        for id in ["a", "with space", "shard-0-of-2/assets/b"] {
            let place = folder.path().join(if id.contains('/') { "" } else { "assets" }).join(id);
            std::fs::create_dir_all(&place).unwrap();
            std::fs::write(place.join("viewer.html"), "page").unwrap();
        }
        let root = Folder::open(folder.path(), Caps::default()).unwrap();
        let places = vec![PathBuf::new(), "shard-0-of-2".into()];
        let page = |id: &str| {
            Items {
                root: Folder::open(folder.path(), Caps::default()).unwrap(),
                places: places.clone(),
            }
            .page(ASSETS, id)
        };
        drop(root);
        assert_eq!(page("a").as_deref(), Some("assets/a/viewer.html"));
        assert_eq!(page("b").as_deref(), Some("shard-0-of-2/assets/b/viewer.html"));
        assert_eq!((page("with space"), page("gone"), page("../assets/a")), (None, None, None));
    }
}
