//! How an asset looks, in 128 bits: near-duplicates differ in a few of them.

use image::{GenericImageView as _, Pixel as _};

use crate::stages::bundle::Files;

/// Pictures that are looked at: two sides that tell most.
const SIDES: [&str; 2] = ["views/front.png", "views/right.png"];
/// Most bits in which near-duplicates differ, of 128.
pub const NEAR: u32 = 6;

/// The hash of an asset's look, as 32 hexadecimal digits; none without its pictures.
pub fn look(files: &Files) -> Option<String> {
    let side = |name: &str| files.get(name).and_then(|png| side(png));
    let [front, right] = SIDES.map(side);
    Some(format!("{:016x}{:016x}", front?, right?))
}

/// The hash of a picture: whether it grows brighter from each of 9 x 8 fields to the one beside it.
fn side(png: &[u8]) -> Option<u64> {
    let picture = image::load_from_memory(png).ok()?;
    let (width, height) = picture.dimensions();
    let place =
        |n: u32, of: u32, length: u32| u64::from(length) * u64::from(2 * n + 1) / u64::from(2 * of);
    // What a field's pixels come to, of 16 rows with 16 each: a batch looks at every asset it makes.
    let field = |x: u32, y: u32| -> u32 {
        let across = (0..16).map(|n| place(16 * x + n, 9 * 16, width) as u32);
        let down =
            |column| (0..16).map(move |n| (column, place(16 * y + n, 8 * 16, height) as u32));
        across.flat_map(down).map(|(x, y)| u32::from(picture.get_pixel(x, y).to_luma()[0])).sum()
    };
    let brighter = |n: u32| {
        let (x, y) = (n % 8, n / 8);
        u64::from(field(x + 1, y) > field(x, y) + 2 * 256) << n
    };
    Some((0..64).map(brighter).sum())
}

/// In how many bits two looks differ; none if one is no look.
pub fn distance(a: &str, b: &str) -> Option<u32> {
    Some((bits(a)? ^ bits(b)?).count_ones())
}

/// For each look the first earlier one it is near to, by index.
///
/// Two looks that differ in at most [`NEAR`] bits have at least one of `NEAR + 1` bands in common,
/// so only those that share a band are compared.
pub fn near_duplicates(looks: &[Option<String>]) -> Vec<Option<usize>> {
    let bands = NEAR + 1;
    let width = 128_u32.div_ceil(bands);
    let mut seen: std::collections::BTreeMap<(u32, u128), Vec<usize>> = Default::default();
    let mut found = Vec::with_capacity(looks.len());
    for (n, look) in looks.iter().enumerate() {
        let Some(own) = look.as_deref().and_then(bits) else {
            found.push(None);
            continue;
        };
        let keys: Vec<_> = (0..bands)
            .map(|band| (band, (own >> (band * width).min(127)) & ((1 << width) - 1)))
            .collect();
        let near = |m: &usize| {
            let other = looks.get(*m).and_then(|l| l.as_deref()).and_then(bits);
            other.is_some_and(|other| (own ^ other).count_ones() <= NEAR)
        };
        let first = keys.iter().filter_map(|key| seen.get(key)?.iter().copied().find(near)).min();
        if first.is_none() {
            // Only firsts are kept: what is near to a near one is most often near to the first.
            keys.into_iter().for_each(|key| seen.entry(key).or_default().push(n));
        }
        found.push(first);
    }
    found
}

fn bits(look: &str) -> Option<u128> {
    u128::from_str_radix(look, 16).ok().filter(|_| look.len() == 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look_of(bits: u128) -> Option<String> {
        Some(format!("{bits:032x}"))
    }

    #[test]
    fn near_looks_are_found_and_far_ones_are_not() {
        let one = 0x0123_4567_89ab_cdef_0123_4567_89ab_cdef_u128;
        let near = one ^ 0b111 ^ (0b111 << 125);
        let far = one ^ 0b1111 ^ (0b111 << 125);
        let looks = [look_of(one), None, look_of(near), look_of(far), look_of(one)];
        assert_eq!(near_duplicates(&looks), [None, None, Some(0), None, Some(0)]);
        assert_eq!(distance(&looks[0].clone().unwrap(), &looks[3].clone().unwrap()), Some(7));
        assert_eq!(distance("no look", "00"), None);
    }

    #[test]
    fn bands_cover_every_bit() {
        for bit in 0..128 {
            let looks = [look_of(0), look_of(1 << bit)];
            assert_eq!(near_duplicates(&looks)[1], Some(0), "bit {bit}");
        }
    }

    #[test]
    fn a_look_is_the_same_for_the_same_pictures_and_none_without() {
        let png = |left: u8| {
            let picture = image::GrayImage::from_fn(90, 80, |x, y| {
                image::Luma([if x < 45 { left } else { (x + y) as u8 }])
            });
            let mut bytes = std::io::Cursor::new(Vec::new());
            picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
            bytes.into_inner()
        };
        let files = |left| Files::from(SIDES.map(|s| (s.to_string(), png(left))));
        assert_eq!(look(&files(9)), look(&files(9)));
        assert_ne!(look(&files(9)), look(&files(250)));
        assert_eq!(look(&Files::new()), None);
    }
}
