//! Small files that took a check to its deadline, and what bounds one that takes much memory.

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::kinfold::{Bench, say};

/// Boxes of 1 m in a row, each hinged to the one before.
fn chain(links: usize) -> String {
    let shape = "<geometry><box size=\"1 1 1\"/></geometry>";
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"0.2\" iyy=\"0.2\" izz=\"0.2\" \
                    ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
    let mut text = String::from("<robot name=\"r\">");
    for l in 0..links {
        let seen = format!("<visual>{shape}</visual><collision>{shape}</collision>");
        writeln!(text, "<link name=\"l{l}\">{inertial}{seen}</link>").unwrap();
    }
    for (above, l) in (1..links).enumerate() {
        writeln!(
            text,
            "<joint name=\"j{l}\" type=\"revolute\"><parent link=\"l{above}\"/><child link=\"l{l}\"/>\
             <origin xyz=\"1.1 0 0\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
        )
        .unwrap();
    }
    text + "</robot>"
}

/// It took more than two minutes of processor time, and so was unknown; it takes three seconds.
#[test]
fn a_chain_of_512_links_is_judged_before_its_deadline() {
    let bench = Bench::new();
    let path = bench.path("chain.urdf");
    std::fs::write(&path, chain(512)).unwrap();
    let said =
        say(&["check", path.to_str().unwrap(), "--json", "--as", "object", "--deadline", "60"]);
    let verdict: Value = serde_json::from_str(&said.out).unwrap();
    let status = |id: &str| {
        let checks = verdict["checks"].as_array().unwrap();
        checks.iter().find(|c| c["id"] == id).unwrap()["status"].clone()
    };
    for id in ["F1", "T1", "J5", "J7", "C1", "C2", "C4", "C5", "S1", "S2", "S3", "S4", "S5"] {
        assert_eq!(status(id), "pass", "{id}: {verdict:#}");
    }
    assert_eq!(status("C3"), "unknown", "130,000 pairs of joints are too many, and not a pass");
}

#[test]
fn sixty_thousand_attributes_are_refused_with_file_line_and_rule() {
    let bench = Bench::new();
    let path = bench.path("attributes.urdf");
    let attributes: String = (0..60_000).map(|i| format!(" a{i}=\"\"")).collect();
    let text = format!("<robot name=\"r\">\n<link name=\"a\"{attributes}/></robot>");
    std::fs::write(&path, text).unwrap();
    let said = say(&["check", path.to_str().unwrap()]);
    assert_eq!(said.code, Some(1), "{said:?}");
    let rule = "line 2: an element has at most 256 attributes, found 60001";
    assert!(said.out.contains(rule), "{}", said.out);
    assert!(said.err.contains("attributes.urdf"), "{}", said.err);
}

#[cfg(target_os = "linux")]
#[test]
fn a_process_that_checks_may_take_8_gib_of_memory_and_no_more() {
    let bench = Bench::new();
    let path = bench.path("chain.urdf");
    std::fs::write(&path, chain(2)).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_kinfold"))
        .args(["check", "--here", "--json", "--tier", "static", "--", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    writeln!(child.stdin.as_mut().unwrap(), "{}", serde_json::to_string(path.as_os_str()).unwrap())
        .unwrap();
    let mut answer = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut answer).unwrap();
    assert!(answer.contains("simready-urdf"), "{answer}");
    let limits = std::fs::read_to_string(format!("/proc/{}/limits", child.id())).unwrap();
    let space = limits.lines().find(|l| l.starts_with("Max address space")).unwrap().to_owned();
    drop(child.stdin.take());
    assert!(child.wait().unwrap().success());
    assert_eq!(space.split_whitespace().nth(3), Some("8589934592"), "{space}");
}
