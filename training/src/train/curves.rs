//! The curves of a run: a CSV that a resumed run continues where its checkpoint was, and a plot.

use std::path::{Path, PathBuf};

use view::draw::{Ink, stroke, write};
use view::{Picture, encode_png};

use super::error::TrainError;
use crate::dataset::cache::write_whole;

/// A table whose first column is the step, kept on disk as CSV.
#[derive(Clone, Debug)]
pub struct Table {
    path: PathBuf,
    heads: String,
    /// Step and whole line of every row.
    rows: Vec<(u64, String)>,
}

impl Table {
    /// Opens a table at a step: what an earlier run wrote beyond it is forgotten.
    ///
    /// # Errors
    /// [`TrainError`] when the file is there but cannot be understood.
    pub fn open(path: &Path, heads: &str, step: u64) -> Result<Self, TrainError> {
        let mut rows = Vec::new();
        if path.exists() {
            let text = std::fs::read_to_string(path).map_err(TrainError::io(path))?;
            for line in text.lines().skip(1) {
                let first = line.split(',').next().unwrap_or_default();
                let told = || format!("expected a step at the start of `{line}`");
                let at = first.parse::<u64>();
                let at = at.map_err(|_| TrainError::Config { path: path.into(), what: told() })?;
                if at <= step {
                    rows.push((at, line.to_owned()));
                }
            }
        }
        Ok(Self { path: path.into(), heads: heads.into(), rows })
    }

    /// Adds a row and writes the table.
    ///
    /// # Errors
    /// [`TrainError`] when the disk refuses.
    pub fn add(&mut self, step: u64, cells: &[String]) -> Result<(), TrainError> {
        self.rows.push((step, format!("{step},{}", cells.join(","))));
        let lines = self.rows.iter().map(|(_, line)| line.as_str());
        let text: String =
            std::iter::once(self.heads.as_str()).chain(lines).flat_map(|l| [l, "\n"]).collect();
        write_whole(&self.path, text.as_bytes()).map_err(TrainError::io(&self.path))
    }

    /// A column by its head: step and value of every row that has one.
    pub fn column(&self, head: &str) -> Vec<(f64, f64)> {
        let Some(at) = self.heads.split(',').position(|h| h == head) else { return vec![] };
        let value = |line: &str| line.split(',').nth(at).and_then(|v| v.parse::<f64>().ok());
        self.rows.iter().filter_map(|(s, line)| Some((*s as f64, value(line)?))).collect()
    }
}

/// One line of a plot.
#[derive(Clone, Debug)]
pub struct Line {
    /// What it is called.
    pub name: &'static str,
    /// x and y of its points, x ascending.
    pub points: Vec<(f64, f64)>,
    /// sRGB.
    pub colour: [u8; 3],
}

const SIZE: [u32; 2] = [960, 540];
/// Pixels left of, above, right of and below the field.
const MARGIN: [f64; 4] = [72.0, 36.0, 36.0, 40.0];
const PAPER: [u8; 4] = [255; 4];
const GREY: [u8; 3] = [120, 124, 132];
const GRID: [u8; 3] = [226, 228, 232];

/// Draws lines over one pair of axes, from 0 to the largest value, and writes a PNG.
///
/// # Errors
/// [`TrainError`] when it cannot be encoded or written.
pub fn plot(lines: &[Line], path: &Path) -> Result<(), TrainError> {
    let most = |of: fn(&(f64, f64)) -> f64| {
        let all = lines.iter().flat_map(|l| &l.points).map(of).filter(|v| v.is_finite());
        all.fold(0.0, f64::max).max(1e-9)
    };
    let top = [most(|p| p.0), most(|p| p.1)];
    let mut picture = Picture::blank(SIZE, PAPER);
    grid(&mut picture, top);
    for (i, line) in lines.iter().enumerate() {
        let ink = Ink::solid(line.colour);
        for pair in line.points.windows(2) {
            stroke(&mut picture, [place(pair[0], top), place(pair[1], top)], 1.2, ink);
        }
        let at = [MARGIN[0] + 12.0 + 150.0 * i as f64, 12.0];
        write(&mut picture, at, 2.0, ink, line.name);
    }
    let png = encode_png(&picture).map_err(|e| TrainError::Plot(e.to_string()))?;
    write_whole(path, &png).map_err(TrainError::io(path))
}

/// Where a point of the plot lies, pixels.
fn place((x, y): (f64, f64), [right, top]: [f64; 2]) -> [f64; 2] {
    let wide = f64::from(SIZE[0]) - MARGIN[0] - MARGIN[2];
    let high = f64::from(SIZE[1]) - MARGIN[1] - MARGIN[3];
    let y = if y.is_finite() { y } else { top };
    [MARGIN[0] + wide * x / right, f64::from(SIZE[1]) - MARGIN[3] - high * y / top]
}

fn grid(picture: &mut Picture, [right, top]: [f64; 2]) {
    for i in 0..=4 {
        let share = f64::from(i) / 4.0;
        let [across, up] = [(right * share, 0.0), (0.0, top * share)];
        let (from, to) = (place(up, [right, top]), place((right, up.1), [right, top]));
        stroke(picture, [from, to], 0.6, Ink::solid(GRID));
        write(picture, [6.0, from[1] - 6.0], 1.6, Ink::solid(GREY), &short(up.1));
        let foot = place(across, [right, top]);
        let at = [foot[0] - 14.0, foot[1] + 12.0];
        write(picture, at, 1.6, Ink::solid(GREY), &format!("{:.0}", across.0));
    }
}

fn short(value: f64) -> String {
    if value >= 100.0 { format!("{value:.0}") } else { format!("{value:.3}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resumed_table_forgets_what_lies_beyond_the_checkpoint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut table = Table::open(&path, "step,loss", 0).unwrap();
        for step in [10, 20, 30] {
            table.add(step, &[format!("{}", step as f64 / 8.0)]).unwrap();
        }
        let mut again = Table::open(&path, "step,loss", 20).unwrap();
        assert_eq!(again.column("loss"), [(10.0, 1.25), (20.0, 2.5)]);
        again.add(30, &["7".into()]).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "step,loss\n10,1.25\n20,2.5\n30,7\n");
        std::fs::write(&path, "step,loss\nnonsense\n").unwrap();
        assert!(Table::open(&path, "step,loss", 0).is_err());
    }

    #[test]
    fn a_plot_has_ink_where_the_line_goes_and_survives_nonsense() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.png");
        let line = |points| Line { name: "loss", points, colour: [200, 30, 30] };
        plot(&[line(vec![(0.0, 4.0), (100.0, 1.0)])], &path).unwrap();
        assert!(std::fs::read(&path).unwrap().starts_with(b"\x89PNG"));
        plot(&[line(vec![]), line(vec![(0.0, f64::NAN), (1.0, f64::INFINITY)])], &path).unwrap();
    }
}
