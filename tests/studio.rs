//! The studio as a person uses it: in a browser, with mouse and keyboard, against the real server.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::browser::{ALT, Browser, CTRL, SHIFT};
use crate::desk::{Page, SIZE, Side, Studio};
use crate::examples;
use crate::kinfold::{Said, program};

/// Files of an asset that do not say when they were made.
fn timeless(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name != "trace.mcap" && name != ".kinfold" {
                all.push((
                    path.strip_prefix(folder).unwrap().to_owned(),
                    std::fs::read(&path).unwrap(),
                ));
            }
        }
    }
    all.sort();
    all
}

#[test]
fn an_object_is_prompted_corrected_built_and_made_again_from_the_file() {
    let studio = Studio::open("cabinet", &[]);
    let Some(mut page) = Page::open(&studio) else { return };
    // The first step of an empty page has the focus: the base.
    page.browser.write("body");
    page.browser.enter();
    page.browser.key("Escape");
    let mesh = studio.mesh();
    page.browser.key(Side::Right.key());
    let at = page.place(&mesh, Side::Right, [0.25, 0.0, 0.1]);
    page.browser.click_with(at, 0);
    page.rest();
    assert!(studio.part("body")["point"].is_array(), "{}", studio.condition());

    page.browser.key(Side::Front.key());
    for (name, point) in [("drawer", [0.1, -0.2, 0.5]), ("door", [-0.1, -0.2, 0.2])] {
        page.add(name);
        let at = page.place(&mesh, Side::Front, point);
        page.browser.click_with(at, 0);
        page.rest();
        let part = studio.part(name);
        let found: Vec<f64> =
            part["point"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
        // The file has y up.
        let off = (found[0] - point[0]).hypot(found[1] - point[2]);
        assert!(off < 0.004, "{name}: {found:?} for {point:?}");
    }
    assert_eq!(
        (&studio.part("drawer")["joint"], &studio.part("door")["joint"]),
        (&json!("prismatic"), &json!("revolute"))
    );
    page.fill("#object-size", "0.6");
    page.rest();
    assert_eq!(studio.condition()["size"], json!({ "height": 0.6 }));

    // The axis of the door is pulled out of the upright, and back, where it snaps.
    page.browser.key("Escape");
    page.click("#part-2");
    page.browser.run("document.getElementById('canvas').focus()");
    page.browser.key(Side::Front.key());
    let tip = page.middle("#handle-tip");
    let up = page.middle("#handle-foot");
    let wrong = [tip[0] + 110.0, tip[1] + if tip[1] < up[1] { 60.0 } else { -60.0 }];
    page.browser.drag_with(tip, wrong, ALT);
    page.rest();
    let axis = |studio: &Studio| -> Vec<f64> {
        studio.part("door")["axis"].as_array().unwrap().iter().filter_map(Value::as_f64).collect()
    };
    assert!(axis(&studio)[1].abs() < 0.95, "pulled away: {:?}", axis(&studio));
    let (tip, foot) = (page.middle("#handle-tip"), page.middle("#handle-foot"));
    let far = ((tip[0] - foot[0]).hypot(tip[1] - foot[1])) / 2.0;
    let centre = [(tip[0] + foot[0]) / 2.0, (tip[1] + foot[1]) / 2.0];
    let upright = [centre[0], centre[1] + far * if tip[1] < foot[1] { -1.0 } else { 1.0 }];
    page.browser.drag_with(tip, upright, 0);
    page.rest();
    let righted = axis(&studio);
    let length = righted.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(righted[1].abs() / length > 0.999_999, "snapped: {righted:?}");
    // It turned about its middle, which stayed at the hinge: at the left end of the door.
    let pivot = studio.part("door")["pivot"][0].as_f64().unwrap();
    assert!((pivot + 0.23).abs() < 0.02, "{pivot}");

    // The hinge is moved to the edge of the door, where it snaps.
    page.browser.key(Side::Corner.key());
    let shaft = page.middle("#handle-shaft");
    let edge = page.place(&mesh, Side::Corner, [-0.23, -0.2, 0.2]);
    page.browser.drag_with(shaft, edge, 0);
    page.rest();
    let door = studio.part("door");
    let [x, y] = [0, 2].map(|i| door["pivot"][i].as_f64().unwrap());
    assert!((x + 0.23).abs() < 0.002 && (y - 0.2).abs() < 0.002, "on the edge: {door}");

    // The end of its range, by a field.
    page.fill("#joint-0-high", "95");
    page.rest();
    let range = studio.part("door")["range"].clone();
    let end = range[1].as_f64().unwrap();
    assert!((end - 95f64.to_radians()).abs() < 1e-4, "{range}");

    build(&studio, &mut page);
    is_made_again(&studio);
}

/// Builds what is edited, and looks at what the page says of it.
fn build(studio: &Studio, page: &mut Page) {
    page.browser.run("document.getElementById('canvas').focus()");
    page.browser.key_with("Enter", CTRL);
    page.browser.wait_for("nothing is built", |state| state != "building");
    let shown = "document.getElementById('app').dataset.tab + ' ' + document.getElementById('built').dataset.state";
    for _ in 0..200 {
        if page.browser.run(shown) == "built ready" {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    assert_eq!(page.browser.run(shown), "built ready", "{}", page.text("#notices"));
    let verdict = std::fs::read(studio.path("photo.kinfold/verdict.json")).unwrap();
    let verdict: Value = serde_json::from_slice(&verdict).unwrap();
    let tier = verdict["tier"].as_str().unwrap();
    let head = page.text("#built-head");
    assert!(head.contains(&format!("tier {tier}")), "{head}");
    assert!(page.text("#verdict").contains("passed"), "{}", page.text("#verdict"));
    page.click("#verdict #tab-joints");
    let wide = "document.querySelector('#verdict .joint input[type=range]').clientWidth";
    assert!(page.browser.run(wide).as_f64().unwrap() > 80.0, "a slider has room to be pulled");
    page.browser.picture();
    assert_eq!(page.browser.complaints(), Vec::<String>::new());
}

/// The file that was saved makes the same asset.
fn is_made_again(studio: &Studio) {
    let mut again = program();
    again.current_dir(studio.folder.path()).args(["make", "photo.png", "--mesh", "mesh.glb"]);
    again.args(["--condition", "mine.json", "--out", "again", "--state", "other"]);
    let said: Said = again.args(["--export", "mjcf,usd,glb", "-q"]).output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?} {}", studio.part("door"));
    let [built, made] = ["photo.kinfold", "again"].map(|name| timeless(&studio.path(name)));
    let names =
        |files: &[(PathBuf, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&built), names(&made));
    for ((name, ours), (_, theirs)) in built.iter().zip(&made) {
        assert!(ours == theirs, "{} differs", name.display());
    }
}

#[test]
fn what_was_done_is_undone_and_a_closed_page_loses_nothing() {
    let studio = Studio::open("cabinet", &[]);
    let Some(mut page) = Page::open(&studio) else { return };
    page.browser.write("body");
    page.browser.enter();
    page.browser.key("Escape");
    let mesh = studio.mesh();
    page.browser.key(Side::Front.key());
    page.add("door");
    let at = page.place(&mesh, Side::Front, [-0.1, -0.2, 0.2]);
    page.browser.click_with(at, 0);
    let at = page.place(&mesh, Side::Front, [0.1, -0.2, 0.5]);
    page.browser.click_with(at, SHIFT);
    page.rest();
    let door = studio.part("door");
    assert!(door["point"].is_array() && door["not"].as_array().unwrap().len() == 1, "{door}");
    page.browser.key_with("z", CTRL);
    page.rest();
    assert!(studio.part("door").get("not").is_none());
    page.browser.key_with("z", CTRL | SHIFT);
    page.rest();
    assert!(studio.part("door").get("not").is_some());
    let before = studio.condition();
    drop(page);
    let Some(mut page) = Page::open(&studio) else { return };
    page.rest();
    assert_eq!(page.browser.run("document.querySelectorAll('#side .parts li').length"), json!(2));
    assert_eq!(studio.condition(), before);
    assert_eq!(page.browser.complaints(), Vec::<String>::new());
}

#[test]
fn a_file_changed_on_disk_meanwhile_is_asked_about_and_a_second_tab_is_told() {
    let studio = Studio::open("cabinet", &[]);
    let Some(mut page) = Page::open(&studio) else { return };
    page.browser.write("body");
    page.browser.enter();
    page.rest();
    // Changed elsewhere while nothing is unsaved here: taken over.
    let theirs = json!({ "schema": "kinfold-condition/2", "category": "theirs", "parts": [{ "name": "body" }] });
    std::fs::write(studio.path("mine.json"), format!("{theirs:#}\n")).unwrap();
    for _ in 0..100 {
        if page.browser.run("document.getElementById('object-category').value") == "theirs" {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(
        page.browser.run("document.getElementById('object-category').value"),
        json!("theirs")
    );
    let Some(other) = Page::open(&studio) else { return };
    for _ in 0..100 {
        if page.text("#notices").contains("2 tabs") {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert!(page.text("#notices").contains("2 tabs"), "{}", page.text("#notices"));
    drop(other);
}

#[test]
fn painted_faces_are_of_one_part_and_shut_is_where_a_person_says() {
    let studio = Studio::open("cabinet", &[]);
    std::fs::copy(examples::folder("cabinet").join("condition.json"), studio.path("mine.json"))
        .unwrap();
    let Some(mut page) = Page::open(&studio) else { return };
    page.rest();
    let mesh = studio.mesh();
    page.browser.run("document.getElementById('canvas').focus()");
    page.browser.key(Side::Front.key());
    // The drawer's front is painted as the drawer's, then as the door's: it is of the door alone.
    for (row, name) in [("#part-1", "drawer"), ("#part-2", "door")] {
        page.click(row);
        page.browser.run("document.getElementById('canvas').focus()");
        page.browser.key("v");
        page.browser.key("b");
        let (from, to) = (
            page.place(&mesh, Side::Front, [-0.1, -0.2, 0.5]),
            page.place(&mesh, Side::Front, [0.1, -0.2, 0.5]),
        );
        page.browser.drag_with(from, to, 0);
        page.rest();
        assert!(studio.part(name)["faces"].is_string(), "{}", studio.condition());
    }
    assert!(studio.part("drawer").get("faces").is_none() && studio.condition()["mesh"].is_string());
    // Alt takes paint off again.
    let painted = studio.part("door")["faces"].as_str().unwrap().len();
    let (from, to) = (
        page.place(&mesh, Side::Front, [-0.1, -0.2, 0.5]),
        page.place(&mesh, Side::Front, [0.1, -0.2, 0.5]),
    );
    page.browser.drag_with(from, to, ALT);
    page.rest();
    assert!(studio.part("door")["faces"].as_str().is_none_or(|left| left.len() < painted));

    // Shown open by 40°: shut is tried past the ends.
    page.browser.key("Escape");
    page.click("#joint-0-past");
    page.fill("#joint-0-value", "-40");
    page.click("#joint-0-shut");
    page.rest();
    let door = studio.part("door");
    let open = door["rest"].as_f64().unwrap();
    assert!((open - 40f64.to_radians()).abs() < 1e-3 && door["range"][0] == json!(0), "{door}");
    // What was given is taken back one by one.
    page.click("[aria-label='Take back the given shown at']");
    page.rest();
    assert!(
        studio.part("door").get("rest").is_none() && studio.part("door").get("range").is_some()
    );
    page.click("#joint-0-as-found");
    page.rest();
    assert!(studio.part("door").get("range").is_none());
    assert_eq!(page.browser.complaints(), Vec::<String>::new());
}

/// The cabinet as an OBJ with z up, and its condition in the same frame.
fn upright(folder: &Path) -> Value {
    let case = examples::folder("cabinet");
    std::fs::copy(case.join("photo.png"), folder.join("photo.png")).unwrap();
    let mesh = object::glb::read(&std::fs::read(case.join("mesh.glb")).unwrap()).unwrap();
    let vertices = mesh.vertices().iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z));
    let faces = mesh.faces().iter().map(|f| f.map(|v| v + 1));
    let faces = faces.map(|[a, b, c]| format!("f {a} {b} {c}\n"));
    std::fs::write(folder.join("mesh.obj"), vertices.chain(faces).collect::<String>()).unwrap();
    let text = std::fs::read_to_string(case.join("condition.json")).unwrap();
    let mut condition: Value = serde_json::from_str(&text).unwrap();
    condition["up"] = json!("z");
    for part in condition["parts"].as_array_mut().unwrap() {
        let [x, y, z] = [0, 1, 2].map(|i| part["point"][i].as_f64().unwrap());
        part["point"] = json!([x, -z, y]);
    }
    condition
}

#[test]
fn an_asset_of_an_obj_with_z_up_is_opened_from_its_folder_and_each_asset_has_its_own_condition() {
    let mut folder = tempfile::tempdir().unwrap();
    let whole = upright(folder.path());
    let mut without_door = whole.clone();
    without_door["parts"].as_array_mut().unwrap().retain(|p| p["name"] != "door");
    for (out, condition) in [("cab.v1", &whole), ("cab.v2", &without_door)] {
        std::fs::write(folder.path().join("c.json"), condition.to_string()).unwrap();
        let mut make = program();
        make.current_dir(folder.path()).args(["make", "photo.png", "--mesh", "mesh.obj", "-q"]);
        make.args(["--condition", "c.json", "--state", "state", "--out", out]);
        let said: Said = make.output().unwrap().into();
        assert!(matches!(said.code, Some(0 | 3)), "{said:?}");
    }
    for (out, parts) in [("cab.v1", 3), ("cab.v2", 2), ("cab.v1", 3)] {
        let studio = Studio::start(folder, &[out, "--state", "state"]);
        let state = studio.state();
        assert_eq!(state["faults"], json!([]), "{out}");
        assert_eq!(state["document"]["parts"].as_array().map(Vec::len), Some(parts), "{out}");
        assert!(state["path"].as_str().unwrap().contains(&format!("{out}.studio")), "{state}");
        assert!(state["built"]["tier"].is_string(), "what stands there is shown: {state}");
        folder = studio.end();
    }
    // Made anew from another condition: what is edited then is that one, and the first one stays.
    std::fs::remove_dir_all(folder.path().join("cab.v1")).unwrap();
    std::fs::rename(folder.path().join("cab.v2"), folder.path().join("cab.v1")).unwrap();
    let studio = Studio::start(folder, &["cab.v1", "--state", "state"]);
    let state = studio.state();
    assert_eq!(state["document"]["parts"].as_array().map(Vec::len), Some(2));
    assert!(state["path"].as_str().unwrap().ends_with("condition-2.json"), "{}", state["path"]);
}

#[test]
fn a_file_that_is_broken_on_disk_is_not_replaced_by_an_empty_one() {
    let studio = Studio::open("cabinet", &[]);
    let case = examples::folder("cabinet").join("condition.json");
    std::fs::copy(&case, studio.path("mine.json")).unwrap();
    let Some(mut page) = Page::open(&studio) else { return };
    let text = std::fs::read_to_string(&case).unwrap();
    let broken = text.trim_end().trim_end_matches('}').to_owned();
    std::fs::write(studio.path("mine.json"), &broken).unwrap();
    for _ in 0..100 {
        if page.text("#notices").contains("no condition that this page can edit") {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert!(page.text("#notices").contains("left as it is"), "{}", page.text("#notices"));
    page.browser.key("a");
    page.browser.write("shelf");
    page.browser.enter();
    page.browser.settle();
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(std::fs::read_to_string(studio.path("mine.json")).unwrap(), broken);
    // Mended by whoever broke it while a part was added here: it is asked which is meant.
    std::fs::copy(&case, studio.path("mine.json")).unwrap();
    for _ in 0..100 {
        if page.browser.run("document.getElementById('ask').open") == true {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    page.click("#ask button.main");
    for _ in 0..100 {
        if page.browser.run("document.querySelectorAll('#side .parts li').length") == 3 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let count = page.browser.run("document.querySelectorAll('#side .parts li').length");
    assert_eq!(count, json!(3), "{}", page.text("#notices"));
}

#[test]
fn without_a_photo_everything_works_and_an_asset_may_be_built() {
    let studio = Studio::begin("cabinet", &["--mesh", "mesh.glb"], &[]);
    let Some(mut page) = Page::open(&studio) else { return };
    page.browser.write("body");
    page.browser.enter();
    page.rest();
    assert_eq!(studio.condition()["parts"][0]["name"], json!("body"));
    let disabled = page.browser.run("document.getElementById('build').disabled");
    assert_eq!(disabled, json!(false));
    assert_eq!(page.browser.complaints(), Vec::<String>::new());
}

#[test]
fn a_wrong_token_a_taken_port_and_a_missing_mesh_are_told_clearly() {
    let studio = Studio::open("cabinet", &[]);
    let port = studio.origin().rsplit(':').next().unwrap().to_owned();
    let mut command = program();
    command.current_dir(studio.folder.path()).args(["studio", "photo.png", "--mesh", "mesh.glb"]);
    let said: Said = command.args(["--state", "state", "--port", &port]).output().unwrap().into();
    assert_eq!(said.code, Some(1));
    assert!(
        said.err.contains(&format!("port {port}"))
            && said.err.contains("hint: name another with --port"),
        "{said:?}"
    );
    let mut command = program();
    command.current_dir(studio.folder.path()).args(["studio", "photo.png", "--state", "state"]);
    let said: Said = command.args(["--port", "0"]).output().unwrap().into();
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("nobody to ask for a mesh"), "{said:?}");
    let said: Said = program().arg("studio").output().unwrap().into();
    assert_eq!(said.code, Some(2), "{said:?}");

    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let wrong = format!("{}/?token=0123", studio.origin());
    browser.go(&wrong);
    let told = browser.run("document.body.innerText");
    assert!(told.as_str().unwrap().contains("token is missing or wrong"), "{told}");
}
