//! What was found for the last few conditions: a person who corrects changes little at a time, and undoes.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use object::{Condition, DVec3, KinematicTree};

use crate::classic::segment::classify::Probabilities;
use crate::classic::segment::confidence::Confidence;
use crate::classic::segment::prompts::seeds::Seed;

/// How many answers are remembered.
const MOST: usize = 8;

/// All that labels of a surface depend on, before anything is painted or barred.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Asked {
    category: String,
    tree: KinematicTree,
    points: Vec<Option<DVec3>>,
    seeds: Vec<Seed>,
    /// Its share that is fused, which follows from fewer seeds.
    fused: f64,
}

impl Asked {
    /// What is asked of a surface by a condition and these seeds.
    pub(super) fn of(condition: &Condition, seeds: &[Seed], fused: f64) -> Self {
        Self {
            category: condition.category.clone(),
            tree: condition.tree.clone(),
            points: condition.prompts.iter().map(|prompt| prompt.point).collect(),
            seeds: seeds.to_vec(),
            fused,
        }
    }
}

/// What the fitted models say.
#[derive(Debug)]
pub(super) struct Answer {
    /// The part of each face.
    pub part_of_face: Vec<u16>,
    /// What is believed of the faces.
    pub confidence: Confidence,
    /// How likely each part is of each segment of the usual cut.
    pub usual: Probabilities,
}

/// The last answers about one surface, the newest first.
#[derive(Debug, Default)]
pub(crate) struct Memory(Mutex<VecDeque<(Asked, Arc<Answer>)>>);

impl Memory {
    /// What was answered, or is now.
    pub(super) fn recall(&self, asked: Asked, answer: impl FnOnce() -> Answer) -> Arc<Answer> {
        let known = |all: &VecDeque<(Asked, Arc<Answer>)>| all.iter().position(|a| a.0 == asked);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known(&all).and_then(|place| all.remove(place)) {
            let answer = Arc::clone(&found.1);
            all.push_front(found);
            return answer;
        }
        // Nobody waits for a lock while an answer is found.
        drop(all);
        let answer = Arc::new(answer());
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.push_front((asked, Arc::clone(&answer)));
        all.truncate(MOST);
        answer
    }
}
