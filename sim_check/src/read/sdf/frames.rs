//! Frames of an SDFormat model: what each is told in, what it is attached to, and where it stands.
//!
//! Every name is looked up in the model it stands in, and below it as `model::name`; so each frame stands
//! somewhere in its own model's frame, whatever surrounds that.

use std::collections::BTreeMap;

use glamx::DPose3;

/// The name of a model's own frame.
pub(super) const OWN: &str = "__model__";
/// The name of what all stands in.
pub(super) const WORLD: &str = "world";
const ROOT: &str = "__root__";
/// What parts the names of a model and of something in it.
pub(super) const WITHIN: &str = "::";

/// What a frame is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// A link, by the number of its body.
    Link(usize),
    /// A joint, with the name of its child.
    Joint(String),
    /// A frame, with what it is attached to.
    Plain(Option<String>),
    /// A model that stands in another, by the number of its scope.
    Model(usize),
    /// A model that became a part of the one around it.
    Merged,
}

/// A frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub kind: Kind,
    /// The scope whose names it uses.
    pub scope: usize,
    /// As told.
    pub told: DPose3,
    /// The name of the frame it is told in; `None` is that of its home.
    pub relative_to: Option<String>,
    /// The frame that stands for its model's own where that became part of another.
    pub home: Option<usize>,
    /// The frame of a model that is meant to stand where the model is told to.
    pub placement: Option<String>,
    pub line: u32,
}

/// A model or a world, and the names in it.
#[derive(Debug, Default)]
pub(super) struct Scope {
    /// Its frame in the scope around it, if it stands in one.
    pub frame: Option<usize>,
    pub names: BTreeMap<String, usize>,
    /// The link that what is attached to the model is attached to.
    pub canonical: Option<String>,
    pub is_world: bool,
}

/// All of them.
#[derive(Debug, Default)]
pub(super) struct Frames {
    pub scopes: Vec<Scope>,
    pub frames: Vec<Frame>,
    /// Where each stands in its own model's frame; `None` where that could not be told.
    places: Vec<Option<DPose3>>,
}

/// Frames within each other, the outermost first; none is the scope's own.
type Path = Vec<usize>;

impl Frames {
    /// What a name in a scope means.
    pub(super) fn path(&self, scope: usize, name: &str) -> Option<Path> {
        let mut path = Vec::new();
        let (mut at, mut rest) = (scope, name);
        loop {
            let (word, more) = rest.split_once(WITHIN).map_or((rest, None), |(w, m)| (w, Some(m)));
            let of = self.scopes.get(at)?;
            if more.is_none() && (word == OWN || of.is_world && (word == WORLD || word == ROOT)) {
                return Some(path);
            }
            let &frame = of.names.get(word)?;
            path.push(frame);
            match (more, &self.frames[frame].kind) {
                (None, _) => return Some(path),
                (Some(more), Kind::Model(inner)) => (at, rest) = (*inner, more),
                (Some(_), _) => return None,
            }
        }
    }

    /// The same for a frame's own words; its home where it says none.
    fn from(&self, frame: usize) -> Option<Path> {
        let Frame { scope, relative_to, home, .. } = &self.frames[frame];
        match relative_to.as_deref() {
            Some(name) if name != OWN || home.is_none() => self.path(*scope, name),
            _ => Some(home.iter().copied().collect()),
        }
    }

    fn placed_by(&self, frame: usize) -> Option<Path> {
        let Frame { kind, placement, .. } = &self.frames[frame];
        match (placement, kind) {
            (Some(name), Kind::Model(inner)) => self.path(*inner, name),
            _ => Some(Vec::new()),
        }
    }

    /// Finds where every frame stands; what cannot be told is listed by frame, with the reason.
    pub(super) fn settle(&mut self) -> Vec<(usize, String)> {
        #[derive(Clone, Copy, PartialEq)]
        enum State {
            New,
            Open,
            Done,
        }
        let (mut state, mut faults) = (vec![State::New; self.frames.len()], Vec::new());
        self.places = vec![None; self.frames.len()];
        for first in 0..self.frames.len() {
            let mut open = vec![first];
            while let Some(&frame) = open.last() {
                if state[frame] == State::Done {
                    open.pop();
                    continue;
                }
                let (from, placement) = (self.from(frame), self.placed_by(frame));
                let (Some(from), Some(placement)) = (from, placement) else {
                    let own = &self.frames[frame];
                    let name = own.relative_to.as_ref().or(own.placement.as_ref());
                    let name = name.map_or("", String::as_str);
                    faults.push((frame, format!("there is no frame `{name}`")));
                    state[frame] = State::Done;
                    continue;
                };
                let needed = || from.iter().chain(&placement).copied();
                if state[frame] == State::New {
                    state[frame] = State::Open;
                    let is_round = needed().any(|n| state[n] == State::Open);
                    if !is_round {
                        open.extend(needed().filter(|n| state[*n] == State::New));
                        continue;
                    }
                    faults.push((frame, "it is told in frames that go round in a circle".into()));
                    state[frame] = State::Done;
                    continue;
                }
                let there = |path: &Path| {
                    path.iter().try_fold(DPose3::identity(), |at, f| Some(at * self.places[*f]?))
                };
                let told = self.frames[frame].told;
                self.places[frame] =
                    there(&from).zip(there(&placement)).map(|(from, placement)| {
                        let at = from * told;
                        if placement == DPose3::identity() { at } else { at * placement.inverse() }
                    });
                state[frame] = State::Done;
            }
        }
        faults
    }

    /// Where a frame stands in its own model's.
    pub(super) fn place(&self, frame: usize) -> Option<DPose3> {
        self.places.get(frame).copied().flatten()
    }

    /// Where a name's frame stands in its scope's own.
    pub(super) fn named(&self, scope: usize, name: &str) -> Option<DPose3> {
        let path = self.path(scope, name)?;
        path.iter().try_fold(DPose3::identity(), |at, f| Some(at * self.place(*f)?))
    }

    /// Where a scope's own frame stands in the outermost one.
    pub(super) fn scope(&self, scope: usize) -> Option<DPose3> {
        let mut at = DPose3::identity();
        let mut next = self.scopes[scope].frame;
        while let Some(frame) = next {
            at = self.place(frame)? * at;
            next = self.scopes[self.frames[frame].scope].frame;
        }
        Some(at)
    }

    /// The body that a name in a scope is attached to; `Some(None)` is the world.
    pub(super) fn body(&self, scope: usize, name: &str) -> Option<Option<usize>> {
        let (mut at, mut name) = (scope, name.to_owned());
        // Each step goes to another frame; more of them go round in a circle.
        for _ in 0..=self.frames.len() + self.scopes.len() {
            let path = self.path(at, &name)?;
            let Some(&frame) = path.last() else {
                // The scope's own.
                let of = &self.scopes[at];
                if of.is_world {
                    return Some(None);
                }
                name = of.canonical.clone()?;
                continue;
            };
            let own = &self.frames[frame];
            (at, name) = match &own.kind {
                Kind::Link(body) => return Some(Some(*body)),
                Kind::Joint(child) => (own.scope, child.clone()),
                Kind::Plain(Some(to)) => (own.scope, to.clone()),
                Kind::Plain(None) | Kind::Merged => (own.scope, OWN.to_owned()),
                Kind::Model(inner) => (*inner, OWN.to_owned()),
            };
        }
        None
    }
}
