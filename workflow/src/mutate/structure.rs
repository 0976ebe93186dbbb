//! Text, names and the tree: `xml-broken`, `link-…`, `two-…`, `cycle`, `joint-…`, `mimic-…`.

use sim_check::read::source::{At, Edit};
use sim_check::robot::Motion;
use sim_check::verdict::figure;

use super::language::Language;
use super::model::{Model, Mover, quoted};
use super::planted::{Made, Planted, first, made};

/// The name that nothing has.
const NOBODY: &str = "not_there";
const NO_JOINT: &str = "no joint of its own stands in this file";

pub(super) fn broken(model: &Model, _: &str) -> Made {
    let whole = model.source.whole();
    let end = whole.rfind("</").ok_or("it has no closing tag")?;
    let subject = "the model".to_owned();
    let line = whole[..end].matches('\n').count() as u32 + 1;
    let (words, text) = ("the last closing tag left out".to_owned(), Some(whole[..end].to_owned()));
    Ok(Planted { subject, line, words, text, ..Planted::default() })
}

/// The place of a part written otherwise.
fn place(model: &Model, word: &str, of: impl Fn([String; 3]) -> String) -> Made {
    first(model.movers(word), NO_JOINT, |mover| {
        let source = &model.source;
        let three = |told: &str| -> Result<[String; 3], String> {
            let all: Vec<String> = told.split_whitespace().map(String::from).collect();
            all.try_into().map_err(|_| "its place is not three numbers".into())
        };
        let zeros = || ["0", "0", "0"].map(String::from);
        let (told, edit): (String, Edit) = match model.language {
            Language::Urdf => match source.child(mover.at, "origin") {
                Some(origin) => {
                    let told = of(source.get(origin, "xyz").map_or(Ok(zeros()), three)?);
                    (told.clone(), source.set(origin, "xyz", &told))
                }
                None => {
                    let told = of(zeros());
                    let origin = format!("<origin xyz=\"{told}\"/>");
                    (told, source.insert_first(mover.at, &origin))
                }
            },
            Language::Mjcf => {
                let body = source.parent(mover.at).filter(|b| source.tag(*b) == "body");
                let body = body.ok_or("its joint stands in no body")?;
                let told = of(source.get(body, "pos").map_or(Ok(zeros()), three)?);
                (told.clone(), source.set(body, "pos", &told))
            }
            Language::Sdf => {
                let at = model.link_at(model.child(&mover)).ok_or("its link has no element")?;
                let pose = model.child_of(at, "pose")?;
                let was: Vec<String> =
                    model.numbers(pose).iter().map(|v| crate::fix::numbers::short(*v)).collect();
                let (head, tail) =
                    was.split_at_checked(3).ok_or("its <pose> is not six numbers")?;
                let told = of(three(&head.join(" "))?);
                let written = format!("<pose>{told} {}</pose>", tail.join(" "));
                (told, source.replace(pose, written))
            }
        };
        let name = &model.child(&mover).name;
        let words = format!("place `{told}`");
        made(quoted("link", name), mover.joint.line, words, vec![edit])
    })
}

pub(super) fn not_a_number(model: &Model, word: &str) -> Made {
    place(model, word, |[_, y, z]| format!("nan {y} {z}"))
}

pub(super) fn comma(model: &Model, word: &str) -> Made {
    place(model, word, |[x, y, z]| {
        let told = if x.contains('.') { x.replace('.', ",") } else { format!("{x},0") };
        format!("{told} {y} {z}")
    })
}

pub(super) fn two_numbers(model: &Model, word: &str) -> Made {
    place(model, word, |[x, y, _]| format!("{x} {y}"))
}

/// Joints that are elements of their own, as drawn: of MJCF there are none.
fn joints(model: &Model, word: &str) -> Vec<(usize, At)> {
    let all = model.robot.joints.iter().enumerate();
    let found: Vec<(usize, At)> =
        all.filter_map(|(j, joint)| Some((j, model.joint_at(joint)?))).collect();
    model.drawn(word, found)
}

/// The edit by which a joint names another link.
fn named(model: &Model, joint: At, tag: &str, link: &str) -> Result<Edit, String> {
    let at = model.child_of(joint, tag)?;
    Ok(match model.language {
        Language::Sdf => {
            model.source.replace(at, format!("<{tag}>{}</{tag}>", guard::text::markup(link)))
        }
        _ => model.source.set(at, "link", link),
    })
}

pub(super) fn link_missing(model: &Model, word: &str) -> Made {
    first(joints(model, word), NO_JOINT, |(j, at)| {
        let joint = &model.robot.joints[j];
        let edit = named(model, at, "parent", NOBODY)?;
        made(quoted("joint", &joint.name), joint.line, format!("parent `{NOBODY}`"), vec![edit])
    })
}

pub(super) fn link_twice(model: &Model, word: &str) -> Made {
    let links = model.robot.links.iter();
    let found: Vec<_> = links.filter_map(|l| Some((l, model.link_at(l)?))).collect();
    let found: Vec<_> = model
        .drawn(word, found)
        .into_iter()
        .filter(|(_, at)| model.source.get(*at, "name").is_some())
        .collect();
    let [(one, _), (other, at), ..] = found[..] else {
        return Err("it has no two links with names".into());
    };
    let edit = model.source.set(at, "name", &one.name);
    let words = format!("called `{}`, as another one", one.name);
    made(quoted("link", &other.name), other.line, words, vec![edit])
}

pub(super) fn joint_twice(model: &Model, word: &str) -> Made {
    let found: Vec<(usize, At)> = joints(model, word)
        .into_iter()
        .filter(|(_, at)| model.source.get(*at, "name").is_some())
        .collect();
    let [(one, _), (other, at), ..] = found[..] else {
        return Err("it has no two joints with names".into());
    };
    let [one, other] = [one, other].map(|j| &model.robot.joints[j]);
    let edit = model.source.set(at, "name", &one.name);
    let words = format!("called `{}`, as another one", one.name);
    made(quoted("joint", &other.name), other.line, words, vec![edit])
}

pub(super) fn two_roots(model: &Model, word: &str) -> Made {
    let followed =
        |j: usize| model.robot.joints.iter().any(|o| o.mimic.is_some_and(|m| m.joint == j));
    let all = joints(model, word).into_iter().filter(|(j, _)| !followed(*j));
    first(all, NO_JOINT, |(j, at)| {
        let joint = &model.robot.joints[j];
        let edit = model.source.remove(at);
        made(quoted("joint", &joint.name), joint.line, "left out", vec![edit])
    })
}

/// A joint that ties two links.
fn tied(model: &Model, parent: &str, child: &str) -> Result<Edit, String> {
    let [parent, child] = [parent, child].map(|name| guard::text::markup(name).into_owned());
    let root = model.source.root();
    Ok(match model.language {
        Language::Sdf => {
            let at = match model.source.child(root, "model") {
                Some(at) => at,
                None => model.child_of(model.child_of(root, "world")?, "model")?,
            };
            model.source.insert_last(
                at,
                &format!(
                    "<joint name=\"one_too_many\" type=\"fixed\">\n\t<parent>{parent}</parent>\n\t<child>{child}</child>\n</joint>"
                ),
            )
        }
        _ => model.source.insert_last(
            root,
            &format!(
                "<joint name=\"one_too_many\" type=\"fixed\">\n\t<parent link=\"{parent}\"/>\n\t<child link=\"{child}\"/>\n</joint>"
            ),
        ),
    })
}

/// Links that hang on a joint of this file, as drawn.
fn hanging(model: &Model, word: &str) -> Vec<usize> {
    joints(model, word).into_iter().map(|(j, _)| model.robot.joints[j].child).collect()
}

pub(super) fn two_parents(model: &Model, word: &str) -> Made {
    first(hanging(model, word), NO_JOINT, |child| {
        let robot = &model.robot;
        let link = &robot.links[child];
        // Not one below it, which would be a circle.
        let other = (0..robot.links.len())
            .find(|l| !robot.is_under(*l, child) && Some(*l) != robot.parent(child));
        let other = other.or(robot.parent(child)).ok_or("nothing hangs on anything")?;
        let parent = &robot.links[other].name;
        let edit = tied(model, parent, &link.name)?;
        made(quoted("link", &link.name), link.line, format!("hung on `{parent}`, too"), vec![edit])
    })
}

pub(super) fn cycle(model: &Model, word: &str) -> Made {
    first(hanging(model, word), NO_JOINT, |child| {
        let robot = &model.robot;
        let (root, link) = (&robot.links[robot.root()], &robot.links[child]);
        let edit = tied(model, &link.name, &root.name)?;
        made(quoted("link", &root.name), root.line, format!("hung on `{}`", link.name), vec![edit])
    })
}

pub(super) fn upside_down(model: &Model, word: &str) -> Made {
    first(joints(model, word), NO_JOINT, |(j, at)| {
        let joint = &model.robot.joints[j];
        let [parent, child] = [joint.parent, joint.child].map(|l| &model.robot.links[l].name);
        let edits = vec![named(model, at, "parent", child)?, named(model, at, "child", parent)?];
        made(quoted("joint", &joint.name), joint.line, "parent and child swapped", edits)
    })
}

fn typed(model: &Model, mover: &Mover, told: &str) -> Made {
    let edit = model.source.set(mover.at, "type", told);
    let joint = mover.joint;
    made(quoted("joint", &joint.name), joint.line, format!("type `{told}`"), vec![edit])
}

pub(super) fn unknown_type(model: &Model, word: &str) -> Made {
    let told = if model.language == Language::Mjcf { "revolute" } else { "hinge" };
    first(model.movers(word), NO_JOINT, |mover| typed(model, &mover, told))
}

pub(super) fn fixed(model: &Model, word: &str) -> Made {
    // Its range tells that it should move.
    let all = model.ranged(word).into_iter();
    first(all, "no joint has a range", |(mover, _)| typed(model, &mover, "fixed"))
}

pub(super) fn endless(model: &Model, word: &str) -> Made {
    let hinges = model.ranged(word).into_iter();
    let hinges = hinges.filter(|(m, _)| m.joint.kind == Motion::Revolute);
    first(hinges, "no hinge has a range", |(mover, _)| typed(model, &mover, "continuous"))
}

pub(super) fn other_motion(model: &Model, word: &str) -> Made {
    let all = model.ranged(word);
    first(all, "no joint has a range", |(mover, _)| {
        let slides = mover.joint.kind == Motion::Prismatic;
        let told = match (slides, model.language) {
            (false, Language::Mjcf) => "slide",
            (false, _) => "prismatic",
            (true, Language::Mjcf) => "hinge",
            (true, _) => "revolute",
        };
        typed(model, &mover, told)
    })
}

/// The edit that makes a joint follow another one.
fn follows(model: &Model, mover: &Mover, told: &str) -> Edit {
    let source = &model.source;
    match source.child(mover.at, "mimic") {
        Some(at) => source.replace(at, told.to_owned()),
        None => source.insert_last(mover.at, told),
    }
}

pub(super) fn mimic_missing(model: &Model, word: &str) -> Made {
    first(model.movers(word), NO_JOINT, |mover| {
        let joint = mover.joint;
        let edit = match model.language {
            Language::Mjcf => {
                if model.source.get(mover.at, "name").is_none() {
                    return Err("its joint has no name".into());
                }
                let name = guard::text::markup(&joint.name);
                let told = format!(
                    "<equality>\n\t<joint joint1=\"{name}\" joint2=\"{NOBODY}\"/>\n</equality>"
                );
                model.source.insert_last(model.source.root(), &told)
            }
            _ => follows(model, &mover, &format!("<mimic joint=\"{NOBODY}\"/>")),
        };
        made(quoted("joint", &joint.name), joint.line, format!("follows `{NOBODY}`"), vec![edit])
    })
}

pub(super) fn mimic_itself(model: &Model, word: &str) -> Made {
    first(model.movers(word), NO_JOINT, |mover| {
        let joint = mover.joint;
        let name = guard::text::markup(&joint.name);
        let edit = follows(model, &mover, &format!("<mimic joint=\"{name}\"/>"));
        made(quoted("joint", &joint.name), joint.line, "follows itself", vec![edit])
    })
}

pub(super) fn mimic_too_far(model: &Model, word: &str) -> Made {
    let all = model.ranged(word);
    let [(follower, own), (leader, lead), ..] = all[..] else {
        return Err("it has no two joints with ranges".into());
    };
    let far = |r: [f64; 2]| r[0].abs().max(r[1].abs());
    let factor = figure(10.0 * far(own) / far(lead));
    let name = guard::text::markup(&leader.joint.name);
    let told = format!("<mimic joint=\"{name}\" multiplier=\"{factor}\"/>");
    let edit = follows(model, &follower, &told);
    let words = format!("follows `{}` {factor} times as far", leader.joint.name);
    made(quoted("joint", &follower.joint.name), follower.joint.line, words, vec![edit])
}
