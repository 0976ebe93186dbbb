//! Files nobody should write: every one gets a verdict, none a panic.
#![allow(clippy::unwrap_used, reason = "a test that cannot write its file should stop")]

use std::path::PathBuf;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_check::{CheckOptions, Status, Tier, Verdict, check};

const GOOD: &str = r#"<robot name="r">
<link name="a"><inertial><mass value="200"/><inertia ixx="33" iyy="33" izz="33" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size="1 1 1"/></geometry></visual><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="0.085" iyy="0.085" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><cylinder radius="0.06" length="1"/></geometry></visual><collision><geometry><cylinder radius="0.06" length="1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.57 0 0" rpy="0 0 0.1"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"#;

/// A folder of this process and test, gone when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("kinfold-hostile-{}-{test}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn verdict(&self, bytes: &[u8], up_to: Tier) -> Verdict {
        let urdf = self.0.join("r.urdf");
        std::fs::write(&urdf, bytes).unwrap();
        check(&urdf, &CheckOptions { up_to, ..CheckOptions::default() })
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn broke_down(verdict: &Verdict) -> bool {
    verdict.checks.iter().flat_map(|c| &c.evidence).any(|e| e.contains("panic"))
}

#[test]
fn spoiled_files_get_a_verdict() {
    const WORDS: [&str; 12] = [
        "nan",
        "-1",
        "0",
        "1e308",
        "1e-308",
        "fixed",
        "prismatic",
        "planar",
        "<link name=\"a\"/>",
        "\"",
        "</link>",
        "mesh filename=\"x.obj\"",
    ];
    let folder = Folder::new("spoiled");
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let numbers: Vec<_> = GOOD.match_indices('"').map(|(i, _)| i).collect();
    for round in 0..200 {
        let mut text = GOOD.as_bytes().to_vec();
        for _ in 0..=round % 3 {
            let at = rng.random_range(0..text.len());
            match rng.random_range(0..4) {
                0 => text[at] = rng.random(),
                1 => text.truncate(at),
                2 => drop(text.splice(at..at, *b"<")),
                _ => {
                    let word = WORDS[rng.random_range(0..WORDS.len())];
                    let pair = rng.random_range(0..numbers.len() / 2) * 2;
                    let (from, to) = (numbers[pair] + 1, numbers[pair + 1]);
                    if to <= text.len() {
                        text.splice(from..to, word.bytes());
                    }
                }
            }
            if text.is_empty() {
                break;
            }
        }
        let verdict = folder.verdict(&text, Tier::Static);
        let shown = String::from_utf8_lossy(&text);
        assert!(!broke_down(&verdict), "{shown}\n{}", verdict.to_json());
    }
}

#[test]
fn what_cannot_be_read_fails_and_says_why() {
    let folder = Folder::new("unread");
    let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    let files: [(&[u8], &str); 6] = [
        (b"", "not XML"),
        (b"\xff\xfe", "not UTF-8"),
        (b"<html/>", "must be `robot`, `mujoco` or `sdf`"),
        (b"<robot name=\"r\"><link name=\"a\"/>", "not XML"),
        (deep.as_bytes(), "elements nest at most 1100 deep, found 100000"),
        (b"<!DOCTYPE x [<!ENTITY e \"e\">]><robot name=\"r\"/>", "not XML"),
    ];
    for (bytes, why) in files {
        let verdict = folder.verdict(bytes, Tier::Audited);
        let f1 = verdict.check("F1").unwrap();
        assert_eq!((verdict.tier, f1.status), (Tier::None, Status::Fail));
        assert!(f1.evidence[0].contains(why), "{why}: {:?}", f1.evidence);
        assert!(verdict.checks.iter().all(|c| c.status != Status::Pass), "{}", verdict.to_json());
    }
    let gone = check(&folder.0.join("gone.urdf"), &CheckOptions::default());
    assert!(gone.check("F1").unwrap().evidence[0].contains("cannot be opened"));
    let own = check(&folder.0, &CheckOptions::default());
    assert!(own.check("F1").unwrap().evidence[0].contains("is not a file"));
}

#[test]
fn a_robot_without_anything_passes_nothing_vacuously() {
    let folder = Folder::new("empty");
    let verdict = folder.verdict(b"<robot name=\"r\"><link name=\"a\"/></robot>", Tier::Dynamic);
    assert_eq!(verdict.tier, Tier::Parse);
    for id in ["U2", "G1", "G2", "G3", "G4", "C1", "C2", "S1"] {
        assert_eq!(verdict.check(id).unwrap().status, Status::Unknown, "{id}");
    }
}

#[test]
fn the_unspoiled_file_is_static() {
    let verdict = Folder::new("good").verdict(GOOD.as_bytes(), Tier::Static);
    assert_eq!(verdict.tier, Tier::Static, "{}", verdict.to_json());
}

/// What is wrong with the text of a file, by its first finding.
fn refused(folder: &Folder, text: &str) -> String {
    let verdict = folder.verdict(text.as_bytes(), Tier::Static);
    let f1 = verdict.check("F1").unwrap();
    assert_eq!(f1.status, Status::Fail);
    f1.evidence[0].clone()
}

/// The parser compares each attribute with all others of its element: these took minutes.
#[test]
fn nine_hundred_thousand_attributes_of_one_element_are_refused_at_once() {
    let folder = Folder::new("attributes");
    let attributes: String = (0..900_000).map(|i| format!(" a{i}=\"\"")).collect();
    for root in ["robot name=\"r\"", "mujoco"] {
        let end = root.split(' ').next().unwrap();
        let text = format!("<{root}>\n<link{attributes}/></{end}>");
        let found = "line 2: an element has at most 256 attributes, found 900000";
        assert_eq!(refused(&folder, &text), found);
    }
}

#[test]
fn namespaces_within_namespaces_are_refused_before_they_are_copied() {
    let folder = Folder::new("namespaces");
    let open: String = (0..30_000).map(|i| format!("<a xmlns:n{i}=\"u{i}\">")).collect();
    let text = format!("<robot name=\"r\">{open}{}</robot>", "</a>".repeat(30_000));
    assert!(refused(&folder, &text).contains("at most 64 namespaces, found 30000"));
}

#[test]
fn elements_nested_a_million_deep_are_refused() {
    let folder = Folder::new("nested");
    for tag in ["body", "default", "frame"] {
        let (open, close) = (format!("<{tag}>"), format!("</{tag}>"));
        let (open, close) = (open.repeat(500_000), close.repeat(500_000));
        let text = format!("<mujoco><worldbody>{open}{close}</worldbody></mujoco>");
        assert!(refused(&folder, &text).contains("nest at most 1100 deep, found 500002"));
    }
}

#[test]
fn a_name_of_megabytes_is_not_repeated_in_every_finding() {
    let folder = Folder::new("names");
    let long = "x".repeat(4 << 20);
    let found = refused(&folder, &GOOD.replace("name=\"a\"", &format!("name=\"{long}\"")));
    assert!(found.contains("a name has at most 1024 bytes, found 4194304"), "{found}");
    let found = refused(&folder, &GOOD.replace("xyz=\"0.57 0 0\"", &format!("xyz=\"{long}\"")));
    assert!(found.chars().count() < 200, "{}", found.len());
}

#[test]
fn entities_cannot_be_declared() {
    let folder = Folder::new("entities");
    let laughs = "<!DOCTYPE r [<!ENTITY a \"&b;&b;&b;&b;\"><!ENTITY b \"ha\">]>";
    let found = refused(&folder, &format!("{laughs}<robot name=\"&a;\"/>"));
    assert!(found.contains("not XML"), "{found}");
}

#[test]
fn a_million_instructions_and_pieces_of_text_get_a_verdict() {
    let folder = Folder::new("pieces");
    for piece in ["<?a b?>", "<![CDATA[x]]>", "<!--x-->", "&#97;\r"] {
        let text = format!("<robot name=\"r\"><link name=\"a\"/>{}</robot>", piece.repeat(900_000));
        let verdict = folder.verdict(text.as_bytes(), Tier::Static);
        assert_eq!(verdict.check("F1").unwrap().status, Status::Pass, "{piece}");
    }
}
