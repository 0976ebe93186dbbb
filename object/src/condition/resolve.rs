//! From a file's fields to a condition whose tree is proved: everything that is wrong is told at once.

use std::collections::BTreeMap;

use glamx::DVec3;

use super::fault::{ConditionError, Fault, meant, short};
use super::file::{ConditionFile, FileJoint, FilePart, FileSize, Quantity, SCHEMA, SCHEMA_1};
use super::lines::Lines;
use super::types::{Condition, Extent, GivenJoint, MAX_POINTS, MAX_TEXT, Prompt, TrueSize, kept};
use crate::articulated::Range;
use crate::kinematics::{JointKind, KinematicTree, Part, TreeError};
use crate::mesh::FileFrame;
use crate::origin::Origin;

impl ConditionFile {
    /// Proves the tree, turns points into the object frame and checks every number.
    ///
    /// # Errors
    /// [`ConditionError`]: everything that is wrong, each with its part and what was found.
    pub fn resolve(&self) -> Result<Condition, ConditionError> {
        self.resolved(Vec::new(), &Lines::default())
    }

    /// The same of a file in which some faults were found already.
    pub(super) fn resolved(
        &self,
        faults: Vec<Fault>,
        lines: &Lines,
    ) -> Result<Condition, ConditionError> {
        // What a tree is cannot be said where its parts or their parents were not understood.
        let was_read = faults.is_empty();
        let mut proof = Proof { file: self, lines, faults };
        proof.schema();
        proof.painted();
        let size = self.size.map(|size| proof.size(size));
        let parts = proof.parts().filter(|_| was_read);
        let frame = FileFrame { up: self.up.unwrap_or_default() };
        let prompts = (0..self.parts.len()).map(|i| proof.prompt(i, frame)).collect();
        let Some(tree) = parts.and_then(|parts| proof.tree(parts)) else {
            ConditionError::of(proof.faults)?;
            return Err(ConditionError::one("not a condition"));
        };
        let condition = Condition {
            category: self.category.clone(),
            tree,
            prompts,
            size,
            origin: Origin::User,
            frame,
            painted_on: self.mesh.clone(),
        };
        proof.distinct(&condition);
        ConditionError::of(proof.faults)?;
        Ok(condition)
    }
}

/// A range below this, radians or metres, is none that any format would tell from nothing: a guess.
const LEAST: f64 = 1e-4;
/// The longest slide, metres: as long as the largest object ([`TrueSize`]).
const LONGEST: f64 = 20.0;

/// A file under proof, and what was found wrong with it.
struct Proof<'a> {
    file: &'a ConditionFile,
    lines: &'a Lines,
    faults: Vec<Fault>,
}

impl Proof<'_> {
    fn fault(&mut self, (part, field): (Option<usize>, &'static str), message: impl Into<String>) {
        let line = self.lines.of(part, field);
        self.faults.push(Fault::new(line, message));
    }

    fn part_fault(&mut self, part: usize, field: &'static str, message: &str) {
        let message = format!("part `{}`: {message}", short(&self.file.parts[part].name));
        self.fault((Some(part), field), message);
    }

    fn schema(&mut self) {
        let schema = &self.file.schema;
        if schema != SCHEMA && schema != SCHEMA_1 {
            let known = format!("expected `{SCHEMA}`, `{SCHEMA_1}` or `condition/1`");
            self.fault((None, "schema"), format!("schema `{schema}` is unknown, {known}"));
        }
    }

    fn painted(&mut self) {
        let painted = self.file.parts.iter().position(|p| !p.faces.is_empty());
        if let Some(part) = painted.filter(|_| self.file.mesh.is_none()) {
            let why = "`faces` count in a mesh: say in which, by its digest, in the file's `mesh`";
            self.part_fault(part, "faces", why);
        }
        let mut painted: Vec<(u32, u32, usize)> = Vec::new();
        for (i, part) in self.file.parts.iter().enumerate() {
            painted.extend(part.faces.ranges().iter().map(|run| (run.start, run.end, i)));
        }
        painted.sort_unstable();
        let twice = painted.windows(2).find(|w| w[1].0 < w[0].1).map(|w| (w[1].0, w[0].2, w[1].2));
        if let Some((face, first, second)) = twice {
            let other = &self.file.parts[first].name;
            self.part_fault(
                second,
                "faces",
                &format!("face {face} is painted as `{other}`'s, too"),
            );
        }
    }

    fn size(&mut self, size: FileSize) -> TrueSize {
        let (of, metres) = match size {
            FileSize::Largest(m) => (Extent::Largest, m),
            FileSize::Height(m) => (Extent::Height, m),
            FileSize::Width(m) => (Extent::Width, m),
            FileSize::Depth(m) => (Extent::Depth, m),
        };
        if !(0.005..=20.0).contains(&metres) {
            let message = format!("object: size must be in 0.005 to 20 m, found {metres}");
            self.fault((None, "size"), message);
        }
        TrueSize { of, metres }
    }

    /// The parts; nothing where a parent is nobody, or two.
    fn parts(&mut self) -> Option<Vec<Part>> {
        let mut parent_of: BTreeMap<&String, &Option<String>> = BTreeMap::new();
        let mut parts = Some(Vec::with_capacity(self.file.parts.len()));
        for (i, p) in self.file.parts.iter().enumerate() {
            let has_two = self.has_two_parents(i, p, parent_of.insert(&p.name, &p.parent));
            let part = self.part(i, p).filter(|_| !has_two);
            parts = parts.zip(part).map(|(mut parts, part)| {
                parts.push(part);
                parts
            });
        }
        parts
    }

    fn has_two_parents(&mut self, i: usize, p: &FilePart, before: Option<&Option<String>>) -> bool {
        let (Some(Some(first)), Some(second)) = (before, &p.parent) else { return false };
        if first == second {
            return false;
        }
        let message =
            format!("part `{}` has two parents, `{first}` and `{second}`", short(&p.name));
        self.fault((Some(i), "parent"), message);
        true
    }

    fn part(&mut self, i: usize, p: &FilePart) -> Option<Part> {
        let text = p.text.clone().unwrap_or_else(|| p.name.replace('_', " "));
        let digits = text.chars().all(|c| c.is_ascii_digit() || c.is_whitespace());
        if digits || text.chars().count() > MAX_TEXT {
            let rule = format!("a text has 1 to {MAX_TEXT} characters and not only digits");
            self.part_fault(i, "text", &format!("{rule}, found {:?}", short(&text)));
        }
        if !p.joints.is_empty() && !p.joint.kinds().is_empty() {
            self.part_fault(i, "joint", "give `joint` or `joints`, not both");
        }
        let index = |parent: &String| self.file.parts.iter().position(|q| q.name == *parent);
        let parent = match &p.parent {
            None => None,
            Some(name) => match index(name) {
                Some(parent) => Some(parent),
                None => {
                    let near = meant(name, self.file.parts.iter().map(|p| p.name.as_str()));
                    let message = format!(
                        "part `{}` names the parent `{}`, which no part is called{near}",
                        short(&p.name),
                        short(name)
                    );
                    self.fault((Some(i), "parent"), message);
                    return None;
                }
            },
        };
        Some(Part { name: p.name.clone(), text, parent, joints: p.kinds() })
    }

    fn tree(&mut self, parts: Vec<Part>) -> Option<KinematicTree> {
        let error = match KinematicTree::new(parts) {
            Ok(tree) => return Some(tree),
            Err(error) => error,
        };
        let place = |name: &String| self.file.parts.iter().rposition(|p| p.name == *name);
        let (part, field) = match &error {
            TreeError::Name(name) | TreeError::DuplicateName(name) => (place(name), "name"),
            TreeError::Roots(names) | TreeError::Cycle(names) => {
                (names.last().and_then(place), "parent")
            }
            TreeError::Joints { part, .. } => (place(part), "joint"),
            TreeError::UnknownParent { part, .. } => (place(part), "parent"),
            TreeError::PartCount(_) => (None, "parts"),
        };
        self.fault((part, field), error.to_string());
        None
    }

    /// Two parts of one text need a point each: otherwise nothing tells them apart.
    fn distinct(&mut self, c: &Condition) {
        let parts = c.tree.parts();
        let is_unplaced =
            |p: &&usize| c.prompts[**p].point.is_none() && c.prompts[**p].faces.is_empty();
        for (second, b) in parts.iter().enumerate() {
            let same = |a: &Part| a.text.trim().eq_ignore_ascii_case(b.text.trim());
            let Some(first) = parts[..second].iter().position(same) else { continue };
            let Some(&pointless) = [first, second].iter().find(is_unplaced) else { continue };
            let (one, other, lost) = (&parts[first].name, &b.name, &parts[pointless].name);
            let message = format!(
                "parts `{one}` and `{other}` are both \"{}\" and `{lost}` has no point: give each a point or a text of its own",
                b.text
            );
            self.fault((Some(second), "text"), message);
            return;
        }
    }

    fn prompt(&mut self, i: usize, frame: FileFrame) -> Prompt {
        let p = &self.file.parts[i];
        for (field, points) in [("points", &p.points), ("not", &p.not)] {
            if points.len() > MAX_POINTS {
                let found = points.len();
                self.part_fault(
                    i,
                    field,
                    &format!("`{field}` has at most {MAX_POINTS}, found {found}"),
                );
            }
        }
        let all = p.point.iter().chain(&p.points).chain(&p.not);
        if let Some(bad) = all.flatten().find(|c| !c.is_finite()) {
            self.part_fault(i, "point", &format!("point must be in finite numbers, found {bad}"));
        }
        self.within(i, ("density", "1 to 25,000 kg/m³", 1.0, 25e3), p.density);
        self.within(i, ("mass", "1e-6 to 1e5 kg", 1e-6, 1e5), p.mass);
        self.within(i, ("friction", "0 to 2", 0.0, 2.0), p.friction);
        let place = |p: &[f64; 3]| frame.point_to_object(DVec3::from_array(*p));
        let mut points = p.point.iter().chain(&p.points).map(place);
        Prompt {
            point: points.next(),
            also: points.collect(),
            not: p.not.iter().map(place).collect(),
            faces: p.faces.clone(),
            joints: self.joints(i, frame),
            material: p.material.clone(),
            density: p.density,
            mass: p.mass,
            friction: p.friction,
        }
    }

    fn within(
        &mut self,
        part: usize,
        (what, range, low, high): (&'static str, &str, f64, f64),
        value: Option<f64>,
    ) {
        if let Some(found) = value.filter(|v| !(*v >= low && *v <= high)) {
            self.part_fault(part, what, &format!("{what} must be in {range}, found {found}"));
        }
    }

    /// What is given of the joints of a part; nothing where nothing is.
    fn joints(&mut self, i: usize, frame: FileFrame) -> Vec<GivenJoint> {
        let p = &self.file.parts[i];
        let kinds = p.kinds();
        let mut all = p.joints.clone();
        if p.corrects_its_joint() {
            let [kind] = kinds[..] else {
                let rule = match kinds.len() {
                    0 => {
                        "it has no joint that an axis, a pivot, a range or a rest could be of: give it a `joint`"
                    }
                    _ => "it has two joints: give each its own axis, pivot and range in `joints`",
                };
                self.part_fault(i, "axis", rule);
                return vec![];
            };
            let said = FileJoint {
                kind,
                axis: p.axis,
                pivot: p.pivot,
                range: p.range.clone(),
                rest: p.rest.clone(),
                effort: p.effort,
                damping: p.damping,
            };
            if p.joints.is_empty() {
                all = vec![said];
            } else {
                self.part_fault(i, "joints", "say it in `joints` or beside them, not both");
            }
        }
        if let [first, second] = kinds[..]
            && first.turns() == second.turns()
            && all.iter().filter(|said| said.axis.is_some()).count() < 2
        {
            let rule = "two joints of one kind need an `axis` each, in `joints`";
            self.part_fault(i, "joint", rule);
        }
        let given: Vec<GivenJoint> = all.iter().map(|said| self.given(i, said, frame)).collect();
        kept(given)
    }

    fn given(&mut self, i: usize, said: &FileJoint, frame: FileFrame) -> GivenJoint {
        self.within(i, ("effort", "1e-6 to 1e6 N·m or N", 1e-6, 1e6), said.effort);
        self.within(i, ("damping", "0 to 1e6", 0.0, 1e6), said.damping);
        let direction = said.axis.map(|a| frame.point_to_object(DVec3::from_array(a)));
        // Any length will do, also one whose square is none.
        let axis = direction.and_then(|d| (d / d.abs().max_element()).try_normalize());
        if direction.is_some() && axis.is_none() {
            let found = said.axis.unwrap_or_default();
            let rule = "`axis` is a direction: three finite numbers that are not all 0";
            self.part_fault(i, "axis", &format!("{rule}, found {found:?}"));
        }
        let pivot = said.pivot.map(|p| frame.point_to_object(DVec3::from_array(p)));
        if pivot.is_some_and(|p| !p.is_finite()) {
            self.part_fault(i, "pivot", "`pivot` is a point: three finite numbers");
        }
        let rest = said.rest.as_ref().and_then(|rest| self.quantity(i, "rest", rest, said.kind));
        let range = said.range.as_ref().and_then(|range| self.range(i, range, rest, said.kind));
        let open_by = rest.filter(|_| said.range.is_none());
        let most = if said.kind.turns() { std::f64::consts::TAU } else { LONGEST };
        if let Some(rest) = open_by.filter(|rest| !(0.0..=most).contains(rest)) {
            let rule = "without a `range`, `rest` says how far it is open";
            let unit = if said.kind.turns() { "rad" } else { "m" };
            self.part_fault(
                i,
                "rest",
                &format!("{rule}, from 0 to {most:.4} {unit}; found {rest}"),
            );
        }
        if said.rest.is_some() && said.kind == JointKind::Continuous {
            self.part_fault(i, "rest", "a continuous joint turns without end and has no `rest`");
        }
        GivenJoint { axis, pivot, range, open_by, effort: said.effort, damping: said.damping }
    }

    fn quantity(
        &mut self,
        i: usize,
        field: &'static str,
        quantity: &Quantity,
        kind: JointKind,
    ) -> Option<f64> {
        match quantity.value(kind.turns()) {
            Ok(value) => Some(value),
            Err(why) => {
                self.part_fault(i, field, &format!("`{field}`: {why}"));
                None
            }
        }
    }

    /// A range about the pose that the mesh shows.
    fn range(
        &mut self,
        i: usize,
        [lower, upper]: &[Quantity; 2],
        rest: Option<f64>,
        kind: JointKind,
    ) -> Option<Range> {
        if kind == JointKind::Continuous {
            let rule =
                "a continuous joint turns without end: leave `range` out, or make it revolute";
            self.part_fault(i, "range", rule);
            return None;
        }
        let lower = self.quantity(i, "range", lower, kind)?;
        let upper = self.quantity(i, "range", upper, kind)?;
        let most = if kind.turns() { std::f64::consts::TAU } else { LONGEST };
        let unit = if kind.turns() { "rad" } else { "m" };
        if !(LEAST..=most * (1.0 + 1e-12)).contains(&(upper - lower)) {
            let rule = format!(
                "`range` goes from its lower to its upper end, over {LEAST} to {most:.4} {unit}"
            );
            self.part_fault(i, "range", &format!("{rule}; found {lower} to {upper}"));
            return None;
        }
        let rest = rest.unwrap_or(0.0);
        if !(lower..=upper).contains(&rest) {
            let rule = "`rest`, where the mesh shows it (0 unless said), lies within `range`";
            self.part_fault(i, "rest", &format!("{rule}; found {rest} and {lower} to {upper}"));
            return None;
        }
        Some(Range::Limits { lower: lower - rest, upper: upper - rest })
    }
}
