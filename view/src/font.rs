//! A small typeface: letters on a grid of 5 by 9 dots, drawn as round strokes from dot to dot.

/// Dots across a letter.
pub const WIDE: usize = 5;
/// Dots from the top of a capital to its foot.
pub const CAPITAL: usize = 7;
/// Dots between the right edge of a letter and the left edge of the next.
pub const GAP: f64 = 2.1;
/// Width of a space, in dots.
const SPACE: f64 = 1.6;

/// Rows of five dots, the leftmost worth 16, from the top of a capital down to two rows below the
/// line.
type Dots = [u8; 9];

const BOX: Dots = [31, 17, 17, 17, 17, 17, 31, 0, 0];

/// The strokes of a character, in dots from its top left dot; a single dot is a stroke to itself.
/// Characters the typeface lacks are boxes.
pub fn strokes(character: char) -> Vec<[[f64; 2]; 2]> {
    let dots = dots(character);
    let lit = |x: isize, y: isize| {
        let row = usize::try_from(y).ok().and_then(|y| dots.get(y)).copied().unwrap_or(0);
        (0..WIDE as isize).contains(&x) && row >> (WIDE as isize - 1 - x) & 1 == 1
    };
    let mut found = Vec::new();
    for i in 0..(WIDE * dots.len()) as isize {
        let (x, y) = (i % WIDE as isize, i / WIDE as isize);
        if !lit(x, y) {
            continue;
        }
        let here = [x as f64, y as f64];
        let mut link = |dx: isize, dy: isize| {
            found.push([here, [(x + dx) as f64, (y + dy) as f64]]);
        };
        link(0, 0);
        if lit(x + 1, y) {
            link(1, 0);
        }
        if lit(x, y + 1) {
            link(0, 1);
        }
        // Dots that touch by a corner only are joined, unless a third dot already joins them.
        for dx in [-1, 1] {
            if lit(x + dx, y + 1) && !lit(x + dx, y) && !lit(x, y + 1) {
                link(dx, 1);
            }
        }
    }
    found
}

/// For each character of a text how far right its own left edge belongs, in dots, and the width of
/// the whole. Narrow letters take less room than wide ones; digits are all equally wide.
pub fn layout(text: &str) -> (Vec<f64>, f64) {
    let (mut places, mut right) = (Vec::new(), 0.0);
    for character in text.chars() {
        let [first, last] = edges(character);
        places.push(right - first);
        right += last - first + GAP;
    }
    (places, (right - GAP).max(0.0))
}

/// The leftmost and rightmost dots of a character.
fn edges(character: char) -> [f64; 2] {
    if character == ' ' {
        return [0.0, SPACE];
    }
    if character.is_ascii_digit() {
        return [0.0, (WIDE - 1) as f64];
    }
    let any = dots(character).iter().fold(0, |any, row| any | row);
    let first = any.leading_zeros().saturating_sub(u8::BITS - WIDE as u32);
    let last = (WIDE as u32 - 1).saturating_sub(any.trailing_zeros());
    [f64::from(first), f64::from(last)]
}

fn dots(character: char) -> Dots {
    match character {
        'a'..='z' => small(character),
        'A'..='Z' => capital(character),
        _ => sign(character),
    }
}

fn capital(character: char) -> Dots {
    let [a, b, c, d, e, f, g] = match character {
        'A' => [14, 17, 17, 31, 17, 17, 17],
        'B' => [30, 17, 17, 30, 17, 17, 30],
        'C' => [14, 17, 16, 16, 16, 17, 14],
        'D' => [30, 17, 17, 17, 17, 17, 30],
        'E' => [31, 16, 16, 30, 16, 16, 31],
        'F' => [31, 16, 16, 30, 16, 16, 16],
        'G' => [14, 17, 16, 23, 17, 17, 14],
        'H' => [17, 17, 17, 31, 17, 17, 17],
        'I' => [14, 4, 4, 4, 4, 4, 14],
        'J' => [1, 1, 1, 1, 1, 17, 14],
        'K' => [17, 18, 20, 24, 20, 18, 17],
        'L' => [16, 16, 16, 16, 16, 16, 31],
        'M' => [17, 27, 21, 17, 17, 17, 17],
        'N' => [17, 17, 25, 21, 19, 17, 17],
        'O' => [14, 17, 17, 17, 17, 17, 14],
        'P' => [30, 17, 17, 30, 16, 16, 16],
        'Q' => [14, 17, 17, 17, 21, 18, 13],
        'R' => [30, 17, 17, 30, 20, 18, 17],
        'S' => [15, 16, 16, 14, 1, 1, 30],
        'T' => [31, 4, 4, 4, 4, 4, 4],
        'U' => [17, 17, 17, 17, 17, 17, 14],
        'V' => [17, 17, 17, 17, 10, 10, 4],
        'W' => [17, 17, 17, 17, 21, 27, 17],
        'X' => [17, 17, 10, 4, 10, 17, 17],
        'Y' => [17, 17, 10, 4, 4, 4, 4],
        _ => [31, 1, 2, 4, 8, 16, 31],
    };
    [a, b, c, d, e, f, g, 0, 0]
}

fn small(character: char) -> Dots {
    match character {
        'a' => [0, 0, 14, 1, 15, 17, 15, 0, 0],
        'b' => [16, 16, 30, 17, 17, 17, 30, 0, 0],
        'c' => [0, 0, 14, 17, 16, 17, 14, 0, 0],
        'd' => [1, 1, 15, 17, 17, 17, 15, 0, 0],
        'e' => [0, 0, 14, 17, 31, 16, 14, 0, 0],
        'f' => [6, 8, 28, 8, 8, 8, 8, 0, 0],
        'g' => [0, 0, 15, 17, 17, 17, 15, 1, 14],
        'h' => [16, 16, 30, 17, 17, 17, 17, 0, 0],
        'i' => [4, 0, 4, 4, 4, 4, 4, 0, 0],
        'j' => [2, 0, 2, 2, 2, 2, 2, 2, 12],
        'k' => [16, 16, 18, 20, 24, 20, 18, 0, 0],
        'l' => [8, 8, 8, 8, 8, 8, 6, 0, 0],
        'm' => [0, 0, 26, 21, 21, 21, 21, 0, 0],
        'n' => [0, 0, 30, 17, 17, 17, 17, 0, 0],
        'o' => [0, 0, 14, 17, 17, 17, 14, 0, 0],
        'p' => [0, 0, 30, 17, 17, 17, 30, 16, 16],
        'q' => [0, 0, 15, 17, 17, 17, 15, 1, 1],
        'r' => [0, 0, 22, 24, 16, 16, 16, 0, 0],
        's' => [0, 0, 15, 16, 14, 1, 30, 0, 0],
        't' => [8, 8, 28, 8, 8, 8, 6, 0, 0],
        'u' => [0, 0, 17, 17, 17, 17, 15, 0, 0],
        'v' => [0, 0, 17, 17, 10, 10, 4, 0, 0],
        'w' => [0, 0, 17, 21, 21, 21, 10, 0, 0],
        'x' => [0, 0, 17, 10, 4, 10, 17, 0, 0],
        'y' => [0, 0, 17, 17, 17, 17, 15, 1, 14],
        _ => [0, 0, 31, 2, 4, 8, 31, 0, 0],
    }
}

fn sign(character: char) -> Dots {
    let [a, b, c, d, e, f, g] = match character {
        ' ' => [0; 7],
        '0' => [14, 17, 17, 17, 17, 17, 14],
        '1' => [4, 12, 4, 4, 4, 4, 14],
        '2' => [14, 17, 1, 2, 4, 8, 31],
        '3' => [14, 17, 1, 6, 1, 17, 14],
        '4' => [2, 6, 10, 18, 31, 2, 2],
        '5' => [31, 16, 30, 1, 1, 17, 14],
        '6' => [6, 8, 16, 30, 17, 17, 14],
        '7' => [31, 1, 2, 2, 4, 4, 4],
        '8' => [14, 17, 17, 14, 17, 17, 14],
        '9' => [14, 17, 17, 15, 1, 2, 12],
        '.' => [0, 0, 0, 0, 0, 0, 4],
        ':' => [0, 0, 4, 0, 0, 0, 4],
        '/' => [1, 1, 2, 4, 8, 16, 16],
        '-' => [0, 0, 0, 14, 0, 0, 0],
        '+' => [0, 4, 4, 31, 4, 4, 0],
        '=' => [0, 0, 31, 0, 31, 0, 0],
        '%' => [24, 25, 2, 4, 8, 19, 3],
        '#' => [10, 10, 31, 10, 31, 10, 10],
        '\'' => [4, 4, 0, 0, 0, 0, 0],
        '"' => [10, 10, 0, 0, 0, 0, 0],
        '!' => [4, 4, 4, 4, 4, 0, 4],
        '?' => [14, 17, 1, 2, 4, 0, 4],
        '(' => [2, 4, 8, 8, 8, 4, 2],
        ')' => [8, 4, 2, 2, 2, 4, 8],
        '<' => [0, 2, 4, 8, 4, 2, 0],
        '>' => [0, 8, 4, 2, 4, 8, 0],
        '°' => [6, 9, 9, 6, 0, 0, 0],
        '·' => [0, 0, 0, 4, 0, 0, 0],
        '_' => return [0, 0, 0, 0, 0, 0, 0, 31, 0],
        ',' => return [0, 0, 0, 0, 0, 0, 4, 8, 0],
        _ => return BOX,
    };
    [a, b, c, d, e, f, g, 0, 0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_l_is_one_upright_and_one_foot() {
        let joins: Vec<_> = strokes('L').into_iter().filter(|[a, b]| a != b).collect();
        assert_eq!(joins.len(), 6 + 4);
        assert!(joins.iter().all(|[a, b]| a[0] == b[0] || a[1] == b[1]));
    }

    #[test]
    fn every_character_we_write_has_a_shape_of_its_own() {
        let text =
            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNPQRSTUVWXYZ0123456789.:/-+=%#'\"!?()<>_,°·";
        let shapes: std::collections::BTreeSet<_> = text.chars().map(dots).collect();
        assert_eq!(shapes.len(), text.chars().count());
        assert_eq!(strokes('\u{1F600}'), strokes('\u{2603}'), "what is missing is a box");
        assert!(strokes(' ').is_empty());
    }

    #[test]
    fn narrow_letters_take_less_room_and_all_digits_the_same() {
        assert_eq!(layout("i"), (vec![-2.0], 0.0));
        assert_eq!(layout("mi").1, 4.0 + GAP);
        assert_eq!(layout("11").1, layout("88").1);
        assert_eq!(layout("").1, 0.0);
    }
}
