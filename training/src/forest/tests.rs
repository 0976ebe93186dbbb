//! Trees that grow: what they learn, and that they always learn the same.

use super::*;

const N: usize = 12;

const GROWTH: Growth = Growth {
    trees: 40,
    leaves: 4,
    rate: 0.3,
    questions: 0.8,
    numbers: 1.0,
    curve: 0.1,
    hold: 0.1,
    seed: 3,
};

/// The right row is the one whose numbers 2 and 7 have one sign: no line tells it.
fn asked(object: usize) -> Vec<Question<N>> {
    let row = |a: f32, b: f32| {
        let mut numbers = [0.0; N];
        (numbers[2], numbers[7], numbers[9]) = (a, b, object as f32);
        numbers
    };
    let size = 0.1 + object as f32 / 50.0;
    let one = |k: usize| {
        let right = if k.is_multiple_of(2) { row(size, size) } else { row(-size, -size) };
        let numbers = vec![row(size, -size), right, row(-size, size)];
        Question { weight: 0.5 + k as f32, truth: vec![0.0, 1.0, 0.0], numbers }
    };
    (0..4).map(one).collect()
}

fn lessons(bins: &Bins<N>) -> Lessons<'_, N> {
    let mut lessons = Lessons::new(bins);
    (0..30).for_each(|object| lessons.add(&asked(object)));
    lessons
}

fn bins() -> Bins<N> {
    let all: Vec<Question<N>> = (0..30).flat_map(asked).collect();
    Bins::of(all.iter().flat_map(|q| &q.numbers))
}

#[test]
fn a_forest_learns_what_no_line_tells_and_says_so_of_new_rows() {
    let bins = bins();
    let mut losses = Vec::new();
    let forest = lessons(&bins).grow(&GROWTH, |_| true, |_, loss| losses.push(loss));
    assert_eq!(forest.trees.len(), GROWTH.trees);
    assert!((losses[0] - 3f64.ln()).abs() < 1e-5, "{}", losses[0]);
    assert!(losses[39] < 0.1 * losses[0], "{losses:?}");
    for question in asked(77) {
        let scores: Vec<f32> = question.numbers.iter().map(|n| forest.score(n)).collect();
        assert!(scores[1] > scores[0] + 1.0 && scores[1] > scores[2] + 1.0, "{scores:?}");
    }
}

#[test]
fn the_same_lessons_and_seed_give_the_same_forest() {
    let bins = bins();
    let lessons = lessons(&bins);
    let one = lessons.grow(&GROWTH, |_| true, |_, _| ());
    let threads = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(threads.install(|| lessons.grow(&GROWTH, |_| true, |_, _| ())), one);
    assert_ne!(lessons.grow(&Growth { seed: 4, ..GROWTH }, |_| true, |_, _| ()), one);
}

#[test]
fn a_row_that_may_be_wrong_is_held_against_nothing() {
    let asked = |object: usize| {
        let right = object.is_multiple_of(3);
        let mut numbers = [0.0; N];
        numbers[4] = f32::from(u8::from(right));
        let share = if right { 0.75 } else { 0.125 };
        vec![Question { weight: 1.0, truth: vec![share, 1.0 - share], numbers: vec![numbers] }]
    };
    let all: Vec<Question<N>> = (0..60).flat_map(asked).collect();
    let bins = Bins::of(all.iter().flat_map(|q| &q.numbers));
    let mut lessons = Lessons::new(&bins);
    (0..60).for_each(|object| lessons.add(&asked(object)));
    let forest = lessons.grow(&GROWTH, |_| true, |_, _| ());
    for object in [0, 1] {
        let [question] = &asked(object)[..] else { panic!() };
        let said = 1.0 / (1.0 + (-forest.score(&question.numbers[0])).exp());
        assert!((said - question.truth[0]).abs() < 0.02, "{said}");
    }
}

#[test]
fn what_a_forest_may_not_know_does_not_matter() {
    let bins = bins();
    let mut fewer = Lessons::new(&bins);
    (0..20).for_each(|object| fewer.add(&asked(object)));
    let known = lessons(&bins).grow(&GROWTH, |object| object < 20, |_, _| ());
    assert_eq!(fewer.grow(&GROWTH, |_| true, |_, _| ()), known);
}

#[test]
fn bins_part_where_rows_part() {
    let few = edges(vec![1.0, 3.0, 1.0, 2.0]);
    assert_eq!(few, [1.5, 2.5]);
    assert!(edges(vec![4.0; 9]).is_empty());
    let many = edges((0..100_000).map(|i| i as f32).collect());
    assert_eq!(many.len(), BINS - 1);
    assert!(many.windows(2).all(|p| (p[1] - p[0] - 781.25).abs() < 2.0), "{many:?}");
}

#[test]
fn growth_that_grows_nothing_is_refused_by_name() {
    assert_eq!(GROWTH.check(), Ok(()));
    let told = |growth: Growth| growth.check().unwrap_err();
    assert!(told(Growth { trees: 0, ..GROWTH }).contains("`trees` must be from 1 to"));
    assert!(told(Growth { leaves: 1, ..GROWTH }).contains("`leaves`"));
    assert!(told(Growth { rate: 1.5, ..GROWTH }).contains("`rate`"));
    let none = told(Growth { numbers: f64::NAN, ..GROWTH });
    assert_eq!(none, "`features` must be above 0 and at most 1, found NaN");
    assert!(told(Growth { hold: -1.0, ..GROWTH }).contains("`hold` must be 0 or more"));
}

#[test]
fn lessons_have_one_digest_until_anything_in_them_differs() {
    let bins = bins();
    let digest = |lessons: &Lessons<'_, N>| {
        let mut hasher = blake3::Hasher::new();
        lessons.hash_into(&mut hasher);
        hasher.finalize()
    };
    let whole = digest(&lessons(&bins));
    assert_eq!(digest(&lessons(&bins)), whole);
    let other = |change: fn(&mut Question<N>)| {
        let mut lessons = Lessons::new(&bins);
        for object in 0..30 {
            let mut asked = asked(object);
            change(&mut asked[0]);
            lessons.add(&asked);
        }
        digest(&lessons)
    };
    assert_eq!(other(|_| ()), whole);
    assert_ne!(other(|q| q.weight *= 2.0), whole);
    assert_ne!(other(|q| q.truth.swap(0, 1)), whole);
    assert_ne!(other(|q| q.numbers.swap(0, 1)), whole);
    let mut together = Lessons::new(&bins);
    together.add(&(0..30).flat_map(asked).collect::<Vec<_>>());
    assert_ne!(digest(&together), whole, "one object is not thirty");
}

#[test]
fn nothing_to_learn_grows_nothing() {
    let bins = bins();
    assert!(Lessons::new(&bins).grow(&GROWTH, |_| true, |_, _| ()).trees.is_empty());
}
