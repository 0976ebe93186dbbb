//! Asks a vision-language model what the parts are and where, and believes nothing unchecked.
//!
//! Three questions, each of one schema: which parts there are and how they hang together
//! ([`parts`]), where each is seen ([`points`]), and how large, of what and how heavy it all is
//! ([`physical`]). A fourth, only where it is configured, looks at what was made of the answers
//! ([`critic`]). Every rule about an answer is code; an answer
//! that breaks one goes back with the list of faults, twice at most, and then the question has
//! failed. Points are taken back to the surface and checked against each other before use.

pub mod critic;
#[cfg(test)]
mod critic_tests;
#[cfg(test)]
mod damage_tests;
pub mod dots;
mod motion;
pub mod parts;
pub mod physical;
pub mod pointing;
pub mod points;
pub mod repair;
pub mod scene;
pub mod schema;
pub mod settle;
#[cfg(test)]
mod tests;

use object::condition::{FileJoints, FilePart, SCHEMA, name_from_text};
use object::kinematics::JointKind;
use object::origin::Origin;
use object::{Condition, ConditionFile, Mesh};
use trace::Digest;
use view::{Camera, eight_views};

use self::parts::{JointWord, PartAnswer, PartsAnswer, Verdict};
use self::physical::PhysicalAnswer;
use self::points::Located;
pub use self::repair::Asking;
use self::repair::{REPAIR, SYSTEM};
use self::scene::Scene;
use crate::chat::{Codec, Piece};
use crate::generators::answer::shortened;
use crate::sent::sent;
use crate::{AdapterError, KinematicQuestion, RenderedView, Vlm};

const KINEMATICS: &str = include_str!("../prompts/kinematics.md");
const POINTS: &str = include_str!("../prompts/points.md");
const PHYSICAL: &str = include_str!("../prompts/physical.md");

impl<C: Codec> Vlm for Asking<C> {
    fn identity(&self) -> Result<String, AdapterError> {
        let words = Digest::of([SYSTEM, KINEMATICS, POINTS, PHYSICAL, REPAIR].concat().as_bytes());
        let who = self.codec.identity();
        Ok(format!("{who} prompts {} points {:?}", words.short(), self.convention))
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        let cameras = cameras(question.mesh, question.views)?;
        let answer = self.parts(question)?;
        if answer.verdict != Verdict::Articulated {
            let found = format!("{:?}: {}", answer.verdict, shortened(&answer.description));
            return Err(AdapterError::NotArticulated { who: self.codec.identity(), found });
        }
        let scene = Scene::new(question.mesh, &cameras);
        let located = self.points(question, &answer, &scene)?;
        let physical = self.physical(question, &answer)?;
        self.condition(&answer, &located, &physical, question.mesh)
    }
}

impl<C: Codec> Asking<C> {
    fn parts(&self, question: &KinematicQuestion<'_>) -> Result<PartsAnswer, AdapterError> {
        let photo = sent(question.photo)?;
        let mut pieces = vec![Piece::text(KINEMATICS)];
        pieces.push(Piece::picture(&photo.media_type, &photo.bytes));
        pieces.extend(pictures(question.views));
        let views = question.views.len();
        let judge = |value| parts::judged(value, views);
        self.repaired(("kinematics", schema::kinematics()), pieces, judge)
    }

    fn points(
        &self,
        question: &KinematicQuestion<'_>,
        answer: &PartsAnswer,
        scene: &Scene<'_>,
    ) -> Result<Vec<Located>, AdapterError> {
        let line = |p: &PartAnswer| {
            let views: Vec<_> = p.visible_views.iter().map(i64::to_string).collect();
            format!("- {}: {} (seen in views {})", p.id, p.text, views.join(", "))
        };
        let list: Vec<_> = answer.parts.iter().map(line).collect();
        let words = POINTS.replace("{parts}", &list.join("\n"));
        let words = words.replace("{convention}", self.convention.words());
        let mut pieces = vec![Piece::text(words)];
        pieces.extend(pictures(question.views));
        let judge = |value| points::judged(value, answer, scene, self.convention);
        self.repaired(("points", schema::points(self.convention.key())), pieces, judge)
    }

    fn physical(
        &self,
        question: &KinematicQuestion<'_>,
        answer: &PartsAnswer,
    ) -> Result<PhysicalAnswer, AdapterError> {
        let photo = sent(question.photo)?;
        let list: Vec<_> = answer.parts.iter().map(|p| format!("- {}: {}", p.id, p.text)).collect();
        let mut pieces = vec![Piece::text(PHYSICAL.replace("{parts}", &list.join("\n")))];
        pieces.push(Piece::picture(&photo.media_type, &photo.bytes));
        pieces.extend(pictures(question.views));
        let judge = |value| physical::judged(value, &answer.parts);
        self.repaired(("physical", schema::physical()), pieces, judge)
    }

    fn condition(
        &self,
        answer: &PartsAnswer,
        located: &[Located],
        physical: &PhysicalAnswer,
        mesh: &Mesh,
    ) -> Result<Condition, AdapterError> {
        let names = names(&answer.parts);
        let name_of =
            |id: &String| answer.parts.iter().position(|p| p.id == *id).map(|i| &names[i]);
        let part = |(part, name): (&PartAnswer, &String)| {
            let found = located.iter().find(|l| l.part == part.id);
            let mut file = FilePart {
                name: name.clone(),
                text: Some(part.text.trim().to_owned()),
                parent: part.parent.as_ref().and_then(name_of).cloned(),
                joint: FileJoints::from_kinds(part.joint_types.iter().map(kind).collect()),
                point: found.map(|l| mesh.frame().point_to_file(l.position).to_array()),
                ..FilePart::default()
            };
            physical.apply(&part.id, &mut file);
            file
        };
        let file = ConditionFile {
            schema: SCHEMA.into(),
            category: answer.category.clone(),
            up: Some(mesh.frame().up),
            size: Some(physical.size()),
            parts: answer.parts.iter().zip(&names).map(part).collect(),
            ..ConditionFile::default()
        };
        let wrap = |source| AdapterError::Condition { path: self.codec.identity(), source };
        let mut condition = file.resolve().map_err(wrap)?;
        condition.origin = Origin::Vlm;
        condition.check_points(mesh).map_err(wrap)?;
        Ok(condition)
    }
}

fn kind(word: &JointWord) -> JointKind {
    match word {
        JointWord::Revolute => JointKind::Revolute,
        JointWord::Prismatic => JointKind::Prismatic,
    }
}

/// A name fit for a URDF for each part, unique.
fn names(parts: &[PartAnswer]) -> Vec<String> {
    let mut names = vec![];
    for part in parts {
        let name = name_from_text(&part.name, &names);
        names.push(name);
    }
    names
}

fn pictures(views: &[RenderedView]) -> impl Iterator<Item = Piece> {
    views.iter().map(|view| Piece::picture("image/png", &view.png))
}

/// The cameras the views were rendered with: the standard ones of that name and size.
fn cameras(mesh: &Mesh, views: &[RenderedView]) -> Result<Vec<Camera>, AdapterError> {
    let refuse = |view: &RenderedView, rule: &str, found: String| AdapterError::Photo {
        path: format!("view {}", view.name),
        rule: rule.into(),
        found,
    };
    let camera = |view: &RenderedView| {
        let [width, height] = png_size(&view.png)
            .ok_or_else(|| refuse(view, "a view must be a PNG", "something else".into()))?;
        if width != height {
            let found = format!("{width} × {height}");
            return Err(refuse(view, "a view must be square", found));
        }
        let standard = eight_views(&mesh.bounds(), width);
        let known = standard.into_iter().find(|v| v.name == view.name);
        let rule = "a view must be one of the eight standard ones";
        known.map(|v| v.camera).ok_or_else(|| refuse(view, rule, view.name.clone()))
    };
    views.iter().map(camera).collect()
}

fn png_size(png: &[u8]) -> Option<[u32; 2]> {
    let reader = image::ImageReader::new(std::io::Cursor::new(png)).with_guessed_format().ok()?;
    reader.into_dimensions().ok().map(|(width, height)| [width, height])
}
