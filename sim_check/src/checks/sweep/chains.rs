//! Long robots: how many pairs of pieces are looked at, and that none is missed.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Scene;
use super::advance::{pairs, sweep, sweep_all};
use super::overlap::{by_depth, overlaps};
use super::tests::{joint, link, robot};
use super::together::{deepest, deepest_of_two, meetings};
use crate::checks::sweep::stance::Stance;
use crate::robot::Robot;

/// A way to lay out a robot of so many links: where each hangs, and how it moves.
struct Layout {
    kind: &'static str,
    parent: fn(usize) -> usize,
    at: fn(usize) -> [f64; 3],
    axis: [f64; 3],
    range: [f64; 2],
}

/// Boxes of 1 m on hinges 1.1 m apart.
const CHAIN: Layout = Layout {
    kind: "revolute",
    parent: |i| i - 1,
    at: |_| [1.1, 0.0, 0.0],
    axis: [0.0, 0.0, 1.0],
    range: [-1.0, 1.0],
};

fn laid_out(layout: &Layout, links: usize) -> Robot {
    let name = |l: usize| format!("l{l}");
    let mut text = link(&name(0), [0.0; 3], [1.0; 3]);
    for l in 1..links {
        let (parent, child) = (name((layout.parent)(l)), name(l));
        text += &link(&child, [0.0; 3], [1.0; 3]);
        let ends = (layout.kind, parent.as_str(), child.as_str());
        text += &joint(ends, (layout.at)(l), layout.axis, layout.range);
    }
    robot(&text)
}

/// Pairs of pieces that the sweeps of all drives follow through their ranges.
fn pairs_followed(robot: &Robot) -> usize {
    let scene = Scene::new(robot).unwrap();
    let of = |d: usize| {
        let ends = [scene.drives[d].lower, scene.drives[d].upper];
        ends.map(|end| sweep(&scene, d, end).unwrap().pairs).iter().sum::<usize>()
    };
    (0..scene.drives.len()).map(of).sum()
}

/// Every pair of the chain used to be followed: 22 million in all.
#[test]
fn a_chain_of_512_links_is_judged_before_its_deadline() {
    for links in [32, 128, 512] {
        let followed = pairs_followed(&laid_out(&CHAIN, links));
        assert!(followed <= 8 * links, "{followed} pairs for {links} links");
    }
    let long = laid_out(&CHAIN, 512);
    assert!(meetings(&Scene::new(&long).unwrap(), 0).is_none(), "too many corners, said at once");
}

#[test]
fn a_chain_that_folds_back_on_itself_is_followed_where_it_meets_itself() {
    let folding = Layout { range: [-3.1, 3.1], ..CHAIN };
    let [few, many] = [64, 128].map(|links| pairs_followed(&laid_out(&folding, links)));
    assert!(many <= 6 * few, "{few} pairs for 64 links, {many} for 128");
    assert!(many < 128 * 128 * 127 / 6, "{many}");
}

#[test]
fn slides_in_a_row_are_followed_with_their_neighbours_alone() {
    let slides = Layout { kind: "prismatic", range: [-0.5, 0.5], ..CHAIN };
    let followed = pairs_followed(&laid_out(&slides, 256));
    assert!(followed <= 8 * 256, "{followed}");
}

#[test]
fn drawers_side_by_side_are_followed_with_their_neighbours_alone() {
    let row =
        Layout { parent: |_| 0, at: |i| [1.1 * i as f64, 0.0, 0.0], range: [-0.1, 0.1], ..CHAIN };
    let followed = pairs_followed(&laid_out(&row, 256));
    assert!(followed <= 8 * 256, "{followed}");
}

#[test]
fn a_tree_that_branches_is_followed_branch_by_branch() {
    let place = |i: usize| {
        let across = 256.0 / f64::from((i as u32 + 1).ilog2()).exp2();
        [if i.is_multiple_of(2) { -across } else { across }, 0.0, 1.2]
    };
    let branching = Layout { parent: |i| (i - 1) / 2, at: place, range: [-0.1, 0.1], ..CHAIN };
    let followed = pairs_followed(&laid_out(&branching, 255));
    assert!(followed <= 16 * 255, "{followed}");
}

/// Boxes thrown together, hinged and sliding, some on bodies that others carry.
fn heap(seed: u64) -> Robot {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut text = link("l0", [0.0; 3], [0.5; 3]);
    for l in 1..9 {
        let mut number = |most: f64| rng.random_range(-most..most);
        let at = [(); 3].map(|()| number(0.7));
        let axis = [(); 3].map(|()| number(1.0));
        let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        let size = [(); 3].map(|()| 0.2 + number(0.15));
        let range = [-number(2.0).abs(), number(2.0).abs()];
        let middle = [(); 3].map(|()| number(0.3));
        let (parent, child) = (format!("l{}", rng.random_range(0..l)), format!("l{l}"));
        let kind = ["revolute", "prismatic", "fixed"][rng.random_range(0..3)];
        text += &link(&child, middle, size);
        text += &joint((kind, &parent, &child), at, axis.map(|a| a / length), range);
    }
    robot(&text)
}

#[test]
fn what_is_passed_over_never_touches() {
    for seed in 0..60 {
        let robot = heap(seed);
        let scene = Scene::new(&robot).unwrap();
        for d in 0..scene.drives.len() {
            let end = [scene.drives[d].lower, scene.drives[d].upper][seed as usize % 2];
            let all = pairs(&scene, d).collect::<Vec<_>>();
            let (found, thorough) = (sweep(&scene, d, end), sweep_all(&scene, d, end, all));
            let [found, thorough] = [found, thorough].map(|s| s.map(|s| (s.worst, s.first_hit)));
            assert_eq!(found, thorough, "seed {seed}, drive {d}");
        }
    }
}

#[test]
fn two_joints_at_once_meet_whatever_every_pair_of_bodies_meets() {
    let mut met = 0;
    for seed in 0..60 {
        let robot = heap(seed);
        let scene = Scene::new(&robot).unwrap();
        let mut stance = Stance::new(&scene);
        for j in 0..scene.drives.len() {
            for i in 0..j {
                let moved = [(i, scene.drives[i].upper), (j, scene.drives[j].lower)];
                let found = deepest_of_two(&scene, &mut stance, moved);
                assert_eq!(found, deepest(&scene, moved.to_vec()), "seed {seed}, {moved:?}");
                met += usize::from(found.is_some());
            }
        }
    }
    assert!(met > 4, "{met}");
}

#[test]
fn boxes_are_met_in_any_order_along_any_direction() {
    for seed in 0..20 {
        let robot = heap(seed);
        let scene = Scene::new(&robot).unwrap();
        let q = scene.with(&[(0, scene.drives[0].upper)]);
        let mut one_by_one = Vec::new();
        for b in 0..scene.bodies.len() {
            for a in 0..b {
                one_by_one.extend(overlaps(&scene, &q, |x, y| [x, y] == [a, b]));
            }
        }
        one_by_one.sort_by(by_depth);
        assert_eq!(overlaps(&scene, &q, |_, _| true), one_by_one, "seed {seed}");
    }
}
