//! Whatever a file says, it is forecast or refused with a reason; nothing panics.

use forecast::{Client, Outside, forecast};

use crate::peculiarities;

#[test]
fn cut_and_twisted_files_are_forecast_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m");
    let ask = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        if let Err(e) = forecast(&path, &Client::ALL, Outside::Refused) {
            assert!(e.to_string().len() < 400, "{e}");
        }
    };
    for file in peculiarities::all() {
        let bytes = file.text.as_bytes();
        for cut in (0..bytes.len()).step_by(41) {
            ask(&bytes[..cut]);
            let mut twisted = bytes.to_vec();
            twisted[cut] = b"<>\"'=/ \0\xff9-e{}"[cut % 14];
            ask(&twisted);
        }
    }
}

#[test]
fn rings_and_joints_to_nowhere_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.urdf");
    let joint = |parent: &str, child: &str| {
        format!(
            "<joint name='{parent}{child}' type='fixed'><parent link='{parent}'/><child link='{child}'/></joint>"
        )
    };
    let ring = format!(
        "<robot><link name='a'/><link name='b'/>{}{}</robot>",
        joint("a", "b"),
        joint("b", "a")
    );
    std::fs::write(&path, ring).unwrap();
    forecast(&path, &Client::ALL, Outside::Refused).unwrap();
    let nowhere = format!("<robot><link name='a'/>{}<joint/></robot>", joint("x", "y"));
    std::fs::write(&path, nowhere).unwrap();
    forecast(&path, &Client::ALL, Outside::Refused).unwrap();
}

#[test]
fn a_file_of_too_many_links_is_refused_by_its_count() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.urdf");
    let links: String = (0..20_001).map(|i| format!("<link name='l{i}'/>\n")).collect();
    std::fs::write(&path, format!("<robot name='m'>\n{links}</robot>")).unwrap();
    let e = forecast(&path, &Client::ALL, Outside::Refused).unwrap_err().to_string();
    assert!(e.contains("line 20002: a URDF has at most"), "{e}");
}

#[test]
fn the_most_links_that_are_read_take_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.urdf");
    let mut text = "<robot name='m'>".to_string();
    for i in 0..9_999 {
        let (j, k) = (i + 1, i.max(1) - 1);
        text += &format!(
            "<link name='l{i}'/>\n<joint name='j{i}' type='fixed'><parent link='l{i}'/>\
             <child link='l{j}'/><mimic joint='j{k}' multiplier='2'/></joint>\n"
        );
    }
    std::fs::write(&path, text + "</robot>").unwrap();
    let start = std::time::Instant::now();
    forecast(&path, &Client::ALL, Outside::Refused).unwrap();
    let took = start.elapsed().as_secs();
    assert!(took < 60, "{took} s, and this is a build for tests");
}

#[test]
fn meshes_outside_the_folder_are_not_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let path = inner.join("m.urdf");
    let text = "<robot name='m'><link name='a'><collision><geometry>\
                <mesh filename='../sheet.obj'/></geometry></collision></link></robot>";
    std::fs::write(&path, text).unwrap();
    std::fs::write(folder.path().join("sheet.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        .unwrap();
    let flat = |outside| {
        let said = forecast(&path, &[Client::Mujoco], outside).unwrap();
        said[0].findings.iter().any(|f| f.rule == "mujoco.mesh-flat")
    };
    assert!(!flat(Outside::Refused));
    assert!(flat(Outside::Allowed));
}
