//! From a sample to a lesson: what the network is shown of it this time, and what it should answer
//! (paper, appendix A.1).

mod settings;
mod targets;
mod view;

use model::features::{FeatureError, NgramText, TextFeatures};
use model::net::{Example, PartPrompt};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

use crate::dataset::Sample;
pub use settings::Augment;
pub use targets::Target;
use targets::targets;
use view::View;

/// A common multiple of how many wordings parts have.
const STYLES: usize = 5_040;

/// How many points a lesson shows and asks about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LessonSize {
    /// N, points the shape is seen through.
    pub points: usize,
    /// M, points asked about.
    pub queries: usize,
    /// How many of those are spread over the parts evenly instead of by area.
    pub balanced: usize,
    /// Most parts.
    pub parts: usize,
}

/// One object, the questions about it, and the answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lesson {
    /// What the network is shown and asked.
    pub example: Example,
    /// The part of each query.
    pub labels: Vec<u16>,
    /// The joint truth at each query of each joint question, in their order.
    pub targets: Vec<Target>,
}

/// Makes a lesson; the same generator state gives the same lesson.
///
/// # Errors
/// [`LessonError`] when the object has too many parts or too few points.
pub fn lesson(
    sample: &Sample,
    augment: &Augment,
    size: LessonSize,
    rng: &mut Pcg64Mcg,
) -> Result<Lesson, LessonError> {
    let view = View::draw(sample, augment, rng);
    if view.parts.len() > size.parts {
        return Err(LessonError::Parts { most: size.parts, found: view.parts.len() });
    }
    let shape = shown(sample, size, rng);
    let queries = asked(sample, &view, size, rng);
    if shape.is_empty() || queries.is_empty() {
        return Err(LessonError::NoPoints);
    }
    let labels: Vec<u16> = queries.iter().map(|&q| view.label(sample, q)).collect();
    let (joints, targets) = targets(sample, &view, &queries, &labels);
    let parts = prompts(sample, &view, augment, rng)?;
    let points = |of: &[usize]| view.points(sample, of);
    let example = Example { shape: points(&shape), parts, queries: points(&queries), joints };
    Ok(Lesson { example, labels, targets })
}

/// Why a sample makes no lesson.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LessonError {
    /// More parts than the network takes.
    #[error("an object may have at most {most} parts, found {found}")]
    Parts {
        /// The limit.
        most: usize,
        /// What was found.
        found: usize,
    },
    /// Nothing to show.
    #[error("the sample has no points")]
    NoPoints,
    /// A text that cannot be embedded.
    #[error(transparent)]
    Text(#[from] FeatureError),
}

/// Indices of points spread by area; all of them, over and over, where there are too few.
fn shown(sample: &Sample, size: LessonSize, rng: &mut Pcg64Mcg) -> Vec<usize> {
    pick(&mut (0..sample.even).collect::<Vec<_>>(), size.points, rng)
}

/// Indices of the queries: most by area, some from every part alike.
fn asked(sample: &Sample, view: &View, size: LessonSize, rng: &mut Pcg64Mcg) -> Vec<usize> {
    let balanced = size.balanced.min(size.queries);
    let mut all = pick(&mut (0..sample.even).collect::<Vec<_>>(), size.queries - balanced, rng);
    let mut of_part = view.points_of_parts(sample);
    of_part.retain(|points| !points.is_empty());
    for i in 0..if of_part.is_empty() { 0 } else { balanced } {
        let points = &of_part[i % of_part.len()];
        all.push(points[rng.random_range(0..points.len())]);
    }
    all
}

/// `count` of these without repetition, or all of them over and over if they are fewer.
fn pick(from: &mut [usize], count: usize, rng: &mut Pcg64Mcg) -> Vec<usize> {
    if from.is_empty() {
        return vec![];
    }
    let first = count.min(from.len());
    let (chosen, _) = from.partial_shuffle(rng, first);
    chosen.iter().copied().cycle().take(count).collect()
}

/// A text, a point or both for every part.
fn prompts(
    sample: &Sample,
    view: &View,
    augment: &Augment,
    rng: &mut Pcg64Mcg,
) -> Result<Vec<PartPrompt>, LessonError> {
    let style = rng.random_range(0..STYLES);
    let texts: Vec<&str> = view.parts.iter().map(|p| wording(&p.wordings, style)).collect();
    let of_part = view.points_of_parts(sample);
    let prompt = |(p, text): (usize, &&str)| {
        let twin = texts.iter().enumerate().any(|(q, t)| q != p && kind(t) == kind(text));
        let [text_gone, point_gone] = [augment.no_text, augment.no_point].map(|p| p > rng.random());
        let embedded = (!text.is_empty()).then(|| NgramText.embed(text)).transpose()?;
        let point =
            (!of_part[p].is_empty()).then(|| of_part[p][rng.random_range(0..of_part[p].len())]);
        let point_gone = point_gone && !twin && embedded.is_some();
        let text_gone = text_gone && !point_gone && point.is_some();
        Ok(PartPrompt {
            text: embedded.filter(|_| !text_gone),
            point: point.filter(|_| !point_gone).map(|q| view.points(sample, &[q])),
        })
    };
    texts.iter().enumerate().map(prompt).collect()
}

/// The way this style says it: alike for parts that are alike, so that `knob 1` does not stand
/// beside `stove knob 2`.
fn wording(wordings: &[String], style: usize) -> &str {
    wordings.get(style % wordings.len().max(1)).map_or("", String::as_str)
}

/// A text without its numbers: `cabin 3` says no more about where it is than `cabin 4`.
fn kind(text: &str) -> String {
    let letters: String = text.chars().filter(|c| !c.is_ascii_digit()).collect();
    letters.trim().to_lowercase()
}

#[cfg(test)]
mod tests;
