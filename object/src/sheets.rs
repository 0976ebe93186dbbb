//! Sheets: faces that go on into each other, and which of them are drawn the other way round.

use std::collections::VecDeque;

/// What a face goes on into over one of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Join {
    /// The face beyond the edge.
    pub other: u32,
    /// Whether both walk along the edge the same way: one of them has to be turned over.
    pub is_opposed: bool,
}

/// Faces grouped into sheets, each seen from where its first face is seen as drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sheets {
    /// The sheet of each face, numbered in the order of first faces.
    pub of_face: Vec<u32>,
    /// The faces of each sheet, ascending.
    pub faces: Vec<Vec<u32>>,
    /// For each face, whether it has to be turned over to agree with the first one of its sheet.
    pub is_turned: Vec<bool>,
    /// For each sheet, how many joins no way of turning its faces satisfies, as in a Möbius strip.
    pub conflicts: Vec<usize>,
}

impl Sheets {
    /// The sheets of as many faces as there are lists of joins; each join is to stand in the lists of both
    /// its faces, and one to a face that is not there counts for nothing.
    pub fn of(joins: &[Vec<Join>]) -> Self {
        let mut sheets = Self {
            of_face: vec![u32::MAX; joins.len()],
            faces: Vec::new(),
            is_turned: vec![false; joins.len()],
            conflicts: Vec::new(),
        };
        for first in 0..joins.len() {
            if sheets.of_face[first] == u32::MAX {
                sheets.flood(first as u32, joins);
            }
        }
        sheets
    }

    fn flood(&mut self, first: u32, joins: &[Vec<Join>]) {
        let sheet = self.faces.len() as u32;
        self.of_face[first as usize] = sheet;
        let (mut faces, mut queue) = (vec![first], VecDeque::from([first]));
        let mut conflicts = 0;
        while let Some(face) = queue.pop_front() {
            for join in &joins[face as usize] {
                let other = join.other as usize;
                let is_turned = self.is_turned[face as usize] ^ join.is_opposed;
                match self.of_face.get(other) {
                    None => {}
                    Some(&u32::MAX) => {
                        self.of_face[other] = sheet;
                        self.is_turned[other] = is_turned;
                        faces.push(join.other);
                        queue.push_back(join.other);
                    }
                    Some(_) if self.is_turned[other] != is_turned && face < join.other => {
                        conflicts += 1;
                    }
                    Some(_) => {}
                }
            }
        }
        faces.sort_unstable();
        self.faces.push(faces);
        self.conflicts.push(conflicts);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both lists of each join: two faces, and whether one has to be turned over.
    fn joined(count: usize, pairs: &[(u32, u32, bool)]) -> Sheets {
        let mut joins = vec![Vec::new(); count];
        for &(a, b, is_opposed) in pairs {
            joins[a as usize].push(Join { other: b, is_opposed });
            joins[b as usize].push(Join { other: a, is_opposed });
        }
        Sheets::of(&joins)
    }

    #[test]
    fn faces_agree_with_the_first_of_their_sheet() {
        let sheets = joined(6, &[(0, 2, true), (2, 5, true), (1, 3, false), (3, 4, true)]);
        assert_eq!(sheets.of_face, [0, 1, 0, 1, 1, 0]);
        assert_eq!(sheets.faces, [[0, 2, 5], [1, 3, 4]]);
        assert_eq!(sheets.is_turned, [false, false, true, false, true, false]);
        assert_eq!(sheets.conflicts, [0, 0]);
    }

    #[test]
    fn a_ring_that_comes_back_turned_is_in_conflict_once() {
        let ring = |last| joined(4, &[(0, 1, false), (1, 2, true), (2, 3, false), (3, 0, last)]);
        assert_eq!((ring(true).conflicts, ring(false).conflicts), (vec![0], vec![1]));
    }

    #[test]
    fn a_join_to_nowhere_is_passed_over() {
        let sheets = Sheets::of(&[vec![Join { other: 7, is_opposed: true }]]);
        assert_eq!((sheets.faces, sheets.is_turned), (vec![vec![0]], vec![false]));
    }
}
