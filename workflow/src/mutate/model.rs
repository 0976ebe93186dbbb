//! A sound model as defects are planted in it: its text, what it says, and the files it needs.

use glamx::DVec3;
use object::mesh::Bounds;
use sim_check::geometry::tessellate::tessellated;
use sim_check::read::source::{At, Edit, Source};
use sim_check::robot::{Joint, Link, Motion, Shape};
use sim_check::{Robot, Subject};

use super::language::Language;
use super::needed::Needed;
use crate::fix::numbers::{short, triple};

/// A sound model.
pub struct Model {
    /// What it is written in.
    pub language: Language,
    /// Its text as it stands in the copies.
    pub source: Source,
    /// What it says.
    pub robot: Robot,
    /// What it is judged as.
    pub subject: Subject,
    /// The files that it needs.
    pub needed: Vec<Needed>,
    /// Seed of which joint, link or mesh is taken.
    pub seed: u64,
}

/// A joint with its element.
#[derive(Clone, Copy)]
pub(super) struct Mover<'m> {
    pub joint: &'m Joint,
    pub at: At,
}

/// What a link shows or touches.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Visual,
    Collision,
}

impl Model {
    /// Indices in an order that follows from the seed and a word.
    pub(super) fn order(&self, word: &str, count: usize) -> Vec<usize> {
        // FNV-1a, and SplitMix64 behind it: the same on every machine.
        let start = word.bytes().fold(0xcbf2_9ce4_8422_2325_u64 ^ self.seed, |h, b| {
            (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
        });
        let mut keys: Vec<(u64, usize)> = (0..count)
            .map(|i| {
                let mut z = start.wrapping_add((i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
                z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                (z ^ (z >> 31), i)
            })
            .collect();
        keys.sort_unstable();
        keys.into_iter().map(|(_, i)| i).collect()
    }

    /// The same things in that order.
    pub(super) fn drawn<T>(&self, word: &str, mut all: Vec<T>) -> Vec<T> {
        let mut places: Vec<Option<T>> = all.drain(..).map(Some).collect();
        let order = self.order(word, places.len());
        order.into_iter().filter_map(|i| places[i].take()).collect()
    }

    /// The only element of that name and `name`, else the only one on that line.
    fn element(&self, tag: &str, name: &str, line: u32) -> Option<At> {
        let named = self.source.named(tag, name).filter(|at| self.source.line(*at) == line);
        let is_urdf = self.language == Language::Urdf;
        named.or_else(|| self.source.on_line(tag, line).filter(|_| !is_urdf))
    }

    /// The element of a link or body.
    pub(super) fn link_at(&self, link: &Link) -> Option<At> {
        let tag = if self.language == Language::Mjcf { "body" } else { "link" };
        self.element(tag, &link.name, link.line)
    }

    /// The joints that have an axis and follow no other, with their elements, as drawn.
    pub(super) fn movers(&self, word: &str) -> Vec<Mover<'_>> {
        let free = |j: &&Joint| j.kind.has_axis() && j.mimic.is_none();
        let found = |joint| Some(Mover { joint, at: self.joint_at(joint)? });
        self.drawn(word, self.robot.joints.iter().filter(free).filter_map(found).collect())
    }

    /// The element of a joint.
    pub(super) fn joint_at(&self, joint: &Joint) -> Option<At> {
        self.element("joint", &joint.name, joint.line)
    }

    /// Of those the ones with a range, and the range as it is told.
    pub(super) fn ranged(&self, word: &str) -> Vec<(Mover<'_>, [f64; 2])> {
        let range = |m: &Mover| {
            let (lower, upper) = m.joint.limits_as_written()?;
            let is_one = m.joint.kind != Motion::Continuous && lower < upper;
            (is_one && lower.is_finite() && upper.is_finite()).then_some([lower, upper])
        };
        self.movers(word).into_iter().filter_map(|m| Some((m, range(&m)?))).collect()
    }

    /// The link that a joint moves.
    pub(super) fn child(&self, mover: &Mover) -> &Link {
        &self.robot.links[mover.joint.child]
    }

    /// Links that a joint of their own moves, with their elements, as drawn.
    pub(super) fn parts(&self, word: &str) -> Vec<(usize, &Link, At)> {
        let moves = |l: usize| {
            let above = self.robot.joint_above(l);
            above.is_some_and(|j| self.robot.joints[j].kind.has_axis())
        };
        let links = self.robot.links.iter().enumerate().filter(|(l, _)| moves(*l));
        let found = |(l, link)| Some((l, link, self.link_at(link)?));
        self.drawn(word, links.filter_map(found).collect())
    }

    /// The elements of what a link shows or touches, with what they say.
    pub(super) fn shapes<'m>(&self, link: &'m Link, at: At, role: Role) -> Vec<(&'m Shape, At)> {
        let all = match role {
            Role::Visual => &link.visuals,
            Role::Collision => &link.collisions,
        };
        if self.language == Language::Mjcf {
            let own = |s: &'m Shape| Some((s, self.source.on_line("geom", s.line)?));
            return all.iter().filter_map(own).collect();
        }
        let tag = if role == Role::Visual { "visual" } else { "collision" };
        let elements = self.source.children(at, tag);
        if elements.len() == all.len() { all.iter().zip(elements).collect() } else { Vec::new() }
    }

    /// Those that are of no other role, too: MJCF has geoms that are both.
    pub(super) fn own_shapes<'m>(
        &self,
        link: &'m Link,
        at: At,
        role: Role,
    ) -> Vec<(&'m Shape, At)> {
        let other = if role == Role::Visual { &link.collisions } else { &link.visuals };
        let is_both =
            |s: &Shape| self.language == Language::Mjcf && other.iter().any(|o| o.line == s.line);
        self.shapes(link, at, role).into_iter().filter(|(s, _)| !is_both(s)).collect()
    }

    /// Points of everything that a link shows and touches, in its frame.
    pub(super) fn points(&self, link: usize) -> Vec<DVec3> {
        let link = &self.robot.links[link];
        let of = |shape: &Shape| {
            let mesh = tessellated(&shape.geometry).ok();
            let place = shape.origin;
            mesh.map_or(vec![], |m| {
                m.vertices().iter().map(|p| place.transform_point(*p)).collect()
            })
        };
        link.visuals.iter().chain(&link.collisions).flat_map(of).collect()
    }

    /// The box around a link's shapes in its frame; none where it has none.
    pub(super) fn bounds(&self, link: usize) -> Option<Bounds> {
        let points = self.points(link);
        (!points.is_empty()).then(|| Bounds::of(points))
    }

    /// The box around all of it at rest.
    pub(super) fn whole(&self) -> Option<Bounds> {
        let poses = self.robot.link_poses(&[]);
        let of = |l: usize| {
            let pose = poses[l];
            self.points(l).into_iter().map(move |p| pose.transform_point(p))
        };
        let points: Vec<DVec3> = (0..self.robot.links.len()).flat_map(of).collect();
        (!points.is_empty()).then(|| Bounds::of(points))
    }

    /// Its diagonal, metres.
    ///
    /// # Errors
    /// That it has no shape.
    pub(super) fn diagonal(&self) -> Result<f64, String> {
        let whole = self.whole().map(|b| b.diagonal()).filter(|d| *d > 0.0 && d.is_finite());
        whole.ok_or_else(|| "the model has no shape whose size would tell how far".into())
    }

    /// Whether angles in its text are degrees.
    fn in_degrees(&self) -> bool {
        let root = self.source.root();
        let compilers = self.source.children(root, "compiler");
        let told = compilers.iter().rev().find_map(|c| self.source.get(*c, "angle"));
        self.language == Language::Mjcf && told != Some("radian")
    }

    /// A value of a joint as its text tells it.
    pub(super) fn told(&self, joint: &Joint, value: f64) -> String {
        let degrees = self.in_degrees() && joint.kind.turns();
        short(if degrees { value.to_degrees() } else { value })
    }

    /// The element with this text in it, put in where there is none; for SDF, whose numbers are texts.
    pub(super) fn text(&self, at: At, tag: &str, told: &str) -> Edit {
        let told = format!("<{tag}>{told}</{tag}>");
        match self.source.child(at, tag) {
            Some(child) => self.source.replace(child, told),
            None => self.source.insert_last(at, &told),
        }
    }

    /// The numbers in an element of SDF.
    pub(super) fn numbers(&self, at: At) -> Vec<f64> {
        let written = self.source.written(at);
        let from = written.find('>').map_or(0, |i| i + 1);
        let to = written.rfind("</").unwrap_or(written.len()).max(from);
        written[from..to].split_whitespace().map_while(|w| w.parse().ok()).collect()
    }

    /// A child of an element, or why there is none.
    pub(super) fn child_of(&self, at: At, tag: &str) -> Result<At, String> {
        let found = self.source.child(at, tag);
        found.ok_or_else(|| format!("<{}> has not one <{tag}>", self.source.tag(at)))
    }

    /// Another place of what an element's `<origin>`, `pos` or `<pose>` tells: moved by this, in the
    /// frame that it is told in.
    pub(super) fn moved(&self, at: At, from: DVec3, by: DVec3) -> Result<Edit, String> {
        let there = triple(from + by);
        Ok(match self.language {
            Language::Urdf => match self.source.child(at, "origin") {
                Some(origin) => self.source.set(origin, "xyz", &there),
                None => self.source.insert_first(at, &format!("<origin xyz=\"{there}\"/>")),
            },
            Language::Mjcf => {
                if self.source.get(at, "fromto").is_some() {
                    return Err("it is told by its two ends".into());
                }
                let old = self.source.get(at, "pos").map_or(Some(DVec3::ZERO), vector);
                let old = old.ok_or("its place is not three numbers")?;
                self.source.set(at, "pos", &triple(old + by))
            }
            Language::Sdf => {
                let pose = self.source.child(at, "pose");
                let old = pose.map_or(vec![0.0; 6], |p| self.numbers(p));
                if old.len() != 6 {
                    return Err("its <pose> is not six numbers".into());
                }
                let there = DVec3::new(old[0], old[1], old[2]) + by;
                let turn: Vec<String> = old[3..].iter().map(|v| short(*v)).collect();
                let told = format!("<pose>{} {}</pose>", triple(there), turn.join(" "));
                match pose {
                    Some(pose) if self.source.get(pose, "relative_to").is_some() => {
                        return Err("its <pose> is told from another frame".into());
                    }
                    Some(pose) => self.source.replace(pose, told),
                    None => self.source.insert_first(at, &told),
                }
            }
        })
    }

    /// A part moved by this, told in the frame of the link it hangs on.
    pub(super) fn part_moved(&self, mover: &Mover, by: DVec3) -> Result<Edit, String> {
        if mover.joint.rest != 0.0 {
            return Err("it is not told from where it stands at rest".into());
        }
        match self.language {
            Language::Urdf => self.moved(mover.at, mover.joint.origin.translation, by),
            Language::Mjcf => self.moved(self.body(mover)?, DVec3::ZERO, by),
            Language::Sdf => {
                let at = self.link_at(self.child(mover)).ok_or("its link has no element")?;
                let parent = self.robot.link_poses(&[])[mover.joint.parent];
                self.moved(at, DVec3::ZERO, parent.rotation * by)
            }
        }
    }

    /// The body that a joint of MJCF stands in, if it alone moves it.
    pub(super) fn body(&self, mover: &Mover) -> Result<At, String> {
        let body = self.source.parent(mover.at).filter(|b| self.source.tag(*b) == "body");
        let body = body.ok_or("its joint stands in no body")?;
        match self.source.children(body, "joint").len() {
            1 => Ok(body),
            _ => Err("several joints move its body".into()),
        }
    }
}

/// Three numbers.
pub(super) fn vector(text: &str) -> Option<DVec3> {
    let all: Vec<f64> = text.split_whitespace().map_while(|w| w.parse().ok()).collect();
    match all[..] {
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

/// A word of strangers in back quotes, as findings write names.
pub(super) fn quoted(what: &str, name: &str) -> String {
    format!("{what} `{name}`")
}
