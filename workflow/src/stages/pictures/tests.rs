//! Pictures of a small robot: what is to be seen on them.

use image::AnimationDecoder as _;
use image::codecs::webp::WebPDecoder;
use sim_check::read::load::from_text;

use super::*;

/// A plate with a block that slides to the right by half a metre and bears a knob that turns; the knob's
/// two joints stand with a bare link between them.
fn robot() -> Robot {
    let block = |name: &str, size: &str, at: &str| {
        format!(
            r#"<link name="{name}"><visual><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></visual></link>"#
        )
    };
    let joint = |name: &str, kind: &str, ends: [&str; 2], more: &str| {
        let [parent, child] = ends;
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>"#
        )
    };
    let slide = r#"<axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/>"#;
    let tilt = r#"<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/><limit lower="-0.5" upper="1" effort="1" velocity="1"/>"#;
    let text = [
        block("plate", "1 0.3 0.05", "0 0 0.025"),
        block("block", "0.2 0.2 0.2", "-0.3 0 0.15"),
        r#"<link name="bare"/>"#.into(),
        block("knob", "0.1 0.02 0.1", "-0.3 -0.12 0"),
        joint("slide", "prismatic", ["plate", "block"], slide),
        joint("tilt", "revolute", ["block", "bare"], tilt),
        joint("spin", "continuous", ["bare", "knob"], r#"<axis xyz="0 0 1"/>"#),
    ];
    let text = format!("<robot name=\"r\">{}</robot>", text.concat());
    from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap()
}

fn frames(film: &[u8]) -> Vec<image::RgbaImage> {
    let decoder = WebPDecoder::new(std::io::Cursor::new(film)).unwrap();
    let frames = decoder.into_frames().collect_frames().unwrap();
    frames.into_iter().map(image::Frame::into_buffer).collect()
}

/// How many pixels are nearest to a part's hue.
fn pixels(picture: &image::RgbaImage, link: usize) -> usize {
    let hue = view::part_colour(link).map(i32::from);
    let strong = |p: &[i32; 3]| p.iter().max().unwrap() - p.iter().min().unwrap() > 60;
    let alike = |p: &[i32; 3]| {
        let scale = |c: [i32; 3]| c.map(|v| 100 * v / c.iter().max().unwrap().max(&1));
        let (a, b) = (scale(*p), scale(hue));
        (0..3).all(|i| (a[i] - b[i]).abs() < 14)
    };
    let all = picture.pixels().map(|p| [p[0], p[1], p[2]].map(i32::from));
    all.filter(|p| strong(p) && alike(p)).count()
}

#[test]
fn parts_are_to_be_seen_in_their_colours_and_stand_beside_the_view_by_name() {
    let robot = robot();
    let files = drawn(&robot).unwrap();
    let picture = image::load_from_memory(&files[Pictures::PARTS]).unwrap().into_rgba8();
    assert_eq!(picture.dimensions(), (1140, 800));
    assert!(pixels(&picture, 1) > 5_000 && pixels(&picture, 3) > 500, "block and knob");
    let names = image::imageops::crop_imm(&picture, 800, 0, 340, 800).to_image();
    assert!(pixels(&names, 1) > 200 && pixels(&names, 3) > 200, "each has its colour there");
    let dark = names.pixels().filter(|p| p[0] < 60).count();
    assert!(dark > 500, "{dark} pixels of names");
    assert_eq!(files, drawn(&robot).unwrap(), "the same bytes each time");
}

#[test]
fn every_joint_is_seen_to_move_and_comes_back() {
    let files = drawn(&robot()).unwrap();
    let film = &files[Pictures::MOTION];
    let frames = frames(film);
    assert!(film.len() < 1 << 20 && (20..60).contains(&frames.len()), "{} frames", frames.len());
    let differ = |a: usize, b: usize| {
        let pixels = frames[a].pixels().zip(frames[b].pixels());
        pixels.filter(|(p, q)| (0..3).any(|c| p[c].abs_diff(q[c]) > 2)).count()
    };
    assert_eq!(differ(0, frames.len() - 1), 0, "it ends as it began");
    let most = (1..frames.len()).map(|i| differ(0, i)).max().unwrap();
    assert!(most > 3_000, "{most} pixels differ where most moved");
}

#[test]
fn a_robot_of_many_joints_or_of_none_is_shown_all_the_same() {
    let link = |i: usize| {
        let at = i as f64 * 0.15;
        format!(
            r#"<link name="l{i}"><visual><origin xyz="{at} 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>"#
        )
    };
    let joint = |i: usize| {
        format!(
            r#"<joint name="a_joint_with_a_long_name_{i}" type="prismatic"><parent link="l0"/><child link="l{i}"/>
            <axis xyz="0 0 1"/><limit lower="-0.1" upper="0.2" effort="1" velocity="1"/></joint>"#
        )
    };
    for count in [1, 130] {
        let links: String = (0..count).map(link).collect();
        let joints: String = (1..count).map(joint).collect();
        let text = format!("<robot name=\"r\">{links}{joints}</robot>");
        let robot = from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
        let files = drawn(&robot).unwrap();
        let film = frames(&files[Pictures::MOTION]);
        assert_eq!(film.len() > 1, count > 1, "{count}: {} frames", film.len());
        let parts = image::load_from_memory(&files[Pictures::PARTS]).unwrap();
        assert_eq!(parts.width(), if count > 1 { 800 + 3 * 340 } else { 1140 });
    }
}

#[test]
fn of_what_cannot_be_seen_there_is_no_picture() {
    let text = r#"<robot name="r"><link name="a"/></robot>"#;
    let robot = from_text(text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
    assert!(drawn(&robot).unwrap().is_empty());
}
