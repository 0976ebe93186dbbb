//! The object at rest, each part in its colour, numbered, with the axes of its joints; and beside it
//! which part is which, and how it moves.

use std::collections::BTreeMap;

use sim_check::robot::{Joint, Motion};
use view::draw::{Ink, rounded_box, write};
use view::{
    NO_FACE, Picture, Renderer, ViewError, eight_views, encode_png, font, mark, part_colour,
};

use super::solid::Solid;

/// Width and height of the view, pixels.
const SIZE: u32 = 800;
/// The side it is seen from.
const SIDE: &str = "front_right";
/// Width of a column of names, pixels.
const COLUMN: u32 = 340;
/// Most columns of names.
const COLUMNS: usize = 3;
/// Height of a part's lines, pixels: its name with how it moves below, or only its name.
const ROWS: [f64; 2] = [50.0, 26.0];
/// Room above the names and below them, pixels.
const EDGE: f64 = 18.0;
/// Fewest pixels of a part that is given its number in the view.
const FEWEST: usize = 12;

const PAPER: [u8; 4] = [255; 4];
const INK: [u8; 3] = [27, 32, 42];
const QUIET: [u8; 3] = [96, 104, 118];

/// PNG of the parts.
///
/// # Errors
/// [`ViewError`] when the picture cannot be encoded.
pub(super) fn picture(solid: &Solid<'_>) -> Result<Vec<u8>, ViewError> {
    let parts = Part::all(solid);
    let drawn = drawn(solid, &parts);
    let names = Names::of(&parts);
    let width = SIZE + names.columns() as u32 * COLUMN;
    let mut sheet = Picture::blank([width, SIZE], PAPER);
    for (y, row) in drawn.colour.chunks_exact(SIZE as usize).enumerate() {
        let start = y * width as usize;
        sheet.colour[start..start + row.len()].copy_from_slice(row);
    }
    names.write(&mut sheet);
    encode_png(&sheet)
}

/// A link of which something is seen.
struct Part {
    link: usize,
    name: String,
    /// How it moves, in words.
    motion: String,
}

impl Part {
    fn all(solid: &Solid<'_>) -> Vec<Self> {
        let robot = solid.robot;
        let mut seen: Vec<usize> = solid.link_of_face.iter().map(|&l| usize::from(l)).collect();
        seen.dedup();
        let mut words: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for joint in robot.joints.iter().filter(|j| j.kind.moves()) {
            words.entry(solid.seen_below(joint.child)).or_default().push(told(joint));
        }
        let part = |link: usize| Self {
            link,
            name: robot.links[link].name.clone(),
            motion: words.get(&link).map(|w| w.join(", ")).unwrap_or_default(),
        };
        seen.into_iter().map(part).collect()
    }
}

/// How a joint moves, in a few words.
fn told(joint: &Joint) -> String {
    let ends = |unit: &str, scale: f64| match joint.limit {
        Some(l) => format!(" {:.0} to {:.0}{unit}", l.lower * scale, l.upper * scale),
        None => String::new(),
    };
    let follows = if joint.mimic.is_some() { "follows, " } else { "" };
    let words = match joint.kind {
        Motion::Fixed => "fixed".into(),
        Motion::Revolute => format!("turns{}", ends("°", 1f64.to_degrees())),
        Motion::Continuous => "turns without end".into(),
        Motion::Prismatic => format!("slides{}", ends(" mm", 1000.0)),
        Motion::Floating | Motion::Planar => "moves freely".into(),
    };
    format!("{follows}{words}")
}

/// The view, with axes and numbers drawn on it.
fn drawn(solid: &Solid<'_>, parts: &[Part]) -> Picture {
    let views = eight_views(&solid.mesh.bounds(), SIZE);
    let view = views.iter().find(|v| v.name == SIDE).unwrap_or(&views[0]);
    let mut picture = Renderer::new(&solid.mesh, &solid.paint()).render(&view.camera);
    let middles = middles(&picture, solid);
    let still = solid.moves(&[]);
    for joint in solid.robot.joints.iter().filter(|j| j.kind.has_axis()) {
        solid.draw_axis(&mut picture, &view.camera, joint, &still);
    }
    for (number, part) in parts.iter().enumerate() {
        if let Some(&at) = middles.get(&part.link) {
            mark(&mut picture, at, &(number + 1).to_string());
        }
    }
    picture
}

/// Of each link the pixel of it that is nearest to the middle of all that see it.
fn middles(picture: &Picture, solid: &Solid<'_>) -> BTreeMap<usize, [f64; 2]> {
    let width = picture.size[0].max(1) as usize;
    let mut seen: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    for (i, face) in picture.face.iter().enumerate().filter(|(_, face)| **face != NO_FACE) {
        let Some(&link) = solid.link_of_face.get(*face as usize) else { continue };
        let at = [(i % width) as f64 + 0.5, (i / width) as f64 + 0.5];
        seen.entry(link.into()).or_default().push(at);
    }
    let nearest = |pixels: &[[f64; 2]]| {
        let mean = [0, 1].map(|c| pixels.iter().map(|p| p[c]).sum::<f64>() / pixels.len() as f64);
        let far = |p: &[f64; 2]| (p[0] - mean[0]).hypot(p[1] - mean[1]);
        pixels.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied()
    };
    let large = seen.iter().filter(|(_, pixels)| pixels.len() >= FEWEST);
    large.filter_map(|(&link, pixels)| Some((link, nearest(pixels)?))).collect()
}

/// The parts as columns of names.
struct Names<'a> {
    parts: &'a [Part],
    /// Height of a part's lines, pixels.
    row: f64,
    /// Parts in a column.
    column: usize,
}

impl<'a> Names<'a> {
    fn of(parts: &'a [Part]) -> Self {
        let fit = |row: f64| ((f64::from(SIZE) - 2.0 * EDGE) / row) as usize;
        let [tall, low] = ROWS;
        let row = if parts.len() <= fit(tall) { tall } else { low };
        Self { parts, row, column: fit(row) }
    }

    fn columns(&self) -> usize {
        self.parts.len().div_ceil(self.column).clamp(1, COLUMNS)
    }

    fn write(&self, sheet: &mut Picture) {
        let room = self.columns() * self.column;
        let more = self.parts.len() > room;
        let shown = if more { room - 1 } else { self.parts.len() };
        for (i, part) in self.parts.iter().take(shown).enumerate() {
            self.entry(sheet, i, part);
        }
        if more {
            let left = self.parts.len() - shown;
            let [x, y] = self.place(shown);
            write(sheet, [x + 44.0, y], 1.7, Ink::solid(QUIET), &format!("and {left} more"));
        }
    }

    /// The upper left corner of an entry.
    fn place(&self, i: usize) -> [f64; 2] {
        let left = SIZE + (i / self.column) as u32 * COLUMN;
        [f64::from(left) + 16.0, EDGE + (i % self.column) as f64 * self.row]
    }

    fn entry(&self, sheet: &mut Picture, i: usize, part: &Part) {
        let [x, y] = self.place(i);
        let colour = part_colour(part.link);
        let swatch = [[x, y - 2.0], [x + 32.0, y + 17.0]];
        rounded_box(sheet, swatch, 5.0, Ink::solid(colour));
        let number = (i + 1).to_string();
        let [r, g, b] = colour.map(f64::from);
        let light = 0.3 * r + 0.6 * g + 0.1 * b > 140.0;
        let ink = Ink::solid(if light { INK } else { [255; 3] });
        let wide = font::layout(&number).1 * 1.6;
        write(sheet, [x + 16.0 - wide / 2.0, y + 2.5], 1.6, ink, &number);
        let left = x + 44.0;
        let room = f64::from(COLUMN) - 60.0;
        let name = cut(&part.name, room / 1.8);
        write(sheet, [left, y + 1.5], 1.8, Ink::solid(INK), &name);
        if self.row == ROWS[0] {
            let motion = cut(&part.motion, room / 1.6);
            write(sheet, [left, y + 21.0], 1.6, Ink::solid(QUIET), &motion);
        }
    }
}

/// A text that takes at most so many dots; what is cut off is told by two points.
fn cut(text: &str, dots: f64) -> String {
    if font::layout(text).1 <= dots {
        return text.to_owned();
    }
    let mut letters: Vec<char> = text.chars().collect();
    while !letters.is_empty() {
        letters.pop();
        let shorter: String = letters.iter().chain(&['.', '.']).collect();
        if font::layout(&shorter).1 <= dots {
            return shorter;
        }
    }
    String::new()
}
