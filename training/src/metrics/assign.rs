//! Who goes with whom at the least total cost.

/// Pairs rows with columns, each at most once and as many as there can be, so that the sum of their
/// costs is least; pairs in order of row. Rows must be equally long and costs finite.
///
/// Shortest augmenting paths with potentials, O(rows² · columns).
pub fn assign(cost: &[Vec<f64>]) -> Vec<(usize, usize)> {
    let columns = cost.first().map_or(0, Vec::len);
    if cost.len() <= columns {
        return augment(cost.len(), columns, |r, c| cost[r][c]);
    }
    let turned = augment(columns, cost.len(), |c, r| cost[r][c]);
    let mut pairs: Vec<_> = turned.into_iter().map(|(c, r)| (r, c)).collect();
    pairs.sort_unstable();
    pairs
}

/// The state of the search: column 0 is a stand-in for the row being placed, so rows and columns
/// count from 1.
struct Search {
    row_of: Vec<usize>,
    row_price: Vec<f64>,
    column_price: Vec<f64>,
}

fn augment(rows: usize, columns: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
    let mut search = Search {
        row_of: vec![0; columns + 1],
        row_price: vec![0.0; rows + 1],
        column_price: vec![0.0; columns + 1],
    };
    for row in 1..=rows {
        search.place(row, &cost);
    }
    let taken = search.row_of.iter().enumerate().skip(1).filter(|(_, r)| **r > 0);
    let mut pairs: Vec<_> = taken.map(|(c, &r)| (r - 1, c - 1)).collect();
    pairs.sort_unstable();
    pairs
}

impl Search {
    /// Finds the cheapest way to make room for a row and goes it.
    fn place(&mut self, row: usize, cost: &impl Fn(usize, usize) -> f64) {
        let columns = self.row_of.len();
        let (mut least, mut from) = (vec![f64::INFINITY; columns], vec![0; columns]);
        let mut done = vec![false; columns];
        self.row_of[0] = row;
        let mut here = 0;
        while self.row_of[here] > 0 {
            done[here] = true;
            let (r, mut step, mut next) = (self.row_of[here], f64::INFINITY, 0);
            for c in (1..columns).filter(|&c| !done[c]) {
                let slack = cost(r - 1, c - 1) - self.row_price[r] - self.column_price[c];
                if slack < least[c] {
                    (least[c], from[c]) = (slack, here);
                }
                if least[c] < step {
                    (step, next) = (least[c], c);
                }
            }
            if next == 0 {
                return;
            }
            self.reprice(&done, &mut least, step);
            here = next;
        }
        while here > 0 {
            self.row_of[here] = self.row_of[from[here]];
            here = from[here];
        }
    }

    fn reprice(&mut self, done: &[bool], least: &mut [f64], step: f64) {
        for c in 0..done.len() {
            if done[c] {
                self.row_price[self.row_of[c]] += step;
                self.column_price[c] -= step;
            } else {
                least[c] -= step;
            }
        }
    }
}
