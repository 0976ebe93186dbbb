//! URDF, MJCF, SDFormat or USD on disk → robot, and the checks of the files and of the tree (F1–F3, T1–T4).
//!
//! ```
//! use sim_check::CheckOptions;
//! use sim_check::read::load::from_text;
//! let text = r#"<robot name="post"><link name="foot"/><link name="foot"/></robot>"#;
//! let loaded = from_text(text, ".".as_ref(), &CheckOptions::default());
//! let names = loaded.checks.iter().find(|c| c.id == "F3");
//! assert_eq!(names.map(|c| c.evidence[0].as_str()), Some("lines 1 and 1: two links are called `foot`"));
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use guard::files::Refused;
use guard::folder::{Caps, Folder};

use crate::options::{Asked, CheckOptions, Expected};
use crate::read::draft::{Draft, JointDraft, NameFault, Tie};
use crate::read::meshes::{Added, Decoded, Outside, Shelf};
use crate::read::{parse, rest, srdf, usd};
use crate::robot::{Format, Joint, Link, Mimic, Robot};
use crate::verdict::Check;

/// Most bytes a URDF may have (16 MiB).
pub const MAX_URDF_BYTES: u64 = 16 << 20;

/// Most bytes a USD file may have (256 MiB).
pub const MAX_USD_BYTES: u64 = 256 << 20;

/// What reading a URDF gave.
#[derive(Debug, Default)]
pub struct Loaded {
    /// Name of the robot; empty if unreadable.
    pub name: String,
    /// BLAKE3 of the file's bytes, hex; empty if unreadable.
    pub blake3: String,
    /// Number of links, even if they form no tree.
    pub links: usize,
    /// Number of joints that move, even if they form no tree.
    pub moving_joints: usize,
    /// F1–F3 and T1–T4.
    pub checks: Vec<Check>,
    /// The robot, if its numbers are finite and its links form one tree.
    pub robot: Option<Robot>,
}

/// Reads a URDF and its meshes; whatever is wrong stands in the checks.
pub fn read(urdf: &Path, options: &CheckOptions) -> Loaded {
    let bytes = match read_bytes(urdf, options.outside) {
        Ok(bytes) => bytes,
        Err(reason) => return unreadable(String::new(), &reason),
    };
    let blake3 = blake3::hash(&bytes).to_hex().to_string();
    if is_usd(urdf, &bytes) {
        let mut shelf = Shelf::with(folder_of(urdf), options.outside, &options.places);
        let draft = usd::read(bytes, &mut shelf);
        return Loaded { blake3, ..of_draft(draft, shelf, options) };
    }
    let text = String::from_utf8(bytes).map_err(|e| format!("the URDF is not UTF-8: {e}"));
    match text {
        Err(reason) => unreadable(blake3, &reason),
        Ok(text) => {
            let shelf = Shelf::with(folder_of(urdf), options.outside, &options.places);
            let states = states_of(urdf, options);
            Loaded { blake3, ..on_shelf(begun(&text), shelf, states, options) }
        }
    }
}

/// Whether a file is USD: by how it begins, and a packed one by its name, too.
pub fn is_usd(file: &Path, bytes: &[u8]) -> bool {
    let is_plain = [&b"#usda"[..], b"PXR-USDC"].iter().any(|head| bytes.starts_with(head));
    is_plain || bytes.starts_with(b"PK\x03\x04") && is_named_usd(file)
}

fn is_named_usd(file: &Path) -> bool {
    let is = |end: &str| file.extension().is_some_and(|e| e.eq_ignore_ascii_case(end));
    ["usd", "usda", "usdc", "usdz"].into_iter().any(is)
}

fn folder_of(urdf: &Path) -> &Path {
    urdf.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A text from where its XML begins.
pub(crate) fn begun(text: &str) -> &str {
    text.trim_start_matches('\u{feff}').trim_start()
}

/// What might stand in a model's file: its text, and meshes beside it that are not there yet.
#[derive(Clone, Debug, Default)]
pub struct Edition {
    /// The whole text.
    pub text: String,
    /// Meshes that it names and that stand nowhere yet.
    pub added: Added,
    /// What was decoded for earlier editions.
    pub decoded: Decoded,
}

/// Reads what might stand in a file instead of what does.
pub fn read_edition(urdf: &Path, edition: &Edition, options: &CheckOptions) -> Loaded {
    let blake3 = blake3::hash(edition.text.as_bytes()).to_hex().to_string();
    let shelf = Shelf::with(folder_of(urdf), options.outside, &options.places);
    let shelf = shelf.and(&edition.added, &edition.decoded);
    let states = states_of(urdf, options);
    Loaded { blake3, ..on_shelf(begun(&edition.text), shelf, states, options) }
}

/// Where a mesh that a model names lies, and its bytes.
///
/// # Errors
/// The rule that its path or its file breaks.
pub fn mesh_file(
    urdf: &Path,
    name: &str,
    options: &CheckOptions,
) -> Result<(PathBuf, Vec<u8>), String> {
    Shelf::with(folder_of(urdf), options.outside, &options.places).file(name)
}

/// Reads a URDF from its text; mesh paths are relative to `folder`.
pub fn from_text(text: &str, folder: &Path, options: &CheckOptions) -> Loaded {
    on_shelf(text, Shelf::with(folder, options.outside, &options.places), None, options)
}

/// An SRDF's name and its text, or why there is none.
type States = Option<(String, Result<String, String>)>;

/// The name and text of the SRDF that goes with a file: the one that is named, else the one of the same
/// name beside it.
fn states_of(urdf: &Path, options: &CheckOptions) -> States {
    let beside = urdf.with_extension("srdf");
    let (path, is_named) = match &options.places.srdf {
        Some(path) => (path.as_path(), true),
        None => (beside.as_path(), false),
    };
    let name = path.file_name().unwrap_or_default();
    let caps = Caps { file: srdf::MOST_BYTES, all: srdf::MOST_BYTES, ..Caps::default() };
    let read = match is_named {
        true => guard::files::read(path, srdf::MOST_BYTES),
        false => Folder::open(path.parent().unwrap_or(Path::new("")), caps)
            .and_then(|folder| folder.read(Path::new(name))),
    };
    let text = match read {
        Err(refused) if !is_named && refused.is_absence() => return None,
        Err(refused) => Err(refused.to_string()),
        Ok(bytes) => String::from_utf8(bytes).map_err(|_| "it is not UTF-8".to_owned()),
    };
    Some((name.to_string_lossy().into_owned(), text))
}

fn on_shelf(text: &str, mut shelf: Shelf, states: States, options: &CheckOptions) -> Loaded {
    let mut draft = parse::read(text, &mut shelf);
    if let Some((name, states)) = states.filter(|_| draft.format == Format::Urdf) {
        srdf::add(&mut draft, &name, states);
    }
    of_draft(draft, shelf, options)
}

fn of_draft(draft: Draft, shelf: Shelf, options: &CheckOptions) -> Loaded {
    if let Some(why) = draft.unanswered {
        let ids = ["F1", "F2", "F3", "T1", "T2", "T3"];
        let checks = ids.map(|id| Check::unknown(id, why.clone())).into();
        return Loaded { checks, ..Loaded::default() };
    }
    let name = draft.name.clone();
    let links = draft.links.len();
    let moving_joints = draft.joints.iter().filter(|j| j.joint.kind.moves()).count();
    let (is_whole, format) = (draft.faults.text.is_empty(), draft.format);
    let (mut checks, robot) = judge(draft, options.subject == Asked::Asset);
    if options.subject != Asked::Asset && format == Format::Urdf {
        let told = |paths: String| {
            format!("`{paths}` have one name: MuJoCo and Genesis take the first for all")
        };
        flag(&mut checks, "F2", shelf.shared_names().into_iter().map(told).collect());
    }
    flag_packages(&mut checks, &shelf.found_packages());
    flag_outside(&mut checks, shelf.found_outside());
    let robot = robot.filter(|_| is_whole);
    checks.push(match &robot {
        Some(robot) => check_empty_links(robot),
        None => Check::unknown("T3", "links and joints could not be read as one tree"),
    });
    checks.extend(options.expected.map(|expected| check_counts(robot.as_ref(), expected)));
    Loaded { name, blake3: String::new(), links, moving_joints, checks, robot }
}

/// Most bytes of a model, by what its name says it is: USD holds its meshes itself.
fn most_bytes(file: &Path) -> u64 {
    if is_named_usd(file) { MAX_USD_BYTES } else { MAX_URDF_BYTES }
}

/// The file's bytes. A link that leads out of its folder is one to somebody else's file.
///
/// # Errors
/// The rule that the file breaks.
pub fn read_bytes(urdf: &Path, outside: Outside) -> Result<Vec<u8>, String> {
    let name = Path::new(urdf.file_name().unwrap_or_default());
    let most = most_bytes(urdf);
    let caps = Caps { file: most, all: most, ..Caps::default() };
    let folder = Folder::open(urdf.parent().unwrap_or(Path::new("")), caps);
    let read = match folder.and_then(|folder| folder.read(name)) {
        Err(Refused::Outside) if outside == Outside::Allowed => guard::files::read(urdf, most),
        read => read,
    };
    let shown = name.to_string_lossy();
    read.map_err(|refused| match refused {
        Refused::NotRegular => format!("`{shown}` is not a file"),
        Refused::Outside => format!("`{shown}` leads out of its folder through a link"),
        Refused::TooLarge { most } => format!("it may have at most {most} bytes, found more"),
        refused => format!("`{shown}` {refused}"),
    })
}

fn unreadable(blake3: String, reason: &str) -> Loaded {
    let rest = ["F2", "F3", "T1", "T2", "T3"].map(|id| Check::unknown(id, reason));
    let checks = [Check::fail("F1").evidence(reason)].into_iter().chain(rest).collect();
    Loaded { blake3, checks, ..Loaded::default() }
}

/// The checks of files and tree, and the robot where there is one tree. `strict`: names that some
/// programs change are faults, not flags.
fn judge(draft: Draft, strict: bool) -> (Vec<Check>, Option<Robot>) {
    let Draft { name, links, joints, format, foreign, mut faults, .. } = draft;
    let Draft { beside, apart, ties, rests, declared, .. } = draft;
    if links.is_empty() && !faults.text.is_empty() {
        let rest = ["F2", "F3", "T1", "T2"].map(|id| Check::unknown(id, "nothing could be read"));
        let f1 = counted(Check::from_faults("F1", faults.text));
        return ([f1].into_iter().chain(rest).collect(), None);
    }
    let index: BTreeMap<&str, usize> =
        links.iter().enumerate().rev().map(|(i, l)| (l.name.as_str(), i)).collect();
    faults.references.extend(dangling(&joints, &index));
    faults.references.extend(tree_faults(&links, &joints));
    faults.types.extend(mimic_faults(&joints));
    let resolved = resolve(joints, &index);
    let is_tree = faults.references.is_empty() && faults.types.is_empty();
    let robot = resolved.filter(|_| is_tree && foreign.is_empty()).and_then(|joints| {
        let built = Robot::new(name, links, joints);
        built.map_err(|e| faults.references.push(e.to_string())).ok()
    });
    let robot = robot.map(|mut robot| {
        (robot.format, robot.beside) = (format, beside);
        beside_the_tree(&mut robot, &apart, &ties);
        rest::settle(&mut robot, &rests, &declared);
        robot
    });
    let (odd, names): (Vec<_>, Vec<_>) =
        faults.names.into_iter().partition(|name| name.is_odd && !strict);
    let words = |names: Vec<NameFault>| names.into_iter().map(|n| n.words).collect::<Vec<_>>();
    faults.text.extend(faults.numbers);
    faults.references.extend(faults.loose);
    let groups = [
        ("F1", faults.text),
        ("F2", faults.files),
        ("F3", words(names)),
        ("T1", faults.references),
        ("T2", faults.types),
    ];
    let mut checks: Vec<Check> =
        groups.into_iter().map(|(id, f)| counted(Check::from_faults(id, f))).collect();
    flag(&mut checks, "F3", words(odd));
    flag(&mut checks, "F1", faults.flags);
    flag(&mut checks, "T1", faults.loose_flags);
    let undecided = |c: &&mut Check| ["T1", "T2"].contains(&c.id.as_str()) && c.holds();
    for check in checks.iter_mut().filter(undecided).filter(|_| !foreign.is_empty()) {
        *check = Check::unknown(&check.id, foreign.join("; "));
    }
    (checks, robot)
}

/// The same check with the number of its faults as value.
fn counted(check: Check) -> Check {
    let faults = check.evidence.len() as f64;
    check.value(faults)
}

/// A check that holds, with something a person should look at.
fn flag(checks: &mut [Check], id: &str, words: Vec<String>) {
    let mine = checks.iter_mut().find(|c| c.id == id && c.holds());
    if let (Some(check), false) = (mine, words.is_empty()) {
        let known = std::mem::take(&mut check.evidence);
        let all: Vec<String> = known.into_iter().chain(words).collect();
        *check = Check::warn(id).value(all.len() as f64).evidences(all);
    }
}

/// Meshes of packages are found here and may not be elsewhere.
fn flag_packages(checks: &mut [Check], found: &[String]) {
    let told = |name: &String| {
        format!("package `{name}` was found beside the file; programs must be told where it is")
    };
    flag(checks, "F2", found.iter().map(told).collect());
}

/// Pairs of links that may pass through each other, and the joints that ties between links hold.
fn beside_the_tree(robot: &mut Robot, apart: &[[String; 2]], ties: &[Tie]) {
    let index = |name: &str| robot.links.iter().position(|l| l.name == name);
    let pairs = apart.iter().filter_map(|[a, b]| {
        let (a, b) = (index(a)?, index(b)?);
        Some([a.min(b), a.max(b)])
    });
    let pairs: BTreeSet<[usize; 2]> = pairs.collect();
    let tied: Vec<_> = ties
        .iter()
        .filter_map(|tie| Some((index(&tie.bodies[0])?, index(&tie.bodies[1])?, &tie.why)))
        .collect();
    let above = |link: usize| {
        let mut all = BTreeSet::new();
        let mut at = link;
        while let Some(j) = robot.joint_above(at) {
            all.insert(j);
            at = robot.joints[j].parent;
        }
        all
    };
    let mut held: BTreeMap<usize, String> = BTreeMap::new();
    for (a, b, why) in tied {
        let (of_a, of_b) = (above(a), above(b));
        for &j in of_a.symmetric_difference(&of_b) {
            held.entry(j).or_insert_with(|| why.clone());
        }
    }
    robot.beside.apart = pairs;
    for (j, why) in held {
        if robot.joints[j].kind.moves() {
            robot.joints[j].held = Some(why);
        }
    }
}

/// F2 holds where meshes outside the folder are allowed, but says which they are.
fn flag_outside(checks: &mut [Check], found: Vec<String>) {
    let mine = checks.iter_mut().find(|c| c.id == "F2" && c.holds());
    if let (Some(check), false) = (mine, found.is_empty()) {
        let told = |name| format!("mesh `{name}` lies outside the package, which was allowed");
        let known = std::mem::take(&mut check.evidence);
        let all = known.into_iter().chain(found.into_iter().map(told)).collect::<Vec<_>>();
        *check = Check::warn("F2").value(all.len() as f64).evidences(all);
    }
}

fn dangling(joints: &[JointDraft], index: &BTreeMap<&str, usize>) -> Vec<String> {
    let mut faults = Vec::new();
    for j in joints {
        for (role, name) in [("parent", &j.parent), ("child", &j.child)] {
            if !name.is_empty() && !index.contains_key(name.as_str()) {
                let (joint, line) = (&j.joint.name, j.joint.line);
                faults.push(format!(
                    "line {line}: joint `{joint}` names the {role} link `{name}`, which does not exist"
                ));
            }
        }
    }
    faults
}

/// Links with two parents, more or fewer than one root, and cycles: all of them.
fn tree_faults(links: &[Link], joints: &[JointDraft]) -> Vec<String> {
    let mut faults = Vec::new();
    let names: BTreeSet<&str> = links.iter().map(|l| l.name.as_str()).collect();
    let mut parents: BTreeMap<&str, Vec<&JointDraft>> = BTreeMap::new();
    // A parent that does not exist is a fault of its own and makes no cycle.
    let real = joints.iter().filter(|j| names.contains(j.parent.as_str()));
    real.for_each(|j| parents.entry(&j.child).or_default().push(j));
    for (child, above) in parents.iter().filter(|(c, above)| !c.is_empty() && above.len() > 1) {
        let names: Vec<_> = above.iter().map(|j| format!("`{}`", j.joint.name)).collect();
        faults.push(format!("link `{child}` is the child of joints {}", names.join(" and ")));
    }
    let roots: Vec<&str> = names.iter().filter(|n| !parents.contains_key(*n)).copied().collect();
    if roots.len() != 1 {
        let list: Vec<_> = roots.iter().map(|n| format!("`{n}`")).collect();
        faults.push(format!("expected one root link, found {}: {}", roots.len(), list.join(", ")));
    }
    let reached = reachable(&roots, joints);
    let lost: Vec<_> =
        names.iter().filter(|n| !reached.contains(*n)).map(|n| format!("`{n}`")).collect();
    if !lost.is_empty() {
        faults.push(format!("links {} form a cycle and hang on no root", lost.join(", ")));
    }
    faults
}

fn reachable<'a>(roots: &[&'a str], joints: &'a [JointDraft]) -> BTreeSet<&'a str> {
    let mut reached: BTreeSet<&str> = roots.iter().copied().collect();
    let mut queue = roots.to_vec();
    while let Some(link) = queue.pop() {
        for joint in joints.iter().filter(|j| j.parent == link) {
            if reached.insert(&joint.child) {
                queue.push(&joint.child);
            }
        }
    }
    reached
}

fn mimic_faults(joints: &[JointDraft]) -> Vec<String> {
    let leads = |j: &JointDraft| j.mimic.as_ref().map(|m| m.joint.clone());
    let leaders: BTreeMap<&str, Option<String>> =
        joints.iter().rev().map(|j| (j.joint.name.as_str(), leads(j))).collect();
    let leader = |name: &str| leaders.get(name).map(Option::as_deref);
    let mut faults = Vec::new();
    for j in joints {
        let Some(mimic) = &j.mimic else { continue };
        let (name, line) = (&j.joint.name, j.joint.line);
        let mut walk = Some(mimic.joint.as_str());
        for _ in 0..=joints.len() {
            let Some(target) = walk else { break };
            let Some(next) = leader(target) else {
                faults.push(format!(
                    "line {line}: joint `{name}` mimics `{target}`, which does not exist"
                ));
                break;
            };
            if target == name {
                faults.push(format!("line {line}: joint `{name}` mimics itself"));
                break;
            }
            walk = next;
        }
    }
    faults
}

/// Joints with their names looked up; `None` if one leads nowhere.
fn resolve(joints: Vec<JointDraft>, index: &BTreeMap<&str, usize>) -> Option<Vec<Joint>> {
    let names: BTreeMap<String, usize> =
        joints.iter().enumerate().rev().map(|(i, j)| (j.joint.name.clone(), i)).collect();
    let one = |j: JointDraft| {
        let (parent, child) = (*index.get(j.parent.as_str())?, *index.get(j.child.as_str())?);
        let mimic = match j.mimic {
            Some(m) => {
                let joint = *names.get(&m.joint)?;
                Some(Mimic { joint, multiplier: m.multiplier, offset: m.offset })
            }
            None => None,
        };
        Some(Joint { parent, child, mimic, ..j.joint })
    };
    joints.into_iter().map(one).collect()
}

/// T3: a body that moves must have mass or geometry.
fn check_empty_links(robot: &Robot) -> Check {
    let body_of = robot.body_of_link();
    let is_something = |l: &Link| {
        let has_mass = l.inertial.is_some_and(|i| i.mass > 0.0);
        has_mass || l.between || !l.visuals.is_empty() || !l.collisions.is_empty()
    };
    let mut is_real = vec![false; robot.links.len()];
    for (l, link) in robot.links.iter().enumerate() {
        is_real[body_of[l]] |= is_something(link);
    }
    let empty = (0..robot.links.len())
        .filter(|&l| body_of[l] == l && !is_real[l] && robot.joint_above(l).is_some());
    let told = empty.map(|l| {
        let Link { name, line, .. } = &robot.links[l];
        format!("line {line}: link `{name}` moves but has neither mass nor geometry")
    });
    counted(Check::from_faults("T3", told.collect::<Vec<_>>()))
}

/// T4: parts are links with geometry; joints are those that move.
fn check_counts(robot: Option<&Robot>, expected: Expected) -> Check {
    let Some(robot) = robot else {
        return Check::unknown("T4", "links and joints could not be read as one tree");
    };
    let has_geometry = |l: &&Link| !l.visuals.is_empty() || !l.collisions.is_empty();
    let links = robot.links.iter().filter(has_geometry).count();
    let joints = robot.joints.iter().filter(|j| j.kind.moves()).count();
    let fault = |what: &str, expected: usize, found: usize| {
        (expected != found).then(|| format!("expected {expected} {what}, found {found}"))
    };
    let faults = [
        fault("links with geometry", expected.links, links),
        fault("moving joints", expected.joints, joints),
    ];
    counted(Check::from_faults("T4", faults.into_iter().flatten().collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str, id: &str) -> Vec<String> {
        let loaded = from_text(text, Path::new("."), &CheckOptions::default());
        loaded.checks.iter().filter(|c| c.id == id).flat_map(|c| c.evidence.clone()).collect()
    }

    fn hinge(name: &str, parent: &str, child: &str, more: &str) -> String {
        format!(
            r#"<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>{more}</joint>"#
        )
    }

    fn robot(body: &str) -> String {
        format!("<robot name=\"r\">\n{body}\n</robot>")
    }

    #[test]
    fn a_whole_file_becomes_a_robot() {
        let body = r#"<link name="a"/><link name="b"><visual><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
            <geometry><box size="1 1 1"/></geometry></visual></link>"#;
        let text = robot(&(body.to_owned() + &hinge("j", "a", "b", "<axis xyz='0 0 2'/>")));
        let loaded = from_text(&text, Path::new("."), &CheckOptions::default());
        assert!(loaded.checks.iter().all(Check::holds), "{:?}", loaded.checks);
        let robot = loaded.robot.unwrap();
        assert_eq!(robot.joints[0].axis, glamx::DVec3::Z);
        assert_eq!(robot.joints[0].axis_as_written, glamx::DVec3::Z * 2.0);
        let turned = robot.links[1].visuals[0].origin * glamx::DVec3::X;
        assert!((turned - glamx::DVec3::new(1.0, 3.0, 3.0)).length() < 1e-15);
        assert_eq!(robot.links[1].visuals[0].line, 2);
    }

    #[test]
    fn every_broken_number_is_listed_with_its_line() {
        let text = robot(
            r#"<link name="a"><visual><origin xyz="0,5 0 0"/><geometry><box size="1 1"/></geometry></visual>
<inertial><mass value="inf"/><inertia ixx="1" iyy="1"/></inertial></link>"#,
        );
        let found = faults(&text, "F1");
        assert!(
            found[0].contains("line 2: `origin`: xyz=\"0,5 0 0\" is not a number")
                || found.iter().any(|f| f.contains("a comma is no decimal point")),
            "{found:?}"
        );
        assert!(found.iter().any(|f| f.starts_with("line 3: `mass`")), "{found:?}");
        assert_eq!(found.iter().filter(|f| f.contains("`inertia`: has no")).count(), 4);
        assert!(found.iter().any(|f| f.contains("must be three numbers, found 2")));
    }

    #[test]
    fn every_break_of_the_tree_is_listed() {
        let links = r#"<link name="a"/><link name="b"/><link name="c"/><link name="d"/>"#;
        let joints = hinge("j1", "a", "b", "")
            + &hinge("j2", "a", "b", "")
            + &hinge("j3", "c", "d", "")
            + &hinge("j4", "d", "c", "")
            + &hinge("j5", "a", "nowhere", "");
        let found = faults(&robot(&(links.to_owned() + &joints)), "T1");
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].contains("names the child link `nowhere`"));
        assert_eq!(found[1], "link `b` is the child of joints `j1` and `j2`");
        assert_eq!(found[2], "links `c`, `d` form a cycle and hang on no root");
    }

    #[test]
    fn a_parent_that_does_not_exist_is_one_fault_and_no_cycle() {
        let text = robot(&(r#"<link name="a"/>"#.to_owned() + &hinge("j", "world", "a", "")));
        let found = faults(&text, "T1");
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("names the parent link `world`, which does not exist"));
    }

    #[test]
    fn mimics_follow_another_joint_that_exists() {
        let links = r#"<link name="a"/><link name="b"/><link name="c"/>"#;
        let with = |first: &str, second: &str| {
            let joints = hinge("j", "a", "b", first) + &hinge("k", "a", "c", second);
            faults(&robot(&(links.to_owned() + &joints)), "T2")
        };
        assert_eq!(with("<mimic joint='k'/>", ""), [""; 0]);
        assert!(with("<mimic joint='j'/>", "")[0].ends_with("joint `j` mimics itself"));
        assert_eq!(with("<mimic joint='k'/>", "<mimic joint='j'/>").len(), 2);
        assert!(with("<mimic joint='x'/>", "")[0].contains("mimics `x`, which does not exist"));
    }

    #[test]
    fn entity_bombs_and_doctypes_are_refused() {
        let bomb = "<!DOCTYPE r [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]><robot name=\"&b;\"/>";
        assert!(faults(bomb, "F1")[0].starts_with("not XML"));
    }

    #[test]
    fn names_are_safe_and_unique() {
        let text = robot(r#"<link name="a b"/><link name="a b"/>"#);
        assert_eq!(faults(&text, "F3").len(), 3);
    }

    #[test]
    fn counts_are_held_against_the_condition() {
        let text = robot(r#"<link name="a"/>"#);
        let expected = Some(Expected { links: 1, joints: 0 });
        let options = CheckOptions { expected, ..CheckOptions::default() };
        let loaded = from_text(&text, Path::new("."), &options);
        let t4 = loaded.checks.iter().find(|c| c.id == "T4").unwrap();
        assert_eq!(t4.evidence, ["expected 1 links with geometry, found 0"]);
    }
}
