//! The best tree over a complete directed graph: a maximum spanning arborescence (Edmonds).

/// Parent of each node in the spanning arborescence of largest total weight, `None` for its root;
/// `weight[i][j]` is that of the edge from i to j, the diagonal is not looked at. Of several best
/// roots the first.
pub fn best_arborescence(weight: &[Vec<f64>]) -> Vec<Option<usize>> {
    let n = weight.len();
    let rooted = |root: usize| {
        let parents = rooted_at(weight, root);
        let total: f64 = (0..n).filter_map(|v| parents[v].map(|u| weight[u][v])).sum();
        (total, parents)
    };
    let better = |best: (f64, Vec<Option<usize>>), next: (f64, Vec<Option<usize>>)| {
        if next.0 > best.0 { next } else { best }
    };
    (0..n).map(rooted).fold((f64::NEG_INFINITY, vec![None; n]), better).1
}

/// Edmonds' algorithm for a given root: every node takes its best parent; a cycle is contracted to
/// one node, solved, and opened where the solution enters it.
fn rooted_at(weight: &[Vec<f64>], root: usize) -> Vec<Option<usize>> {
    let n = weight.len();
    let best = |v: usize| {
        let better = |a: usize, b: usize| if weight[b][v] > weight[a][v] { b } else { a };
        (0..n).filter(|&u| u != v).reduce(better)
    };
    let parents: Vec<_> = (0..n).map(|v| if v == root { None } else { best(v) }).collect();
    let Some(cycle) = find_cycle(&parents) else { return parents };
    let (small, origin) = contract(weight, &parents, &cycle);
    let kept: Vec<usize> = (0..n).filter(|v| !cycle.contains(v)).collect();
    let new_root = kept.iter().position(|&v| v == root).unwrap_or(0);
    let solved = rooted_at(&small, new_root);
    let mut out = parents;
    for (v, parent) in solved.iter().enumerate() {
        let Some(u) = *parent else { continue };
        let (from, to) = origin[u][v];
        out[to] = Some(from);
    }
    out
}

/// The nodes of some cycle among the parents.
fn find_cycle(parents: &[Option<usize>]) -> Option<Vec<usize>> {
    (0..parents.len()).find_map(|start| {
        let mut path = vec![start];
        let mut at = parents[start]?;
        while at != start {
            if path.len() > parents.len() {
                return None;
            }
            path.push(at);
            at = parents[at]?;
        }
        Some(path)
    })
}

/// Weights, and the original edge, between each two nodes of a contracted graph.
type Contracted = (Vec<Vec<f64>>, Vec<Vec<(usize, usize)>>);

/// The graph with the cycle as one node, the last; entering it costs the cycle's edge it replaces.
fn contract(weight: &[Vec<f64>], parents: &[Option<usize>], cycle: &[usize]) -> Contracted {
    let kept: Vec<usize> = (0..weight.len()).filter(|v| !cycle.contains(v)).collect();
    let members = |i: usize| if i < kept.len() { std::slice::from_ref(&kept[i]) } else { cycle };
    let replaced = |i: usize, v: usize| match parents[v] {
        Some(u) if i == kept.len() => weight[u][v],
        _ => 0.0,
    };
    let edge = |i: usize, j: usize| {
        let mut best = (f64::NEG_INFINITY, (0, 0));
        for (&u, &v) in members(i).iter().flat_map(|u| members(j).iter().map(move |v| (u, v))) {
            let w = weight[u][v] - replaced(j, v);
            if i != j && w > best.0 {
                best = (w, (u, v));
            }
        }
        best
    };
    let n = kept.len() + 1;
    let all: Vec<Vec<_>> = (0..n).map(|i| (0..n).map(|j| edge(i, j)).collect()).collect();
    let weights = all.iter().map(|row| row.iter().map(|e| e.0).collect()).collect();
    (weights, all.iter().map(|row| row.iter().map(|e| e.1).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(weight: &[Vec<f64>], parents: &[Option<usize>]) -> f64 {
        let edge = |(v, u): (usize, &Option<usize>)| u.map(|u| weight[u][v]);
        parents.iter().enumerate().filter_map(edge).sum()
    }

    /// Tries every choice of parents.
    fn exhaustive(weight: &[Vec<f64>]) -> f64 {
        let n = weight.len();
        let mut best = f64::NEG_INFINITY;
        for code in 0..(n + 1).pow(n as u32) {
            let digit = |v: usize| code / (n + 1).pow(v as u32) % (n + 1);
            let parents: Vec<_> = (0..n).map(|v| (digit(v) < n).then(|| digit(v))).collect();
            let one_root = parents.iter().filter(|p| p.is_none()).count() == 1;
            let looped = parents.iter().enumerate().any(|(v, p)| *p == Some(v));
            if one_root && !looped && find_cycle(&parents).is_none() {
                best = best.max(total(weight, &parents));
            }
        }
        best
    }

    #[test]
    fn the_tree_is_the_best_of_all_trees() {
        let mut state = 7u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            -((state >> 40) as f64) / 1e6
        };
        for n in [1, 2, 3, 4, 5, 5, 5, 5, 5] {
            let weight: Vec<Vec<f64>> =
                (0..n).map(|_| (0..n).map(|_| number()).collect()).collect();
            let parents = best_arborescence(&weight);
            assert_eq!(parents.iter().filter(|p| p.is_none()).count(), 1);
            assert!(find_cycle(&parents).is_none());
            assert!((total(&weight, &parents) - exhaustive(&weight)).abs() < 1e-9);
        }
        assert!(best_arborescence(&[]).is_empty());
    }
}
