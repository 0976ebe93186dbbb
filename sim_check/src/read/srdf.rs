//! SRDF → what a planner is told of a robot: pairs of links that may meet, and named states.
//!
//! It lies beside the URDF under the same name, or where the caller says. Simulators do not read it, and a
//! person is told so.

use roxmltree::{Document, Node, ParsingOptions};

use crate::read::caps::{self, MAX_NODES};
use crate::read::draft::Draft;
use crate::robot::Unread;

/// Most bytes of an SRDF; a guess, ten times the longest met.
pub(crate) const MOST_BYTES: u64 = 8 << 20;
/// What depends on pairs that may meet, and on the pose a robot is judged at.
const DEPEND: &[&str] = &["C1", "C2", "C3", "C4", "C5", "S1", "S2", "S3", "S4", "S5"];
/// The state that is taken before others.
const HOME: &str = "home";

/// Adds what an SRDF says. `name` is told where something is wrong with it.
pub(crate) fn add(draft: &mut Draft, name: &str, text: Result<String, String>) {
    let unread = |why: String| Unread { what: format!("{name}: {why}"), checks: DEPEND };
    let text = match text {
        Ok(text) => text,
        Err(why) => return draft.beside.unread.push(unread(why)),
    };
    if let Some(why) = caps::broken(&text) {
        return draft.beside.unread.push(unread(why));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = match Document::parse_with_options(&text, options) {
        Ok(document) => document,
        Err(e) => return draft.beside.unread.push(unread(format!("not XML: {e}"))),
    };
    let root = document.root_element();
    if !root.has_tag_name("robot") {
        let found = root.tag_name().name();
        return draft.beside.unread.push(unread(format!("expected `robot`, found `{found}`")));
    }
    pairs(draft, name, root);
    states(draft, root);
}

fn pairs(draft: &mut Draft, name: &str, root: Node<'_, '_>) {
    let mut count = 0;
    for node in root.children().filter(|n| n.has_tag_name("disable_collisions")) {
        let pair = ["link1", "link2"].map(|a| node.attribute(a).unwrap_or_default().to_owned());
        let unknown = pair.iter().find(|link| draft.links.iter().all(|l| l.name != **link));
        if let Some(link) = unknown {
            let line = node.document().text_pos_at(node.range().start).row;
            let words = format!("{name} line {line}: there is no link `{link}`");
            draft.beside.flags.push(("C1", words));
            continue;
        }
        count += 1;
        draft.apart.push(pair);
    }
    if count > 0 {
        let words = format!(
            "{name} lets {count} pairs of links pass through each other: planners read that, simulators do not"
        );
        draft.beside.flags.push(("C1", words));
        draft.beside.signs.push(format!("{name} beside it"));
    }
}

/// The pose that its states declare together, those called `home` first.
fn states(draft: &mut Draft, root: Node<'_, '_>) {
    let mut states: Vec<_> = root.children().filter(|n| n.has_tag_name("group_state")).collect();
    states.sort_by_key(|n| n.attribute("name") != Some(HOME));
    for state in states {
        for joint in state.children().filter(|n| n.has_tag_name("joint")) {
            let (Some(of), Some(value)) = (joint.attribute("name"), joint.attribute("value"))
            else {
                continue;
            };
            // A joint of several values is none of the kinds that have a range.
            if let Ok(value) = value.trim().parse::<f64>()
                && value.is_finite()
                && !draft.rests.contains_key(of)
            {
                draft.rests.insert(of.to_owned(), value);
                if draft.declared.is_empty() {
                    draft.declared = state.attribute("name").unwrap_or("the first").to_owned();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Asked, CheckOptions, Status, Tier, check};

    /// A leg that is never at 0, whose first and last box overlap by 20 mm.
    fn urdf() -> String {
        let link = |name: &str, x: f64| {
            let shape = format!(
                "<origin xyz=\"{x} 0 0.1\"/><geometry><box size=\"0.2 0.2 0.2\"/></geometry>"
            );
            format!(
                "<link name=\"{name}\"><visual>{shape}</visual><collision>{shape}</collision><inertial>\
                 <origin xyz=\"{x} 0 0.1\"/><mass value=\"1\"/><inertia ixx=\"0.007\" iyy=\"0.007\" izz=\"0.007\" \
                 ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
            )
        };
        let joint = |name: &str, parent: &str, child: &str, ends: &str| {
            format!(
                "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
                 <axis xyz=\"1 0 0\"/><limit {ends} effort=\"20\" velocity=\"1\"/></joint>"
            )
        };
        format!(
            "<robot name=\"r\">{}{}{}{}{}</robot>",
            link("a", 0.0),
            link("b", 0.5),
            link("c", 0.18),
            joint("knee", "a", "b", "lower=\"0.5\" upper=\"1\""),
            joint("ankle", "b", "c", "lower=\"-0.1\" upper=\"0.1\"")
        )
    }

    fn judged(srdf: Option<&str>) -> crate::Verdict {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("r.urdf");
        std::fs::write(&file, urdf()).unwrap();
        if let Some(srdf) = srdf {
            std::fs::write(folder.path().join("r.srdf"), srdf).unwrap();
        }
        let (up_to, subject) = (Tier::Kinematic, Asked::Found);
        check(&file, &CheckOptions { up_to, subject, ..CheckOptions::default() })
    }

    #[test]
    fn pairs_of_an_srdf_may_meet_and_a_person_is_told_that_simulators_do_not_read_it() {
        assert_eq!(judged(None).check("C1").unwrap().status, Status::Fail);
        let srdf = "<robot name=\"r\"><disable_collisions link1=\"a\" link2=\"c\" reason=\"Never\"/>\n\
                    <disable_collisions link1=\"a\" link2=\"z\"/></robot>";
        let verdict = judged(Some(srdf));
        let c1 = verdict.check("C1").unwrap();
        assert_eq!(c1.status, Status::Warn, "{c1:?}");
        let words = c1.evidence.join("\n");
        assert!(
            words.contains("r.srdf lets 1 pairs") && words.contains("line 2: there is no link `z`"),
            "{words}"
        );
    }

    #[test]
    fn a_robot_is_judged_at_the_home_state_of_its_srdf() {
        let srdf = "<robot name=\"r\"><group_state name=\"far\" group=\"g\"><joint name=\"knee\" value=\"0.9\"/>\
                    </group_state><group_state name=\"home\" group=\"g\"><joint name=\"knee\" value=\"0.6\"/>\
                    <joint name=\"ankle\" value=\"0\"/></group_state></robot>";
        let said = serde_json::to_string(&judged(Some(srdf))).unwrap();
        assert!(said.contains("home"), "{said}");
    }

    #[test]
    fn what_depends_on_an_srdf_that_cannot_be_read_is_unknown() {
        for srdf in ["<robot", "<mujoco/>", "not XML"] {
            let verdict = judged(Some(srdf));
            let c1 = verdict.check("C1").unwrap();
            assert_eq!(c1.status, Status::Unknown, "{srdf}: {c1:?}");
            assert!(c1.evidence[0].contains("r.srdf"), "{c1:?}");
            assert_eq!(verdict.check("M1").unwrap().status, Status::Pass);
        }
    }
}
