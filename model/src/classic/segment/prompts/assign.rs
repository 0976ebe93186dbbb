//! Gives candidates to parts without points, for all parts at once.
//!
//! Each part is weighed by how well a candidate looks like its words. Parts with like words get
//! candidates that are copies of each other, and children lie beside their parents.

use object::DVec3;

use crate::classic::lexicon::places::{Place, arrange};
use crate::classic::segment::prompts::candidates::Candidates;
use crate::classic::segment::prompts::shape::alike;

/// What it counts that a part touches its parent, or that it does not.
const TOUCH: f64 = 1.0;
/// What it counts that two like-worded parts are copies of each other.
const LIKE: f64 = 3.0;
/// A part that fits nothing better than this, as log-odds, stays unknown.
const LEAST: f64 = -4.0;
/// Candidates that are tried as the model of a family, and as members without a likeness.
const MODELS: usize = 40;
/// Candidates of a family that are looked at closely.
const LIKELY: usize = 200;
/// Rounds in which every family may choose anew.
const ROUNDS: usize = 3;

/// The parts to place and what is known.
pub(crate) struct Puzzle<'a> {
    /// What could be a part.
    pub candidates: &'a Candidates,
    /// For each part and candidate, how well they fit, as log-odds; −∞ where it must not be.
    pub fits: Vec<Vec<f64>>,
    /// For each part, the part it hangs on.
    pub parents: Vec<Option<usize>>,
    /// The parts to place, like-worded ones together.
    pub families: Vec<Vec<usize>>,
    /// For each part, where its words say it is.
    pub places: Vec<Place>,
    /// For each unit in the order of the candidates, where the units stand that it touches.
    pub around: Vec<Vec<u32>>,
}

/// The candidate of each part.
pub(crate) type Choice = Vec<Option<usize>>;

impl Puzzle<'_> {
    /// The best assignment found, from the parts that are known; no two overlap.
    pub(crate) fn solve(&self, known: &Choice) -> Choice {
        let mut best = (f64::NEG_INFINITY, known.clone());
        for first in 0..self.families.len() {
            let choice = self.greedy(known, first);
            let value = self.value(&choice);
            if value > best.0 + 1e-9 {
                best = (value, choice);
            }
        }
        best.1
    }

    /// Places the family `first`, then always the one that gains most, then lets each choose anew.
    fn greedy(&self, known: &Choice, first: usize) -> Choice {
        let mut choice = known.clone();
        let mut waiting: Vec<usize> = (0..self.families.len()).collect();
        let mut next = Some(first);
        while let Some(family) = next {
            let members = self.respond(&choice, &self.families[family]);
            self.set(&mut choice, family, &members);
            waiting.retain(|&f| f != family);
            let gain = |&f: &usize| {
                let members = self.respond(&choice, &self.families[f]);
                self.gain(&choice, f, &members) / self.families[f].len() as f64
            };
            let gains: Vec<(f64, usize)> = waiting.iter().map(|f| (gain(f), *f)).collect();
            let better = |a: (f64, usize), b: (f64, usize)| if b.0 > a.0 { b } else { a };
            next = gains.into_iter().reduce(better).map(|(_, f)| f);
        }
        for family in (0..ROUNDS).flat_map(|_| 0..self.families.len()) {
            let mut without = choice.clone();
            self.families[family].iter().for_each(|&p| without[p] = None);
            let members = self.respond(&without, &self.families[family]);
            let mut changed = without;
            self.set(&mut changed, family, &members);
            if self.value(&changed) > self.value(&choice) + 1e-9 {
                choice = changed;
            }
        }
        choice
    }

    fn set(&self, choice: &mut Choice, family: usize, members: &[Option<usize>]) {
        self.families[family].iter().zip(members).for_each(|(&p, &c)| choice[p] = c);
    }

    fn gain(&self, choice: &Choice, family: usize, members: &[Option<usize>]) -> f64 {
        let mut with = choice.clone();
        self.set(&mut with, family, members);
        self.value(&with) - self.value(choice)
    }

    /// What an assignment is worth.
    fn value(&self, choice: &Choice) -> f64 {
        let list = &self.candidates.list;
        let mut value = 0.0;
        for family in &self.families {
            let placed: Vec<(usize, usize)> =
                family.iter().filter_map(|&p| Some((p, choice[p]?))).collect();
            for (i, &(part, c)) in placed.iter().enumerate() {
                value += self.fits[part][c] - LEAST;
                let like = placed[..i].iter().filter(|(_, d)| alike(&list[c], &list[*d])).count();
                value += LIKE * like as f64 / i.max(1) as f64;
            }
        }
        let pairs = self
            .parents
            .iter()
            .enumerate()
            .filter_map(|(p, parent)| Some((choice[p]?, choice[(*parent)?]?)));
        value + pairs.map(|(c, d)| self.contact(c, d)).sum::<f64>()
    }

    fn contact(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (self.candidates.list[a].span(), self.candidates.list[b].span());
        let (few, many) = if a.len() < b.len() { (a, b) } else { (b, a) };
        let meets =
            few.clone().any(|u| self.around[u].iter().any(|&v| many.contains(&(v as usize))));
        if meets { TOUCH } else { -TOUCH }
    }

    /// The best candidates for a family beside those chosen already, in order of its parts.
    fn respond(&self, choice: &Choice, family: &[usize]) -> Vec<Option<usize>> {
        let ranked = self.ranked(choice, family);
        let list = &self.candidates.list;
        if let [_] = family {
            return vec![ranked.first().filter(|(s, _)| *s > LEAST).map(|(_, c)| *c)];
        }
        let mut best: (f64, Vec<usize>) = (0.0, vec![]);
        for &(score, model) in ranked.iter().take(MODELS) {
            let mut members = vec![model];
            let mut sum = score - LEAST;
            let copies = ranked.iter().filter(|(_, c)| alike(&list[model], &list[*c]));
            let copies = copies.map(|&(s, c)| (s + LIKE, c));
            let others =
                ranked.iter().take(MODELS).filter(|(_, c)| !alike(&list[model], &list[*c]));
            for (s, c) in copies.chain(others.copied()) {
                let free = members.iter().all(|&m| !list[m].overlaps(&list[c]));
                if free && members.len() < family.len() && s > LEAST {
                    members.push(c);
                    sum += s - LEAST;
                }
            }
            if sum > best.0 {
                best = (sum, members);
            }
        }
        self.share_out(choice, family, &best.1)
    }

    /// Candidates that are free, by mean fit over a family, the best first: of those that look
    /// likeliest, with what their neighbours say added.
    fn ranked(&self, choice: &Choice, family: &[usize]) -> Vec<(f64, usize)> {
        let list = &self.candidates.list;
        let taken: Vec<usize> = choice.iter().flatten().copied().collect();
        let free = |c: &usize| taken.iter().all(|&t| !list[t].overlaps(&list[*c]));
        let mean = |sum: f64| sum / family.len() as f64;
        let fit = |c: usize| mean(family.iter().map(|&p| self.fits[p][c]).sum());
        let best = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        let mut ranked: Vec<(f64, usize)> = (0..list.len())
            .filter(free)
            .map(|c| (fit(c), c))
            .filter(|(s, _)| s.is_finite())
            .collect();
        ranked.sort_by(best);
        ranked.truncate(LIKELY);
        for (score, c) in &mut ranked {
            *score += mean(family.iter().map(|&p| self.beside(choice, p, *c)).sum());
        }
        ranked.sort_by(best);
        ranked
    }

    /// What it is worth for a part to be where a candidate is, for the sake of its parent and its
    /// children.
    fn beside(&self, choice: &Choice, part: usize, candidate: usize) -> f64 {
        let parent = self.parents[part].and_then(|p| choice[p]);
        let children = (0..choice.len()).filter(|&p| self.parents[p] == Some(part));
        let around = parent.into_iter().chain(children.filter_map(|p| choice[p]));
        around.map(|other| self.contact(candidate, other)).sum()
    }

    /// Gives each part of a family one of the candidates found, by the words that tell them apart.
    fn share_out(&self, choice: &Choice, family: &[usize], found: &[usize]) -> Vec<Option<usize>> {
        let mut members: Vec<Option<usize>> = found.iter().map(|&c| Some(c)).collect();
        members.resize(family.len(), None);
        let nowhere = DVec3::ZERO;
        let spot =
            |c: &Option<usize>| c.map_or(nowhere, |c| self.candidates.list[c].mass.bounds.centre());
        let spots: Vec<DVec3> = members.iter().map(spot).collect();
        let places: Vec<Place> = family.iter().map(|&p| self.places[p].clone()).collect();
        let beside = |&p: &usize| {
            let worth = |c: &Option<usize>| c.map_or(0.0, |c| self.beside(choice, p, c));
            members.iter().map(worth).collect::<Vec<f64>>()
        };
        let beside: Vec<Vec<f64>> = family.iter().map(beside).collect();
        arrange(&places, &spots, &beside).into_iter().map(|s| members[s]).collect()
    }
}
