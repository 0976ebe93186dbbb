//! Words that say where a part is, relative to others of its kind: left, upper, second, inner.

use object::DVec3;

/// Rows are told apart where heights differ by more than this share of the set's extent.
const ROW: f64 = 0.08;

/// Where a text says its part is, as seen by who stands before the object.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// Left is −x, right +x, front −y, rear +y, lower −z, upper +z; zero where nothing is said.
    pub towards: DVec3,
    /// Whether it is in the middle.
    pub middle: bool,
    /// Inner is −1, outer +1, zero where nothing is said.
    pub outward: f64,
    /// Its place in the row from the top or the left, the first being 0.
    pub ordinal: Option<usize>,
    /// The number it ends in.
    pub number: Option<usize>,
}

const DIRECTIONS: [(&str, DVec3); 14] = [
    ("left", DVec3::NEG_X),
    ("lefthand", DVec3::NEG_X),
    ("right", DVec3::X),
    ("righthand", DVec3::X),
    ("front", DVec3::NEG_Y),
    ("near", DVec3::NEG_Y),
    ("rear", DVec3::Y),
    ("back", DVec3::Y),
    ("far", DVec3::Y),
    ("top", DVec3::Z),
    ("upper", DVec3::Z),
    ("bottom", DVec3::NEG_Z),
    ("lower", DVec3::NEG_Z),
    ("lowest", DVec3::NEG_Z),
];
const MIDDLES: [&str; 5] = ["middle", "mid", "center", "centre", "central"];
const ORDINALS: [&str; 8] =
    ["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth"];

impl Place {
    /// Reads a text.
    pub(crate) fn of(text: &str) -> Self {
        let lower = text.to_lowercase();
        let words = lower.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty());
        let mut place = Self::default();
        for word in words {
            place.hear(word);
        }
        place.towards = place.towards.clamp(DVec3::NEG_ONE, DVec3::ONE);
        place
    }

    fn hear(&mut self, word: &str) {
        if let Some((_, direction)) = DIRECTIONS.iter().find(|(w, _)| *w == word) {
            self.towards += direction;
        }
        if let Some(n) = ORDINALS.iter().position(|w| *w == word) {
            self.ordinal = Some(n);
        }
        if let Ok(n) = word.parse() {
            self.number = Some(n);
        }
        self.middle |= MIDDLES.contains(&word);
        self.outward += match word {
            "inner" | "inside" => -1.0,
            "outer" | "outside" => 1.0,
            _ => 0.0,
        };
    }
}

/// Gives each of some parts with like words one of as many spots, so that words such as `left` and
/// `upper` agree best with where the spots lie. Spots are centres in the object frame, metres.
///
/// Parts whose words say nothing take the spots that are left, in order of their numbers, from the
/// top, the left and the front. `worth` adds whatever else a spot is worth to a part.
///
/// Returns for each part the index of its spot.
pub(crate) fn arrange(places: &[Place], spots: &[DVec3], worth: &[Vec<f64>]) -> Vec<usize> {
    let row = in_rows(spots);
    let ranks = ranks(places);
    let mut spot_of = vec![0; places.len()];
    for (part, &rank) in ranks.iter().enumerate() {
        spot_of[part] = row[rank.min(row.len().saturating_sub(1))];
    }
    let mut fits = fits(places, &ranks, &row, spots);
    for (fits, worth) in fits.iter_mut().zip(worth) {
        fits.iter_mut().zip(worth).for_each(|(fit, more)| *fit += more);
    }
    loop {
        let mut best = (1e-9, None);
        for a in 0..places.len() {
            for b in a + 1..places.len() {
                let gain = fits[a][spot_of[b]] + fits[b][spot_of[a]]
                    - fits[a][spot_of[a]]
                    - fits[b][spot_of[b]];
                if gain > best.0 {
                    best = (gain, Some((a, b)));
                }
            }
        }
        let Some((a, b)) = best.1 else { return spot_of };
        spot_of.swap(a, b);
    }
}

/// How well each part's words fit each spot.
fn fits(places: &[Place], ranks: &[usize], row: &[usize], spots: &[DVec3]) -> Vec<Vec<f64>> {
    let low = spots.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = spots.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (centre, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let widest = half.max_element().max(f64::MIN_POSITIVE);
    let radius = |p: DVec3| ((p - centre).length() / widest).min(2.0);
    let step = 1.0 / (spots.len().max(2) - 1) as f64;
    let fit = |place: &Place, rank: usize, spot: usize| {
        let off = (spots[spot] - centre) / half.max(DVec3::splat(0.02 * widest));
        let turn = row.iter().position(|&s| s == spot).unwrap_or(0) as f64 * step;
        let away = |wanted: f64| (turn - wanted).abs();
        let mut fit = place.towards.dot(off) + place.outward * radius(spots[spot]);
        fit -= if place.middle { 2.0 * away(0.5) } else { 0.0 };
        fit -= place.ordinal.map_or(0.0, |n| 2.0 * away(n as f64 * step));
        fit - 1e-3 * away(rank as f64 * step)
    };
    let of_part =
        |(place, &rank): (&Place, &usize)| (0..spots.len()).map(|s| fit(place, rank, s)).collect();
    places.iter().zip(ranks).map(of_part).collect()
}

/// The turn of each part: in order of number where one is said, as listed otherwise.
fn ranks(places: &[Place]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|&p| (places[p].number.unwrap_or(0), p));
    let mut ranks = vec![0; places.len()];
    order.iter().enumerate().for_each(|(turn, &p)| ranks[p] = turn);
    ranks
}

/// The spots row by row from the top, each row from the left, then from the front.
fn in_rows(spots: &[DVec3]) -> Vec<usize> {
    let low = spots.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = spots.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let gap = ROW * (high - low).max_element();
    let mut order: Vec<usize> = (0..spots.len()).collect();
    order.sort_by(|&a, &b| spots[b].z.total_cmp(&spots[a].z).then(a.cmp(&b)));
    let mut rows: Vec<Vec<usize>> = Vec::new();
    let mut last = f64::INFINITY;
    for s in order {
        match rows.last_mut() {
            Some(row) if last - spots[s].z <= gap => row.push(s),
            _ => rows.push(vec![s]),
        }
        last = spots[s].z;
    }
    let from_left = |a: &usize, b: &usize| {
        let (p, q) = (spots[*a], spots[*b]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.cmp(b))
    };
    rows.iter_mut().for_each(|row| row.sort_by(from_left));
    rows.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arranged(texts: &[&str], spots: &[[f64; 3]]) -> Vec<usize> {
        let places: Vec<Place> = texts.iter().map(|t| Place::of(t)).collect();
        let spots: Vec<DVec3> = spots.iter().map(|s| DVec3::from_array(*s)).collect();
        arrange(&places, &spots, &[])
    }

    const PAIR: [[f64; 3]; 2] = [[0.5, 0.0, 1.0], [-0.5, 0.0, 1.0]];

    #[test]
    fn left_is_to_the_left_of_who_stands_before_it_and_swaps_with_the_words() {
        assert_eq!(arranged(&["left drawer", "right drawer"], &PAIR), [1, 0]);
        assert_eq!(arranged(&["right drawer", "left drawer"], &PAIR), [0, 1]);
        assert_eq!(arranged(&["drawer", "left drawer"], &PAIR), [0, 1]);
    }

    #[test]
    fn a_stack_counts_from_the_top() {
        let stack = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.9], [0.0, 0.0, 0.3], [0.0, 0.0, 0.6]];
        let texts = ["top drawer", "second drawer", "third drawer", "bottom drawer"];
        assert_eq!(arranged(&texts, &stack), [1, 3, 2, 0]);
        let texts = ["bottom drawer", "third drawer", "second drawer", "upper drawer"];
        assert_eq!(arranged(&texts, &stack), [0, 2, 3, 1]);
    }

    #[test]
    fn numbers_run_row_by_row_from_the_top_left() {
        let pad = [[0.1, 0.0, 0.0], [0.0, 0.0, 0.1], [0.0, 0.0, 0.0], [0.1, 0.0, 0.101]];
        let texts = ["button 4", "button 1", "button 3", "button 2"];
        assert_eq!(arranged(&texts, &pad), [0, 1, 2, 3]);
    }

    #[test]
    fn corners_middles_and_insides_are_found() {
        let car = [[1.0, 2.0, 0.0], [-1.0, -2.0, 0.0], [1.0, -2.0, 0.0], [-1.0, 2.0, 0.0]];
        let texts =
            ["rear left wheel", "front left wheel", "rear right wheel", "front right wheel"];
        assert_eq!(arranged(&texts, &car), [3, 1, 0, 2]);
        let row = [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        assert_eq!(arranged(&["middle knob", "left knob", "right knob"], &row), [0, 1, 2]);
        assert_eq!(arranged(&["outer ring", "inner ring", "outer ring"], &row)[1], 0);
        assert!(arranged(&[], &[]).is_empty());
    }
}
