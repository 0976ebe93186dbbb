//! Patches too small to say much by themselves: a rough or round skin falls into hundreds of them.

use std::collections::{BTreeMap, BTreeSet};

use super::patches::{RIDGE, Seam};

/// A patch is a crumb below this share of the surface.
const CRUMB: f64 = 6e-4;

/// What is known of patches before crumbs are gathered.
pub(super) struct Patches<'a> {
    /// The share of the surface of each, 0 to 1.
    pub share: Vec<f64>,
    /// Whether a prompt lies on it.
    pub is_held: Vec<bool>,
    /// The borders between them.
    pub seams: &'a BTreeMap<(u32, u32), Seam>,
}

/// For each patch, the one it becomes a piece of: crumbs without a prompt join the patch beside them
/// over the border that turns least, the smallest first, until none is left that has a neighbour.
pub(super) fn gathered(patches: Patches) -> Vec<u32> {
    let count = patches.share.len();
    let mut heap = Heap { around: vec![BTreeMap::new(); count], left: BTreeSet::new(), patches };
    let mut into: Vec<u32> = (0..count as u32).collect();
    for (&(a, b), seam) in heap.patches.seams {
        heap.add((a, b), (seam.length * (seam.concave + RIDGE * seam.convex), seam.length));
    }
    (0..count as u32).for_each(|patch| heap.offer(patch));
    while let Some(crumb) = heap.next() {
        if let Some(whole) = heap.smoothest(crumb) {
            heap.join(crumb, whole);
            into[crumb as usize] = whole;
        }
    }
    let end = |mut patch: u32| {
        while into[patch as usize] != patch {
            patch = into[patch as usize];
        }
        patch
    };
    (0..count as u32).map(end).collect()
}

/// Patches as they grow.
struct Heap<'a> {
    patches: Patches<'a>,
    /// Those beside each, with the border's turn times its length, and its length.
    around: Vec<BTreeMap<u32, (f64, f64)>>,
    /// Crumbs with neighbours, smallest first: the bits of a share are in its order.
    left: BTreeSet<(u64, u32)>,
}

impl Heap<'_> {
    fn place(&self, patch: u32) -> (u64, u32) {
        (self.patches.share[patch as usize].to_bits(), patch)
    }

    fn offer(&mut self, patch: u32) {
        let i = patch as usize;
        let is_crumb = self.patches.share[i] < CRUMB && !self.patches.is_held[i];
        if is_crumb && !self.around[i].is_empty() {
            self.left.insert(self.place(patch));
        }
    }

    fn next(&mut self) -> Option<u32> {
        self.left.pop_first().map(|crumb| crumb.1)
    }

    /// Adds to a border, on both sides.
    fn add(&mut self, (a, b): (u32, u32), (turn, length): (f64, f64)) {
        for (here, there) in [(a, b), (b, a)] {
            let border = self.around[here as usize].entry(there).or_default();
            *border = (border.0 + turn, border.1 + length);
        }
    }

    /// The patch beside this one over the border that turns least.
    fn smoothest(&self, patch: u32) -> Option<u32> {
        let mean = |(turn, length): (f64, f64)| turn / length.max(f64::MIN_POSITIVE);
        let around = self.around[patch as usize].iter();
        around.min_by(|a, b| mean(*a.1).total_cmp(&mean(*b.1))).map(|least| *least.0)
    }

    fn join(&mut self, crumb: u32, whole: u32) {
        self.left.remove(&self.place(whole));
        self.patches.share[whole as usize] += self.patches.share[crumb as usize];
        for (other, border) in std::mem::take(&mut self.around[crumb as usize]) {
            self.around[other as usize].remove(&crumb);
            if other != whole {
                self.add((whole, other), border);
            }
        }
        self.offer(whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three patches in a row, and what becomes of each.
    fn row(share: [f64; 3], held: [bool; 3], turns: [f64; 2]) -> Vec<u32> {
        let seam = |concave| Seam { length: 1.0, concave, convex: 0.0, sharp: 0.0, ridge: 0.0 };
        let seams = BTreeMap::from([((0, 1), seam(turns[0])), ((1, 2), seam(turns[1]))]);
        gathered(Patches { share: share.to_vec(), is_held: held.to_vec(), seams: &seams })
    }

    #[test]
    fn a_crumb_goes_where_the_border_turns_least() {
        let free = [false; 3];
        assert_eq!(row([0.5, 1e-5, 0.5], free, [0.5, 0.3]), [0, 2, 2]);
        assert_eq!(row([0.5, 0.01, 0.49], free, [0.5, 0.3]), [0, 1, 2]);
    }

    #[test]
    fn crumbs_make_a_patch_before_they_join_another() {
        assert_eq!(row([1e-4, 2e-4, 0.9], [false; 3], [0.3, 0.9]), [2, 2, 2]);
        assert_eq!(row([3e-4, 4e-4, 0.9], [false; 3], [0.3, 0.9]), [1, 1, 2]);
    }

    #[test]
    fn a_crumb_with_a_prompt_stays() {
        assert_eq!(row([0.5, 1e-5, 0.5], [false, true, false], [0.5, 0.3]), [0, 1, 2]);
    }

    #[test]
    fn what_has_no_neighbour_stays() {
        let alone =
            Patches { share: vec![1e-5, 1.0], is_held: vec![false; 2], seams: &BTreeMap::new() };
        assert_eq!(gathered(alone), [0, 1]);
    }
}
