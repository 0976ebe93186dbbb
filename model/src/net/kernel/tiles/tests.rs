//! What TDPBF16PS does, by the manual, and that the processor does the same.

use super::super::tests::numbers;
use super::*;

/// What kinds of numbers there are in tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kinds {
    /// Between −1 and 1.
    Usual,
    /// Of any size below 2, denormal ones among them.
    Small,
    /// Of about 2⁻⁶⁵, so that products and sums lie on both sides of the smallest normal number.
    Tiny,
    /// All that bf16 has.
    All,
}

/// Tiles of pairs that look random.
fn tiles(count: usize, seed: u32, kinds: Kinds) -> Vec<Tile> {
    let bits = |x: f32| {
        // 24 random bits, and by an odd factor all 32
        let spread = (((x + 1.0) * (1 << 23) as f32) as u32).wrapping_mul(0x9e37_79b9);
        match kinds {
            Kinds::Usual => x.to_bits(),
            Kinds::Small => spread & 0xbfff_ffff,
            Kinds::Tiny => spread & 0x807f_ffff | (58 + (spread >> 23 & 7)) << 23,
            Kinds::All => spread,
        }
    };
    let numbers = numbers(2 * count * SIDE * SIDE, seed);
    let mut pairs =
        numbers.as_chunks::<2>().0.iter().map(|&[x, y]| bits(x) >> 16 | bits(y) & 0xffff_0000);
    let mut tile = || Tile([(); SIDE].map(|()| [(); SIDE].map(|()| pairs.next().unwrap_or(0))));
    (0..count).map(|_| tile()).collect()
}

fn multiplied(tiles: &mut dyn Tiles, factors: &[Vec<Tile>; 4]) -> Block {
    let [a0, a1, b0, b1] = factors.each_ref().map(Vec::as_slice);
    let mut sums = NOTHING;
    tiles.multiply([a0, a1], [b0, b1], &mut sums);
    sums
}

fn bits(sums: &Block) -> Vec<u32> {
    sums.iter().flat_map(|s| s.0.as_flattened()).map(|x| x.to_bits()).collect()
}

/// One product of tiles that are zero but for their first rows and columns.
fn of_pairs(a: [f32; 2], b: [f32; 2]) -> f32 {
    let pair = |x: [f32; 2]| x[0].to_bits() >> 16 | x[1].to_bits() & 0xffff_0000;
    let tile = |x| {
        let mut tile = Tile([[0; SIDE]; SIDE]);
        tile.0[0][0] = pair(x);
        vec![tile]
    };
    let factors = [tile(a), tile(a), tile(b), tile(b)];
    multiplied(&mut Plain, &factors)[0].0[0][0]
}

#[test]
fn a_pair_of_products_is_summed_and_what_is_too_small_is_zero() {
    assert_eq!(of_pairs([3.0, -0.5], [2.0, 7.0]), 2.5);
    let small = f32::MIN_POSITIVE;
    assert_eq!(of_pairs([small, 0.0], [1.0, 0.0]), small);
    assert_eq!(of_pairs([small, 0.0], [0.5, 0.0]), 0.0, "a result that is denormal");
    assert_eq!(of_pairs([small / 2.0, 0.0], [1e9, 0.0]), 0.0, "a factor that is denormal");
    assert_eq!(of_pairs([1.5 * small, small], [1.0, -1.0]), 0.0, "a sum that is denormal");
    assert!(of_pairs([f32::INFINITY, 0.0], [0.0, 1.0]).is_nan());
    assert_eq!(of_pairs([f32::MAX, f32::MAX], [2.0, 1.0]), f32::INFINITY);
}

#[test]
fn plain_tiles_are_right_by_the_definition_of_a_product() {
    let factors = [1, 2, 3, 4].map(|seed| tiles(3, seed, Kinds::Usual));
    let number = |pair: u32, half: usize| {
        f64::from(f32::from_bits(if half == 0 { pair << 16 } else { pair & 0xffff_0000 }))
    };
    for (of, sums) in multiplied(&mut Plain, &factors).iter().enumerate() {
        let (a, b) = (&factors[of / 2], &factors[2 + of % 2]);
        for (m, n) in (0..SIDE).flat_map(|m| (0..SIDE).map(move |n| (m, n))) {
            let k = (0..3).flat_map(|t| (0..SIDE).flat_map(move |p| [(t, p, 0), (t, p, 1)]));
            let truth: f64 =
                k.map(|(t, p, half)| number(a[t].0[m][p], half) * number(b[t].0[p][n], half)).sum();
            assert!((f64::from(sums.0[m][n]) - truth).abs() < 1e-5);
        }
    }
}

#[test]
fn every_instruction_set_gives_the_plain_tiles_the_same_bits() {
    for kinds in [Kinds::Usual, Kinds::Small, Kinds::Tiny, Kinds::All] {
        let factors = [5, 6, 7, 8].map(|seed| tiles(3, seed, kinds));
        let mut sums = NOTHING[0];
        Column { a: &factors[0], b: &factors[2], sums: &mut sums }.run();
        let found = multiplied(&mut Plain, &factors)[0];
        assert!(same(&[found; 4], &[sums; 4]), "{kinds:?}");
    }
}

/// Whether all sums are the same bits, any NaN being as good as another.
fn same(a: &Block, b: &Block) -> bool {
    let whole = |block: &Block| -> Vec<u32> {
        let plain = |&bits: &u32| if f32::from_bits(bits).is_nan() { u32::MAX } else { bits };
        bits(block).iter().map(plain).collect()
    };
    whole(a) == whole(b)
}

#[test]
fn the_processor_multiplies_as_the_plain_tiles_do() {
    if !at_hand() {
        eprintln!("SKIPPED: the processor's tiles, it has none or the system does not allow them");
        return;
    }
    let kinds = [Kinds::Usual, Kinds::Small, Kinds::Tiny, Kinds::All];
    for (run, kinds) in [0, 1, 2, 97].into_iter().flat_map(|run| kinds.map(|kinds| (run, kinds))) {
        let factors = [1, 2, 3, 4].map(|seed| tiles(run, seed + run as u32, kinds));
        let plain = multiplied(&mut Plain, &factors);
        with_tiles(|tiles| {
            let found = multiplied(tiles, &factors);
            assert!(same(&found, &plain), "{run} tiles, {kinds:?}");
            with_tiles(|others| {
                assert!(same(&multiplied(others, &factors), &plain), "a second one at a time");
            });
            assert!(same(&multiplied(tiles, &factors), &plain), "after a second one");
        });
    }
}
