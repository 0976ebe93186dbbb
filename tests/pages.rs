//! The page of an asset, and of anybody's model, as a person uses it: in a browser, from the file alone.

use std::path::{Path, PathBuf};

use image::{Rgb, RgbImage};
use serde_json::Value;

use crate::browser::{Browser, differing};
use crate::examples;
use crate::kinfold::{Bench, Said, program};

/// Pixels of the page; the picture is all but the panel at its right.
const SIZE: [u32; 2] = [1280, 800];
/// The picture without the words at its top and the tools at its foot.
const PICTURE: [[u32; 2]; 2] = [[0, 90], [SIZE[0] - 354, SIZE[1] - 70]];

/// A model in a folder of its own.
fn model(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn view(path: &Path, more: &[&str]) -> Said {
    let mut command = program();
    command.current_dir(path.parent().unwrap()).arg("view").arg(path).args(["--out", "page.html"]);
    command.args(more).output().unwrap().into()
}

/// The page of a model.
fn page(path: &Path) -> PathBuf {
    let said = view(path, &[]);
    assert!(matches!(said.code, Some(0 | 3)), "{said:?}");
    assert_eq!(said.out, "page.html\n");
    path.with_file_name("page.html")
}

/// A link that is a box, seen and touched.
fn block(name: &str, size: [f64; 3], at: [f64; 3]) -> String {
    let [x, y, z] = size;
    let place = format!(r#"<origin xyz="{} {} {}"/>"#, at[0], at[1], at[2]);
    let shape = format!(r#"{place}<geometry><box size="{x} {y} {z}"/></geometry>"#);
    let moment = |a: f64, b: f64| (a * a + b * b) / 12.0;
    let (xx, yy, zz) = (moment(y, z), moment(x, z), moment(x, y));
    format!(
        r#"<link name="{name}"><visual>{shape}</visual><collision>{shape}</collision><inertial>{place}
        <mass value="1"/><inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial></link>"#
    )
}

fn joint(name: &str, kind: &str, links: [&str; 2], more: &str) -> String {
    let [parent, child] = links;
    format!(
        r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>"#
    )
}

/// A block of 0.2 m that slides half a metre to the right, over a plate.
fn slide() -> String {
    let limit = r#"<axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/>"#;
    let parts = [
        block("plate", [1.0, 0.3, 0.05], [0.0, 0.0, 0.025]),
        block("block", [0.2, 0.2, 0.2], [-0.3, 0.0, 0.2]),
        joint("slide", "prismatic", ["plate", "block"], limit),
    ];
    format!("<robot name=\"slide\">{}</robot>", parts.concat())
}

/// The same with a wall in its way, which it meets after 0.25 m.
fn blocked() -> String {
    let wall = block("wall", [0.1, 0.2, 0.2], [0.1, 0.0, 0.2]);
    let fixed = joint("held", "fixed", ["plate", "wall"], "");
    slide().replace("</robot>", &format!("{wall}{fixed}</robot>"))
}

/// Moves a slider as a person does.
fn pull(browser: &mut Browser, joint: usize, to: &str) -> f64 {
    let script = format!(
        "(() => {{ const s = document.getElementById('joint-{joint}'); s.value = s.{to};
        s.dispatchEvent(new Event('input', {{ bubbles: true }})); return Number(s.value); }})()"
    );
    let value = browser.run(&script).as_f64().unwrap();
    browser.settle();
    value
}

fn press(browser: &mut Browser, selector: &str) {
    browser.run(&format!("document.querySelector({selector:?}).click()"));
    browser.settle();
}

fn text(browser: &mut Browser, selector: &str) -> String {
    let said = browser.run(&format!("document.querySelector({selector:?}).innerText"));
    said.as_str().unwrap_or_default().to_owned()
}

/// Pixels of one kind: their middle, and the box round them.
#[derive(Debug)]
struct Spot {
    middle: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
}

fn spot(picture: &RgbImage, is: impl Fn(Rgb<u8>) -> bool) -> Option<Spot> {
    let [from, to] = PICTURE;
    let inside = |x: u32, y: u32| (from[0]..to[0]).contains(&x) && (from[1]..to[1]).contains(&y);
    let all = picture.enumerate_pixels().filter(|(x, y, p)| inside(*x, *y) && is(**p));
    let all: Vec<_> = all.map(|(x, y, _)| [f64::from(x), f64::from(y)]).collect();
    let (mut low, mut high, mut sum) = ([f64::MAX; 2], [f64::MIN; 2], [0.0; 2]);
    for p in &all {
        for i in 0..2 {
            (low[i], high[i], sum[i]) = (low[i].min(p[i]), high[i].max(p[i] + 1.0), sum[i] + p[i]);
        }
    }
    let middle = sum.map(|s| s / all.len() as f64);
    (all.len() > 20).then_some(Spot { middle, low, high })
}

/// The blue of the second part.
fn is_blue(p: Rgb<u8>) -> bool {
    let [r, g, b] = p.0.map(i32::from);
    b > r + 70 && b > g + 30
}

/// The red of a mark.
fn is_red(p: Rgb<u8>) -> bool {
    let [r, g, b] = p.0.map(i32::from);
    r > 150 && r > g + 110 && r > b + 90
}

#[test]
fn a_joint_at_its_limit_moves_the_right_pixels() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let (_folder, path) = model("slide.urdf", &slide());
    assert_eq!(browser.open(&page(&path)), "ready");
    browser.key("a");
    browser.key("1");
    let rest = browser.picture();
    assert!((pull(&mut browser, 0, "max") - 0.5).abs() < 1e-9);
    let moved = browser.picture();
    let (before, after) = (spot(&rest, is_blue).unwrap(), spot(&moved, is_blue).unwrap());
    // Its front is a square of 0.2 m: at the left its left edge is seen, at the right its right one.
    let metre = (before.high[1] - before.low[1]) / 0.2;
    let went = (after.high[0] - before.low[0]) / metre - 0.2;
    assert!((went - 0.5).abs() < 0.02, "{went} m to the right: {before:?}, then {after:?}");
    let lift = after.middle[1] - before.middle[1];
    assert!(lift.abs() < 3.0, "not up or down: {before:?}, then {after:?}");
    pull(&mut browser, 0, "min");
    assert_eq!(differing(&rest, &browser.picture(), PICTURE), 0, "back at rest");
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn the_keyboard_and_the_pointer_do_what_they_say() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let (_folder, path) = model("slide.urdf", &slide());
    browser.open(&page(&path));
    let whole = browser.picture();
    for key in ["e", "c", "a", "k", "m", "l", "x"] {
        browser.key(key);
        let changed = differing(&whole, &browser.picture(), PICTURE);
        assert!(changed > 200, "{key}: {changed} pixels");
        browser.key(key);
        assert_eq!(differing(&whole, &browser.picture(), PICTURE), 0, "{key} twice");
    }
    browser.key("?");
    assert_eq!(browser.run("document.getElementById('help').open"), true);
    press(&mut browser, "#help button");
    // A press on the block chooses it, a drag turns.
    browser.key("1");
    let at = spot(&browser.picture(), is_blue).unwrap().middle;
    browser.mouse("mousePressed", at);
    browser.mouse("mouseReleased", at);
    browser.settle();
    let chosen = "document.querySelector('.parts .selected .name')?.textContent ?? 'nothing'";
    assert_eq!(browser.run(chosen), "block");
    browser.key("Escape");
    assert_eq!(browser.run(chosen), "nothing");
    let front = browser.picture();
    browser.mouse("mousePressed", [300.0, 200.0]);
    browser.mouse("mouseMoved", [420.0, 240.0]);
    browser.mouse("mouseReleased", [420.0, 240.0]);
    assert!(differing(&front, &browser.picture(), PICTURE) > 2000, "a drag turns");
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_finding_goes_to_its_pose_and_marks_its_place() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let (_folder, path) = model("blocked.urdf", &blocked());
    browser.open(&page(&path));
    browser.key("a");
    assert!(spot(&browser.picture(), is_red).is_none());
    press(&mut browser, "#tab-findings");
    let evidence = "[...document.querySelectorAll('.go')].find(b => b.innerText.includes('overlap by') && b.innerText.includes('slide'))";
    let said = browser.run(&format!("{evidence}.innerText")).as_str().unwrap().to_owned();
    let (_, rest) = said.split_once("joint `slide` at ").unwrap();
    let expected: f64 = rest.split_once(" mm").unwrap().0.parse().unwrap();
    browser.run(&format!("{evidence}.click()"));
    browser.settle();
    let value = browser.run("Number(document.querySelector('.value').value)").as_f64().unwrap();
    assert!((value - expected).abs() < 0.1 && value > 200.0, "{value} mm for {said}");
    let at = spot(&browser.picture(), is_red).unwrap().middle;
    let label =
        "(r => r.x + r.width / 2)(document.querySelector('.tag.spot').getBoundingClientRect())";
    let label_x = browser.run(label).as_f64().unwrap();
    assert!((label_x - at[0]).abs() < 12.0, "the mark is at {at:?}, its label at {label_x}");
    browser.key("Escape");
    assert!(spot(&browser.picture(), is_red).is_none(), "let go of");
    assert_eq!(browser.complaints(), [""; 0]);
}

/// Whatever moves, moves pixels; nothing is said, nothing asked for.
fn works(browser: &mut Browser, page: &Path, moving: usize) {
    let bytes = std::fs::metadata(page).unwrap().len();
    assert!(bytes < 3_000_000, "{}: {bytes} bytes", page.display());
    assert_eq!(browser.open(page), "ready", "{}", page.display());
    let rest = browser.picture();
    let sliders = "[...document.querySelectorAll('.joint input[type=range]')].filter(s => !s.disabled).map(s => Number(s.id.split('-')[1]))";
    let sliders = browser.run(sliders);
    let sliders: Vec<usize> =
        sliders.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as usize).collect();
    assert_eq!(sliders.len(), moving, "{}", page.display());
    for joint in sliders {
        let to = if pull(browser, joint, "max") != 0.0 { "max" } else { "min" };
        pull(browser, joint, to);
        let moved = differing(&rest, &browser.picture(), PICTURE);
        assert!(moved > 100, "{}, joint {joint} at its {to}: {moved} pixels", page.display());
        browser.key("r");
    }
    browser.key("e");
    let apart = differing(&rest, &browser.picture(), PICTURE);
    assert!(apart > 1000 || moving == 0, "{}: {apart} pixels apart", page.display());
    assert_eq!(browser.complaints(), [""; 0], "{}", page.display());
}

#[test]
fn the_page_of_every_example_works() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let out = tempfile::tempdir().unwrap();
    for (urdf, moving) in examples::made(out.path()).into_iter().zip([2, 4, 2]) {
        works(&mut browser, &urdf.with_file_name("viewer.html"), moving);
        let shown =
            browser.run("document.querySelectorAll('#tools, .parts li, [role=tab]').length");
        assert!(shown.as_u64().unwrap() > 6);
    }
}

/// In the manner of models that people use.
fn of_others() -> Vec<(&'static str, String, usize)> {
    let limit = r#"<axis xyz="0 1 0"/><limit lower="-1" upper="1.5" effort="9" velocity="1"/>"#;
    let place = |z: f64| format!(r#"<origin xyz="0 0 {z}"/>"#);
    let arm: String = (0..6)
        .map(|i| {
            let at = place(if i == 0 { 0.1 } else { 0.3 });
            block(&format!("arm{i}"), [0.1, 0.1, 0.28], [0.0, 0.0, 0.15])
                + &joint(
                    &format!("turn{i}"),
                    "revolute",
                    [
                        &if i == 0 { "base".into() } else { format!("arm{}", i - 1) },
                        &format!("arm{i}"),
                    ],
                    &(at + limit),
                )
        })
        .collect();
    let arm = format!(
        "<robot name=\"arm\">{}{arm}</robot>",
        block("base", [0.3, 0.3, 0.1], [0.0, 0.0, 0.05])
    );
    let round = |name: &str, shape: &str| {
        format!("<link name=\"{name}\"><visual><geometry>{shape}</geometry></visual></link>")
    };
    let wheels: String = [-1, 1]
        .map(|side| {
            let (name, y) = (format!("wheel{side}"), 0.25 * f64::from(side));
            let at = format!(r#"<origin xyz="0 {y} -0.2" rpy="1.5708 0 0"/><axis xyz="0 0 1"/>"#);
            round(&name, r#"<cylinder radius="0.1" length="0.05"/>"#)
                .replace("<geometry>", "<origin xyz=\"0.05 0 0\"/><geometry>")
                + &joint(&format!("roll{side}"), "continuous", ["body", &name], &at)
        })
        .concat();
    let head = round("head", r#"<sphere radius="0.2"/>"#)
        + &joint("swivel", "fixed", ["body", "head"], &place(0.35));
    let droid = format!(
        "<robot name=\"droid\">{}{wheels}{head}</robot>",
        round("body", r#"<cylinder radius="0.2" length="0.6"/>"#)
    );
    let table = format!(
        "<robot name=\"table\">{}{}{}</robot>",
        block("top", [1.0, 0.6, 0.04], [0.0, 0.0, 0.7]),
        block("leg", [0.05, 0.05, 0.68], [0.0, 0.0, 0.34]),
        joint("glue", "fixed", ["top", "leg"], "")
    );
    let gripper = r#"<mujoco model="gripper"><compiler angle="radian"/><worldbody>
        <body name="hand"><geom type="box" size=".1 .06 .05"/><inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>
        <body name="left" pos=".03 0 .1"><joint name="l" type="slide" axis="1 0 0" range="0 .04"/><geom type="box" size=".01 .02 .05" mass=".1"/></body>
        <body name="right" pos="-.03 0 .1"><joint name="r" type="slide" axis="-1 0 0" range="0 .04"/><geom type="box" size=".01 .02 .05" mass=".1"/></body>
        </body></worldbody><equality><joint joint1="r" joint2="l"/></equality></mujoco>"#;
    let pendulum = r#"<mujoco model="pendulum"><worldbody><geom type="plane" size="1 1 1"/><body name="post" pos="0 0 .5">
        <geom type="box" size=".05 .05 .5"/><body name="rod" pos="0 -.1 .4"><joint name="swing" type="hinge" axis="0 1 0" range="-90 90"/>
        <geom type="capsule" fromto="0 0 0 0 0 -.6" size=".03"/><geom type="sphere" pos="0 0 -.6" size=".08"/></body></body></worldbody></mujoco>"#;
    vec![
        ("arm.urdf", arm, 6),
        ("droid.urdf", droid, 2),
        ("table.urdf", table, 0),
        ("gripper.xml", gripper.into(), 1),
        ("pendulum.xml", pendulum.into(), 1),
    ]
}

#[test]
fn the_page_of_anybodys_model_works() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    for (name, text, moving) in of_others() {
        let (_folder, path) = model(name, &text);
        works(&mut browser, &page(&path), moving);
    }
}

#[test]
fn a_broken_model_gets_a_page_that_says_what_is_broken() {
    let lost = r#"<robot name="lost"><link name="a"/><link name="b"/>
        <joint name="j" type="fixed"><parent link="a"/><child link="nowhere"/></joint></robot>"#;
    let missing = r#"<robot name="missing"><link name="a"><visual><geometry><mesh filename="no.stl"/></geometry>
        </visual><visual><geometry><box size="1 1 1"/></geometry></visual></link></robot>"#;
    let cases = [
        ("torn.urdf", "<robot name=\"torn\"><link", "still", "not XML"),
        ("lost.urdf", lost, "still", "names the child link `nowhere`, which does not exist"),
        ("missing.urdf", missing, "ready", "mesh `no.stl` does not exist"),
    ];
    let mut browser = Browser::start(SIZE, &[]);
    for (name, urdf, state, words) in cases {
        let (_folder, path) = model(name, urdf);
        let said = view(&path, &["--json"]);
        assert_eq!(said.code, Some(if state == "still" { 3 } else { 0 }), "{said:?}");
        let Some(browser) = &mut browser else { continue };
        assert_eq!(browser.open(&path.with_file_name("page.html")), state, "{name}");
        let shown = text(browser, "body");
        let shown =
            shown + browser.run("document.getElementById('panel').textContent").as_str().unwrap();
        assert!(shown.contains(words), "{name}: no {words:?} in {shown}");
        assert_eq!(browser.complaints(), [""; 0], "{name}");
    }
}

#[test]
fn words_of_strangers_stay_words_in_a_page() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let name = "&lt;/script>&lt;img src=x onerror=alert(1)>";
    let text = slide()
        .replace("\"block\"", &format!("\"{name}\""))
        .replace("\"slide\"", &format!("\"{name}\""));
    let (_folder, path) = model("hostile.urdf", &text);
    assert_eq!(browser.open(&page(&path)), "ready");
    browser.key("l");
    let shown = "</script><img src=x onerror=alert(1)>";
    for selector in ["h1", ".joint .name", ".parts li:last-child .name"] {
        let said = browser.run(&format!("document.querySelector({selector:?}).textContent"));
        assert_eq!(said, shown, "{selector}");
    }
    assert_eq!(browser.run("document.title"), shown);
    assert_eq!(browser.run("document.querySelectorAll('img, script[src]').length"), 0);
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_browser_that_cannot_draw_says_so_and_shows_the_words() {
    let Some(mut browser) = Browser::start(SIZE, &["--disable-3d-apis"]) else { return };
    let (_folder, path) = model("blocked.urdf", &blocked());
    assert_eq!(browser.open(&page(&path)), "still");
    assert!(text(&mut browser, "#message").contains("no WebGL 2"));
    assert!(text(&mut browser, "#panel").contains("overlap by"));
}

#[test]
fn the_page_fits_a_phone_and_follows_the_wish_for_dark() {
    let Some(mut browser) = Browser::start([390, 844], &[]) else { return };
    let (_folder, path) = model("slide.urdf", &slide());
    browser.open(&page(&path));
    let fits = "document.documentElement.scrollWidth <= innerWidth && document.querySelector('.joint').getBoundingClientRect().right <= innerWidth";
    assert_eq!(browser.run(fits), true);
    let light = browser.picture();
    browser.scheme("dark");
    browser.run("dispatchEvent(new Event('resize'))");
    let dark = browser.picture();
    let bright = |p: &RgbImage| {
        p.pixels().map(|p| u64::from(p.0[1])).sum::<u64>() / u64::from(p.width() * p.height())
    };
    assert!(bright(&light) > 180 && bright(&dark) < 80, "{} {}", bright(&light), bright(&dark));
    assert!(spot(&dark, is_blue).is_some());
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_made_asset_has_its_page_and_the_trace_knows_it() {
    let bench = Bench::done();
    let page = bench.out()["viewer.html"].clone();
    assert!(page.starts_with(b"<!doctype html>"));
    let verify = || -> Said {
        let mut command = program();
        command.args(["trace", "verify"]).arg(bench.path("out/trace.mcap")).output().unwrap().into()
    };
    assert_eq!(verify().code, Some(0));
    let forged = String::from_utf8(page).unwrap().replace("tier", "rank");
    std::fs::write(bench.path("out/viewer.html"), forged).unwrap();
    let said = verify();
    assert!(said.code == Some(1) && said.err.contains("viewer.html does not follow"), "{said:?}");
}

#[test]
fn a_made_asset_has_its_pictures_and_the_trace_knows_them() {
    let bench = Bench::done();
    let out = bench.out();
    let parts = image::load_from_memory(&out["parts.png"]).unwrap().to_rgb8();
    assert_eq!(parts.dimensions(), (1140, 800));
    let blue = parts.pixels().filter(|p| is_blue(**p)).count();
    assert!(blue > 15_000, "{blue} pixels of the door");
    assert!(out["motion.webp"].starts_with(b"RIFF") && out["motion.webp"].len() < 1 << 20);
    let trace = bench.trace();
    let named = |name: &str| {
        let mut outputs = trace.events.iter().flat_map(|(_, e)| &e.outputs);
        outputs.any(|o| o.name == name && o.digest == trace::Digest::of(&out[name]))
    };
    assert!(named("parts.png") && named("motion.webp"));
    let run = |args: &[&str]| -> Said {
        let mut command = program();
        command.current_dir(bench.path("")).args(args).output().unwrap().into()
    };
    let said = run(&["trace", "extract", "out/trace.mcap", "motion.webp"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(std::fs::read(bench.path("motion.webp")).unwrap(), out["motion.webp"]);
    let answer: Value = serde_json::from_str(&bench.made(&["--json"]).out).unwrap();
    assert_eq!(answer["pictures"], serde_json::json!(["out/motion.webp", "out/parts.png"]));
    for name in ["parts.png", "motion.webp"] {
        std::fs::write(bench.path("out").join(name), "another").unwrap();
        let said = run(&["trace", "verify", "out"]);
        let told = format!("{name} does not follow");
        assert!(said.code == Some(1) && said.err.contains(&told), "{said:?}");
        std::fs::write(bench.path("out").join(name), &out[name]).unwrap();
    }
    assert_eq!(run(&["trace", "verify", "out"]).code, Some(0));
}

/// A green ball on a plate whose colour a material of the robot has.
const PAINTED: &str = r#"<robot name="painted"><link name="plate"><visual><origin xyz="0 0 -0.1"/><geometry>
    <box size="1 1 0.1"/></geometry><material name="orange"/></visual></link><link name="ball"><visual><geometry>
    <sphere radius="0.3"/></geometry><material name="leaf"><color rgba="0 0.7 0.1 1"/></material></visual></link>
    <joint name="held" type="fixed"><parent link="plate"/><child link="ball"/><origin xyz="0 0 0.4"/></joint>
    <material name="orange"><color rgba="1 0.5 0 1"/></material></robot>"#;

/// The same in MJCF: the plate by a material, the ball by a colour of its own.
const PAINTED_TOO: &str = r#"<mujoco model="painted"><asset><material name="orange" rgba="1 0.5 0 1"/></asset>
    <worldbody><geom type="box" size="0.5 0.5 0.05" pos="0 0 -0.1" material="orange"/><body name="ball" pos="0 0 0.4">
    <geom size="0.3" rgba="0 0.7 0.1 1" material="orange"/></body></worldbody></mujoco>"#;

#[test]
fn a_model_of_others_is_seen_in_the_colours_its_file_gives_it() {
    let Some(mut browser) = Browser::start(SIZE, &[]) else { return };
    let green = |Rgb([r, g, b]): Rgb<u8>| g > 90 && g / 2 > r && g / 2 > b;
    let orange = |Rgb([r, g, b]): Rgb<u8>| r > 150 && r - 50 > g && g > 40 && g - 40 > b;
    for (name, text) in [("painted.urdf", PAINTED), ("painted.xml", PAINTED_TOO)] {
        let (_folder, path) = model(name, text);
        assert_eq!(browser.open(&page(&path)), "ready", "{name}");
        let seen = |browser: &mut Browser| {
            let picture = browser.picture();
            [spot(&picture, green).is_some(), spot(&picture, orange).is_some()]
        };
        assert_eq!(seen(&mut browser), [false, false], "{name}: colours of parts");
        browser.key("c");
        assert_eq!(seen(&mut browser), [true, true], "{name}: true look");
        assert_eq!(browser.complaints(), [""; 0]);
    }
}

#[test]
fn a_folder_its_urdf_and_its_trace_are_shown_alike() {
    let bench = Bench::done();
    let told = |name: &str| -> Value {
        let said = view(&bench.path(name), &["--json"]);
        assert_eq!(said.code, Some(0), "{said:?}");
        let mut value: Value = serde_json::from_str(&said.out).unwrap();
        value["page"] = Value::Null;
        value
    };
    let folder = told("out");
    assert_eq!((&folder["name"], &folder["links"]), (&"cabinet".into(), &2.into()));
    std::fs::remove_file(bench.path("page.html")).unwrap();
    assert_eq!(told("out/asset.urdf"), folder);
    std::fs::remove_file(bench.path("out/page.html")).unwrap();
    let mut trace = told("out/trace.mcap");
    let note = "The trace names this asset by its digest; shown is the one beside it.";
    assert_eq!(trace["notes"].take(), Value::from(vec![note]));
    let mut plain = folder;
    plain["notes"] = Value::Null;
    assert_eq!(trace, plain);
}

#[test]
fn a_page_goes_where_it_is_told_and_replaces_nothing_of_others() {
    let (folder, path) = model("slide.urdf", &slide());
    let run = |more: &[&str]| -> Said {
        let mut command = program();
        command.current_dir(folder.path()).args(["view", "slide.urdf"]).args(more);
        command.output().unwrap().into()
    };
    assert_eq!(run(&[]).out, "slide.html\n");
    assert_eq!(run(&[]).code, Some(0), "a page of ours is replaced");
    std::fs::write(folder.path().join("mine.html"), "mine").unwrap();
    let said = run(&["--out", "mine.html"]);
    assert!(said.code == Some(2) && said.err.contains("no page of kinfold's"), "{said:?}");
    assert_eq!(std::fs::read_to_string(folder.path().join("mine.html")).unwrap(), "mine");
    let said = view(&path.with_file_name("nobody.urdf"), &[]);
    assert!(said.code == Some(1) && said.err.starts_with("error: "), "{said:?}");
}

#[cfg(unix)]
#[test]
fn a_model_whose_check_does_not_end_still_gets_a_page() {
    let (_folder, path) = model("slide.urdf", &slide());
    let said = view(&path, &["--json", "--deadline", "0.001"]);
    let value: Value = serde_json::from_str(&said.out).unwrap();
    assert!(said.err.contains("took longer than 0.001 s"), "{said:?} {value}");
}
