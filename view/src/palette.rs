//! Colours that tell parts apart: the first dozen chosen by eye, the rest as far from them as can
//! be, always the same.

use std::sync::LazyLock;

/// How many colours there are before they repeat.
pub const COLOURS: usize = 96;

/// Hand-picked: part 0 (the base) a quiet grey blue, then strong, friendly, distinct hues.
const CHOSEN: [[u8; 3]; 12] = [
    [178, 186, 198],
    [38, 118, 214],
    [247, 146, 30],
    [52, 168, 83],
    [222, 55, 60],
    [140, 82, 200],
    [0, 176, 190],
    [250, 202, 22],
    [236, 98, 170],
    [138, 90, 52],
    [164, 204, 58],
    [26, 72, 110],
];

static PALETTE: LazyLock<Vec<[u8; 3]>> = LazyLock::new(palette);

/// The sRGB colour of a part. Distinct for the first [`COLOURS`] parts, then they come round again,
/// without part 0's.
pub fn part_colour(part: usize) -> [u8; 3] {
    let index = if part < COLOURS { part } else { 1 + (part - COLOURS) % (COLOURS - 1) };
    PALETTE.get(index).copied().unwrap_or(CHOSEN[0])
}

/// Starting from the chosen colours, always adds the candidate that is furthest from all so far.
fn palette() -> Vec<[u8; 3]> {
    let candidates = candidates();
    let mut palette = CHOSEN.to_vec();
    let mut nearest: Vec<f64> = candidates.iter().map(|c| nearest_of(&palette, *c)).collect();
    while palette.len() < COLOURS {
        let further = |a: usize, b: usize| if nearest[b] > nearest[a] { b } else { a };
        let best = candidates[(0..candidates.len()).fold(0, further)];
        palette.push(best);
        for (distance, c) in nearest.iter_mut().zip(&candidates) {
            *distance = distance.min(difference(best, *c));
        }
    }
    palette
}

fn nearest_of(palette: &[[u8; 3]], colour: [u8; 3]) -> f64 {
    palette.iter().map(|p| difference(*p, colour)).fold(f64::INFINITY, f64::min)
}

/// A grid of colours that are neither near black nor near white nor near the background.
fn candidates() -> Vec<[u8; 3]> {
    let step = |i: usize| (i * 15) as u8;
    let all = (0..18 * 18 * 18).map(|i| [step(i % 18), step(i / 18 % 18), step(i / 324)]);
    all.filter(|&c| {
        let [l, a, b] = oklab(c);
        (0.36..0.90).contains(&l) && a.hypot(b) > 0.05
    })
    .collect()
}

/// How different two sRGB colours look: distance in OKLab (0 for the same, 1 for black and white).
pub fn difference(a: [u8; 3], b: [u8; 3]) -> f64 {
    let (a, b) = (oklab(a), oklab(b));
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Björn Ottosson's OKLab.
fn oklab(colour: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = colour.map(|c| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    });
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    [
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_and_white_are_one_apart() {
        assert!((difference([0; 3], [255; 3]) - 1.0).abs() < 1e-6);
        assert_eq!(difference([9, 8, 7], [9, 8, 7]), 0.0);
    }

    #[test]
    fn sixty_four_parts_all_look_different() {
        let least = (0..64)
            .flat_map(|i| (0..i).map(move |j| difference(part_colour(i), part_colour(j))))
            .fold(f64::INFINITY, f64::min);
        assert!(least > 0.055, "two colours are only {least} apart");
    }

    #[test]
    fn colours_repeat_without_the_base() {
        assert_eq!(part_colour(COLOURS), part_colour(1));
        assert_eq!(part_colour(65_535), part_colour(65_535));
        assert_ne!(part_colour(2 * COLOURS - 1), part_colour(0));
    }
}
