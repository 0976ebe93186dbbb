//! `kinfold eval` on cases of our own.

use std::path::Path;

use model::net::device;
use model::net::partfield::{PartField, PartFieldSizes};
use model::net::particulate::{PUBLISHED_PARTS, Particulate, ParticulateSizes};
use model::net::source::{Random, Source, Start};
use object::condition::ConditionFile;
use serde_json::{Map, Value, json};
use training::evaluate::case;
use training::procedural::FAMILIES;

use crate::kinfold::{Said, program_in};

/// Two objects as case folders.
fn cases(root: &Path) {
    for (name, family) in [("articraft__cabinet", 0), ("home__cart", 2)] {
        let made = FAMILIES[family].make().unwrap();
        case::write(&root.join("cases").join(name), &made.object, &made.condition).unwrap();
    }
}

fn eval(root: &Path, more: &[&str]) -> Said {
    let mut command = program_in(root);
    command.args(["eval", "cases", "--points", "3000"]).args(more);
    command.output().unwrap().into()
}

#[test]
fn the_table_is_the_answer_and_the_files_hold_everything() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    let files = ["--json", "a.json", "--csv", "a.csv", "--sheet", "a.png", "--worst", "1"];
    let said = eval(dir.path(), &files);
    assert_eq!(said.code, Some(0), "{said:?}");
    for word in ["identity", "hungarian", "by joint", "cad", "simulation", "all"] {
        assert!(said.out.contains(word), "no {word} in\n{}", said.out);
    }
    assert_eq!(said.err.lines().count(), 2, "{}", said.err);
    let text = std::fs::read_to_string(dir.path().join("a.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&report["schema"], &report["how"]["rules"]),
        (&"kinfold-eval/1".into(), &"paper".into())
    );
    assert_eq!(report["cases"].as_array().unwrap().len(), 2);
    assert_eq!(std::fs::read_to_string(dir.path().join("a.csv")).unwrap().lines().count(), 3);
    assert!(std::fs::read(dir.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    let again = eval(dir.path(), &["--json", "b.json", "--jobs", "2", "--quiet"]);
    assert_eq!((again.out, again.err.as_str()), (said.out, ""));
    assert_eq!(text, std::fs::read_to_string(dir.path().join("b.json")).unwrap());
}

#[test]
fn a_case_without_an_answer_is_named_and_exits_3() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    std::fs::write(dir.path().join("cases/home__cart/truth.json"), "{}").unwrap();
    let said = eval(dir.path(), &["--quiet"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.starts_with("home__cart: "), "{}", said.err);
    assert!(said.err.contains("truth.json: not a truth file: missing field `schema`"));
}

#[test]
fn what_cannot_be_asked_says_what_can() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    let asked = [
        (&["--mode", "image", "--state", "s"][..], "nobody to ask for a condition"),
        (&["--mode", "mesh", "--state", "s"], "kinfold.toml"),
        (&["--mode", "mesh", "--labels", "truth"], "goes with --mode mesh+kinematic"),
        (&["--articulator", "net"], "--weights FILE.safetensors"),
        (&["--articulator", "net", "--weights", "w", "--labels", "truth"], "goes with"),
        (&["--weights", "w"], "--articulator net"),
        (&["--articulator", "particulate"], "goes with --mode mesh"),
        (&["--articulator", "particulate", "--mode", "mesh"], "--point-features FILE"),
        (&["--point-features", "f"], "--articulator particulate"),
        (&["--text-features", "clip"], "--articulator net, or leave --text-features out"),
        (&["--precision", "full"], "--articulator net, or leave --precision out"),
        (&["--filter", "piano"], "none of 2 cases"),
        (&["--jobs", "0"], "1..=256"),
        (&["--json", "nowhere/a.json"], "nowhere: no such folder"),
    ];
    for (args, hint) in asked {
        let said = eval(dir.path(), args);
        assert_eq!((said.code, said.out.as_str()), (Some(2), ""), "{args:?}");
        assert!(said.err.contains(hint), "{}", said.err);
    }
    let said = eval(dir.path(), &["--articulator", "net", "--weights", "nowhere"]);
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("nowhere: "), "{}", said.err);
}

/// The cabinet as a case, with a picture; whom to ask, and where the mesh comes from.
#[cfg(unix)]
fn cabinet_with_picture(root: &Path, port: u16, mesh: &str) {
    use crate::cabinet;
    use object::{ArticulatedObject, DVec3, JointKind, JointMotion, Range};
    let condition = serde_json::from_value::<ConditionFile>(cabinet::condition()).unwrap();
    let door = JointMotion {
        kind: JointKind::Revolute,
        axis: DVec3::NEG_Z,
        pivot: DVec3::new(-0.2, -0.012, 0.3),
        range: Range::Limits { lower: 0.0, upper: 1.5 },
    };
    let (surface, tree) = (cabinet::mesh(), condition.resolve().unwrap().tree);
    let labels = (0..surface.faces().len()).map(|face| u16::from(face >= 12)).collect();
    let object = ArticulatedObject::new(surface, tree, labels, vec![vec![], vec![door]]).unwrap();
    let folder = root.join("cases/home__cabinet");
    case::write(&folder, &object, &condition).unwrap();
    std::fs::write(folder.join("render.png"), cabinet::png(48, 40)).unwrap();
    let config = format!(
        "{mesh}[vlm]\nprovider = \"openai\"\nbase = \"http://127.0.0.1:{port}/v1\"\n\
         model = \"some-vlm\"\n"
    );
    std::fs::write(root.join("kinfold.toml"), config).unwrap();
}

#[cfg(unix)]
#[test]
fn what_a_case_does_not_give_is_asked_for_once() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("made.glb"), object::glb::write(&crate::cabinet::mesh()))
        .unwrap();
    let points = crate::providers::points(&dir.path().join("made.glb"));
    let copied = format!(
        "[image_to_3d]\nprovider = \"command\"\nprogram = \"cp\"\narguments = [{:?}, \"{{mesh}}\"]\n",
        dir.path().join("made.glb").display().to_string(),
    );
    for (mode, mesh) in [("mesh", ""), ("image", copied.as_str())] {
        let (port, server) = crate::providers::chat(points.clone());
        cabinet_with_picture(dir.path(), port, mesh);
        let file = format!("{mode}.json");
        let args = ["--mode", mode, "--state", mode, "--quiet", "--json", &file];
        let said = eval(dir.path(), &args);
        assert_eq!(said.code, Some(0), "{mode}: {said:?}");
        assert_eq!(server.join().unwrap(), 3, "{mode}: each question is asked once");
        assert!(!said.out.contains("identity") && said.out.contains("hungarian"), "{}", said.out);
        let text = std::fs::read_to_string(dir.path().join(&file)).unwrap();
        let report: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(report["mode"], mode);
        let asked = report["articulator"].as_str().unwrap();
        assert!(asked.contains("condition by") && asked.contains("some-vlm"), "{asked}");
        assert_eq!(asked.contains("mesh by"), mode == "image", "{asked}");
        let row = &report["cases"][0]["hungarian"];
        assert_eq!(
            (row["recall"].as_f64(), row["joints"]["near"].as_f64()),
            (Some(1.0), Some(1.0))
        );
        assert_eq!(row["point_iou"].is_null(), mode == "image", "{row}");
        let again = eval(dir.path(), &args);
        assert_eq!((again.code, again.out), (Some(0), said.out), "{mode}: nobody is asked again");
    }
}

#[cfg(unix)]
#[test]
fn a_case_without_a_picture_says_what_it_wants() {
    let dir = tempfile::tempdir().unwrap();
    cabinet_with_picture(dir.path(), 9, "");
    std::fs::remove_file(dir.path().join("cases/home__cabinet/render.png")).unwrap();
    let said = eval(dir.path(), &["--mode", "mesh", "--state", "state", "--quiet"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.contains("expected a picture, image.png or"), "{}", said.err);
}

/// Parameters of a network that was never trained, with their names.
#[derive(Default)]
struct Untrained(Vec<(String, Vec<usize>, Vec<f32>)>);

impl Source for Untrained {
    fn values(&mut self, name: &str, shape: &[usize], start: Start) -> Vec<f32> {
        let values = Random { seed: 4 }.values(name, shape, start);
        self.0.push((name.into(), shape.to_vec(), values.clone()));
        values
    }
}

impl Untrained {
    fn write(&self, path: &Path) {
        let (mut header, mut data) = (Map::new(), Vec::new());
        for (name, shape, values) in &self.0 {
            let from = data.len();
            data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
            let tensor =
                json!({ "dtype": "F32", "shape": shape, "data_offsets": [from, data.len()] });
            header.insert(name.clone(), tensor);
        }
        let header = Value::from(header).to_string();
        let length = (header.len() as u64).to_le_bytes();
        std::fs::write(path, [&length, header.as_bytes(), &data].concat()).unwrap();
    }
}

#[test]
fn the_predecessor_finds_what_the_parts_are_by_itself() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    let (mut network, mut features) = (Untrained::default(), Untrained::default());
    let sizes =
        ParticulateSizes { width: 16, heads: 1, layers: 1, features: 4, parts: PUBLISHED_PARTS };
    Particulate::build(sizes, &mut network, &device("cpu").unwrap());
    let [heads, distance] = PartFieldSizes::PUBLISHED;
    let [channels, resolution, hidden, width, layers, out] = [8, 16, 32, 16, 1, distance + 4];
    let sizes =
        PartFieldSizes { channels, resolution, hidden, width, layers, heads, out, distance };
    PartField::build(sizes, &mut features, &device("cpu").unwrap());
    network.write(&dir.path().join("particulate"));
    features.write(&dir.path().join("partfield"));
    let asked = ["--articulator", "particulate", "--mode", "mesh", "--weights", "particulate"];
    let asked = [&asked[..], &["--point-features", "partfield", "--filter", "cart"]].concat();
    let said = eval(dir.path(), &[&asked[..], &["--json", "a.json"]].concat());
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(!said.out.contains("identity") && said.out.contains("hungarian"), "{said:?}");
    let text = std::fs::read_to_string(dir.path().join("a.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["mode"], "mesh");
    assert!(report["articulator"].as_str().unwrap().starts_with("particulate/1 "));
    let features =
        |file: &str| eval(dir.path(), &[&asked[..6], &["--point-features", file]].concat());
    let said = features("particulate");
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("particulate, particulate: the weights of PartField: "), "{said:?}");
    // Eight channels at first are 48 further on, which do not fall into 32 groups.
    let mut odd = Untrained::default();
    PartField::build(PartFieldSizes { hidden: 8, ..sizes }, &mut odd, &device("cpu").unwrap());
    odd.write(&dir.path().join("odd"));
    let said = features("odd");
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("particulate, odd: the weights of PartField: "), "{said:?}");
    assert!(said.err.contains("hidden: 8"), "{said:?}");
}
