use std::io;

use super::*;

fn names(root: &Path) -> Vec<String> {
    let name = |e: io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(root).unwrap().map(name).collect();
    names.retain(|name| !marker::is_marker(name));
    names.sort();
    names
}

fn files(files: &[(&str, &str)]) -> Files {
    files.iter().map(|(n, b)| ((*n).into(), b.as_bytes().to_vec())).collect()
}

fn run(root: &Path, made: &[(&str, &str)]) {
    let folder = OutFolder::open(root, Turns::AT_ONCE).unwrap();
    let attempt = folder.begin().unwrap();
    fs::write(attempt.trace(), "trace").unwrap();
    attempt.publish(&files(made)).unwrap();
}

#[test]
fn a_finished_run_leaves_its_files_and_those_of_the_earlier_run_are_gone() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().join("out");
    run(&root, &[("asset.urdf", "1"), ("meshes/a.obj", "a"), ("verdict.json", "v")]);
    assert_eq!(names(&root), ["asset.urdf", "meshes", "trace.mcap", "verdict.json"]);
    run(&root, &[("asset.urdf", "2"), ("meshes/b.obj", "b")]);
    assert_eq!(names(&root), ["asset.urdf", "meshes", "trace.mcap"]);
    assert_eq!(names(&root.join("meshes")), ["b.obj"]);
    assert_eq!(fs::read(root.join("asset.urdf")).unwrap(), b"2");
    assert_eq!(names(dir.path()), ["out"], "nothing is left beside it");
}

#[test]
fn a_failed_run_leaves_the_good_asset_and_its_own_trace_beside() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().join("out");
    run(&root, &[("asset.urdf", "1"), ("meshes/a.obj", "a")]);
    let folder = OutFolder::open(&root, Turns::AT_ONCE).unwrap();
    let attempt = folder.begin().unwrap();
    fs::write(attempt.trace(), "failed").unwrap();
    let trace = attempt.fail();
    assert_eq!(trace, dir.path().join("out.failed/1/trace.mcap"));
    assert_eq!(fs::read(trace).unwrap(), b"failed");
    assert_eq!(names(&root), ["asset.urdf", "meshes", "trace.mcap"]);
}

#[test]
fn only_the_last_failed_runs_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().join("out");
    let shelf = dir.path().join("out.failed");
    for n in 1..=KEPT + 3 {
        let folder = OutFolder::open(&root, Turns::AT_ONCE).unwrap();
        let attempt = folder.begin().unwrap();
        fs::write(attempt.trace(), n.to_string()).unwrap();
        // Every other one is killed.
        if n % 2 == 0 {
            attempt.fail();
        }
        if n == 2 {
            fs::write(shelf.join("2/notes.txt"), "mine").unwrap();
        }
    }
    let last = names(&shelf);
    assert_eq!(last, ["2", "4", "5", "6", "7", "8"], "and what holds files of others");
    assert_eq!(names(&shelf.join("2")), ["notes.txt"]);
}

#[test]
fn somebody_elses_folder_is_refused_before_anything_in_it_changes() {
    let strange: [&[(&str, &str)]; 4] = [
        &[("meshes/mine.obj", "mine")],
        &[("trace.mcap", "bag"), ("meshes/mine.obj", "mine")],
        &[("trace.mcap.partial", "bag"), ("asset.urdf", "mine")],
        &[(".kinfold", "{\"schema\":\"kinfold-folder/1\",\"kind\":\"state\"}")],
    ];
    for entries in strange {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("out");
        for (name, text) in entries {
            let path = root.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let error = OutFolder::open(&root, Turns::AT_ONCE).unwrap_err();
        assert!(matches!(error, OutError::NotOurs { .. } | OutError::Kind { .. }), "{error}");
        assert_eq!(names(dir.path()), ["out"]);
        for (name, text) in entries {
            assert_eq!(fs::read_to_string(root.join(name)).unwrap(), *text);
        }
    }
}

#[test]
fn what_a_kill_left_between_two_folders_is_set_right() {
    for (new_stands, after) in [(false, "1"), (true, "2")] {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("out");
        run(&root, &[("asset.urdf", "1")]);
        fs::write(root.join("notes.txt"), "mine").unwrap();
        // As it is where two folders cannot be exchanged: the old one moved aside, and then a kill.
        let folder = OutFolder::open(&root, Turns::AT_ONCE).unwrap();
        let attempt = folder.begin().unwrap();
        attempt.making.fill(&files(&[("asset.urdf", "2")])).unwrap();
        fs::hard_link(root.join("notes.txt"), attempt.making.path("notes.txt")).unwrap();
        let next = folder.shelf.join(NEXT);
        fs::rename(attempt.making.root(), &next).unwrap();
        fs::rename(&root, folder.shelf.join(BEFORE)).unwrap();
        if new_stands {
            fs::rename(&next, &root).unwrap();
        }
        drop(attempt);
        drop(folder);
        drop(OutFolder::open(&root, Turns::AT_ONCE).unwrap());
        assert_eq!(fs::read_to_string(root.join("asset.urdf")).unwrap(), after);
        assert_eq!(fs::read_to_string(root.join("notes.txt")).unwrap(), "mine");
        assert_eq!(names(dir.path()), ["out"]);
    }
}

#[test]
fn a_folder_that_nothing_can_replace_is_refused() {
    for root in ["/", "."] {
        let error = OutFolder::look(Path::new(root)).unwrap_err();
        assert!(error.to_string().contains("nothing can take its place"), "{error}");
    }
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("file"), "mine").unwrap();
    let error = OutFolder::look(&dir.path().join("file")).unwrap_err().to_string();
    assert!(error.ends_with("is no folder"), "{error}");
}

#[test]
fn how_good_an_asset_is_stands_in_its_own_verdict() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().join("out");
    let standing = || OutFolder::open(&root, Turns::AT_ONCE).unwrap().standing();
    assert_eq!(standing(), Standing::Nothing);
    run(&root, &[("asset.urdf", "1"), ("verdict.json", "no verdict")]);
    assert_eq!(standing(), Standing::Unknown("its verdict.json is no verdict of ours".into()));
}
