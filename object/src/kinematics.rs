//! Parts and joints as a directed tree, proved a tree when it is built.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most parts an object may have.
pub const MAX_PARTS: usize = 64;
/// Most joints between a part and its parent.
pub const MAX_JOINTS: usize = 2;

/// One degree of freedom between a part and its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// A hinge with limits, like a door's.
    Revolute,
    /// A hinge without limits, like a wheel's.
    Continuous,
    /// A slide with limits, like a drawer's.
    Prismatic,
}

impl JointKind {
    /// Whether it turns (revolute or continuous) rather than slides.
    pub fn turns(self) -> bool {
        self != Self::Prismatic
    }
}

/// A rigid part of an object, with the joints that tie it to its parent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Identifier, unique, `[A-Za-z_][A-Za-z0-9_]*`: the URDF link's name.
    pub name: String,
    /// What the part is, in words; the paper's text prompt.
    pub text: String,
    /// Index of the parent part; `None` for the root alone.
    pub parent: Option<usize>,
    /// Degrees of freedom relative to the parent, the first nearest the parent. Empty: fixed.
    /// At most two: as a rule one that turns and one that slides (the paper's "both").
    pub joints: Vec<JointKind>,
}

/// A directed tree of parts. Part 0 need not be the root, but there is exactly one root, every
/// parent exists, no cycle is possible and names are unique.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Part>", into = "Vec<Part>")]
pub struct KinematicTree {
    parts: Vec<Part>,
    order: Vec<usize>,
}

/// Why parts and joints are not a kinematic tree.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TreeError {
    /// No part, or more than [`MAX_PARTS`].
    #[error("an object has between 1 and {MAX_PARTS} parts, found {0}")]
    PartCount(usize),
    /// A name that URDF readers would not accept.
    #[error("part name `{0}` must match [A-Za-z_][A-Za-z0-9_]*")]
    Name(String),
    /// Two parts of one name.
    #[error("two parts are called `{0}`, names must be unique")]
    DuplicateName(String),
    /// A parent index that no part has.
    #[error("part `{part}` names parent {parent}, but there are only {parts} parts")]
    UnknownParent {
        /// The child's name.
        part: String,
        /// The index it names.
        parent: usize,
        /// How many parts there are.
        parts: usize,
    },
    /// No root, or several.
    #[error("a tree has exactly one part without a parent, found {}: {}", .0.len(), list(.0))]
    Roots(Vec<String>),
    /// Parts that never reach the root.
    #[error("parts {} form a cycle and never reach the root", list(.0))]
    Cycle(Vec<String>),
    /// More than [`MAX_JOINTS`], or a moving root.
    #[error("part `{part}` has joints {found:?}: {rule}")]
    Joints {
        /// The part's name.
        part: String,
        /// Its joints.
        found: Vec<JointKind>,
        /// The broken rule.
        rule: &'static str,
    },
}

fn list(names: &[String]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

impl KinematicTree {
    /// Proves that the parts form one tree.
    ///
    /// # Errors
    /// [`TreeError`], the first broken rule in the order of its variants.
    pub fn new(parts: Vec<Part>) -> Result<Self, TreeError> {
        if !(1..=MAX_PARTS).contains(&parts.len()) {
            return Err(TreeError::PartCount(parts.len()));
        }
        check_names(&parts)?;
        check_parents(&parts)?;
        parts.iter().try_for_each(check_joints)?;
        let order = root_first(&parts);
        if order.len() < parts.len() {
            let lost = (0..parts.len()).filter(|p| !order.contains(p));
            return Err(TreeError::Cycle(lost.map(|p| parts[p].name.clone()).collect()));
        }
        Ok(Self { parts, order })
    }

    /// The parts, in the order given.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Number of parts.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Never true: a tree has a root.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Index of the root.
    pub fn root(&self) -> usize {
        self.order[0]
    }

    /// Parent of a part, `None` for the root.
    pub fn parent(&self, part: usize) -> Option<usize> {
        self.parts[part].parent
    }

    /// Children of a part, ascending.
    pub fn children(&self, part: usize) -> impl Iterator<Item = usize> {
        (0..self.len()).filter(move |&p| self.parts[p].parent == Some(part))
    }

    /// All parts, each parent before its children, siblings ascending.
    pub fn root_first(&self) -> &[usize] {
        &self.order
    }

    /// Number of degrees of freedom over all parts.
    pub fn degrees_of_freedom(&self) -> usize {
        self.parts.iter().map(|p| p.joints.len()).sum()
    }

    /// Whether `part` is `ancestor` or hangs below it.
    pub fn is_under(&self, part: usize, ancestor: usize) -> bool {
        let mut walk = Some(part);
        while let Some(p) = walk {
            if p == ancestor {
                return true;
            }
            walk = self.parent(p);
        }
        false
    }

    /// The tree without the parts marked lost: their children hang on the nearest surviving
    /// ancestor and keep their joints. Returns the tree and, for each old part, its new index.
    ///
    /// # Errors
    /// [`TreeError::Roots`] if the root itself is lost, [`TreeError::PartCount`] if all are.
    pub fn without(&self, lost: &[bool]) -> Result<(Self, Vec<Option<usize>>), TreeError> {
        if lost[self.root()] {
            return Err(TreeError::Roots(vec![]));
        }
        let mut next = 0..;
        let new_index: Vec<_> = lost.iter().map(|&l| if l { None } else { next.next() }).collect();
        let survivor = |mut p: usize| {
            while lost[p] {
                p = self.parts[p].parent?;
            }
            new_index[p]
        };
        let keep = |p: usize| Part {
            parent: self.parts[p].parent.and_then(survivor),
            ..self.parts[p].clone()
        };
        let parts = (0..self.len()).filter(|&p| !lost[p]).map(keep).collect();
        Ok((Self::new(parts)?, new_index))
    }
}

impl TryFrom<Vec<Part>> for KinematicTree {
    type Error = TreeError;
    fn try_from(parts: Vec<Part>) -> Result<Self, TreeError> {
        Self::new(parts)
    }
}

impl From<KinematicTree> for Vec<Part> {
    fn from(tree: KinematicTree) -> Self {
        tree.parts
    }
}

/// Whether a name may stand in a URDF: `[A-Za-z_][A-Za-z0-9_]*`.
pub fn is_safe_name(name: &str) -> bool {
    let ok = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.chars().all(ok) && name.chars().next().is_some_and(|c| !c.is_ascii_digit())
}

fn check_names(parts: &[Part]) -> Result<(), TreeError> {
    let mut seen = std::collections::BTreeSet::new();
    for part in parts {
        if !is_safe_name(&part.name) {
            return Err(TreeError::Name(part.name.clone()));
        }
        if !seen.insert(&part.name) {
            return Err(TreeError::DuplicateName(part.name.clone()));
        }
    }
    Ok(())
}

fn check_parents(parts: &[Part]) -> Result<(), TreeError> {
    for part in parts {
        if let Some(parent) = part.parent.filter(|&p| p >= parts.len()) {
            let part = part.name.clone();
            return Err(TreeError::UnknownParent { part, parent, parts: parts.len() });
        }
    }
    let roots: Vec<_> = parts.iter().filter(|p| p.parent.is_none()).collect();
    if roots.len() == 1 {
        return Ok(());
    }
    Err(TreeError::Roots(roots.iter().map(|p| p.name.clone()).collect()))
}

fn check_joints(part: &Part) -> Result<(), TreeError> {
    let rule = if part.parent.is_none() && !part.joints.is_empty() {
        "the root does not move"
    } else if part.joints.len() > MAX_JOINTS {
        "a part has at most two joints"
    } else {
        return Ok(());
    };
    Err(TreeError::Joints { part: part.name.clone(), found: part.joints.clone(), rule })
}

fn root_first(parts: &[Part]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..parts.len()).filter(|&p| parts[p].parent.is_none()).collect();
    let mut done = 0;
    while done < order.len() {
        let parent = order[done];
        order.extend((0..parts.len()).filter(|&p| parts[p].parent == Some(parent)));
        done += 1;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str, parent: Option<usize>, joints: &[JointKind]) -> Part {
        Part { name: name.into(), text: name.into(), parent, joints: joints.to_vec() }
    }

    #[test]
    fn parents_come_before_children_whatever_the_order_given() {
        let parts = vec![
            part("knob", Some(2), &[JointKind::Continuous]),
            part("body", None, &[]),
            part("door", Some(1), &[JointKind::Revolute]),
        ];
        let tree = KinematicTree::new(parts).unwrap();
        assert_eq!(tree.root_first(), [1, 2, 0]);
        assert_eq!(tree.degrees_of_freedom(), 2);
        assert!(tree.is_under(0, 1) && !tree.is_under(1, 0));
    }

    #[test]
    fn what_is_not_a_tree_is_refused_by_name() {
        let cycle = vec![part("a", None, &[]), part("b", Some(2), &[]), part("c", Some(1), &[])];
        let e = KinematicTree::new(cycle).unwrap_err();
        assert_eq!(e.to_string(), "parts `b`, `c` form a cycle and never reach the root");
        let two = vec![part("a", None, &[]), part("b", None, &[])];
        let e = KinematicTree::new(two).unwrap_err();
        assert_eq!(
            e.to_string(),
            "a tree has exactly one part without a parent, found 2: `a`, `b`"
        );
        let three = vec![part("a", None, &[]), part("b", Some(0), &[JointKind::Prismatic; 3])];
        assert!(KinematicTree::new(three).unwrap_err().to_string().contains("at most two joints"));
    }

    #[test]
    fn children_of_a_lost_part_hang_on_its_nearest_surviving_ancestor() {
        let parts = vec![
            part("body", None, &[]),
            part("door", Some(0), &[JointKind::Revolute]),
            part("shelf", Some(1), &[]),
            part("handle", Some(2), &[JointKind::Revolute]),
        ];
        let tree = KinematicTree::new(parts).unwrap();
        let (kept, index) = tree.without(&[false, true, true, false]).unwrap();
        assert_eq!(index, [Some(0), None, None, Some(1)]);
        assert_eq!(kept.parent(1), Some(0));
        assert_eq!(kept.parts()[1].joints, [JointKind::Revolute]);
        assert!(tree.without(&[true, false, false, false]).is_err());
    }
}
