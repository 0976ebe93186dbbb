//! Files with one known defect each: the named check must catch it, and pass on the good file.
#![allow(clippy::print_stderr, reason = "a skipped test must say so")]

use std::path::PathBuf;

use sim_check::{CheckOptions, Status, Tier, Verdict, check};

/// Which check must fail on which file.
const DEFECTS: [(&str, &str); 20] = [
    ("01_no_inertial_child", "M1"),
    ("02_zero_mass", "M1"),
    ("04_inertia_not_posdef", "M3"),
    ("05_inertia_triangle_violation", "M3"),
    ("06_inertia_identity_1kgm2", "M4"),
    ("08_axis_zero", "J1"),
    ("10_limits_inverted", "J2"),
    ("12_limits_missing_revolute", "J2"),
    ("13_limit_degrees_not_rad", "J3"),
    ("15_links_overlap_at_rest", "C1"),
    ("16_overlap_along_range_only", "C2"),
    ("18_detached_floating_part", "J5"),
    ("19_missing_mesh_file", "F2"),
    ("21_nonwatertight_collision", "G2"),
    ("22_inverted_winding", "G2"),
    ("24_no_collision_geometry", "G3"),
    ("26_two_roots_orphan", "T1"),
    ("29_nan_origin", "F1"),
    ("33_rest_outside_limits", "J2"),
    ("35_axis_sign_flipped_opens_inward", "C5"),
];

/// The folder of defects beside the repo, or a loud word that it is not there.
fn folder() -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let shared = std::env::var_os("KINFOLD_SHARED").map_or(beside.into(), PathBuf::from);
    let folder = shared.join("data/defects");
    if !folder.is_dir() {
        eprintln!("SKIPPED: {} is not there, no defect was checked", folder.display());
        return None;
    }
    Some(folder)
}

fn verdict(folder: &std::path::Path, name: &str) -> Verdict {
    check(&folder.join(format!("{name}.urdf")), &CheckOptions::default())
}

#[test]
fn the_good_file_reaches_dynamic() {
    let Some(folder) = folder() else { return };
    let good = verdict(&folder, "00_good");
    assert_eq!(good.tier, Tier::Dynamic, "{}", good.to_json());
}

#[test]
fn every_defect_is_caught_by_its_check_and_the_good_file_passes_that_check() {
    let Some(folder) = folder() else { return };
    let good = verdict(&folder, "00_good");
    let mut missed = Vec::new();
    for (name, id) in DEFECTS {
        let found = verdict(&folder, name);
        let caught = found.check(id).is_some_and(|c| !c.holds());
        let clean = good.check(id).is_some_and(sim_check::Check::holds);
        if !caught || !clean || found.tier >= Tier::Dynamic {
            missed.push(format!(
                "{name}: {id} (clean on the good file: {clean})\n{}",
                found.to_json()
            ));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn a_defect_of_one_kind_leaves_the_checks_of_other_kinds_alone() {
    let Some(folder) = folder() else { return };
    for (name, allowed) in [
        ("05_inertia_triangle_violation", &["M3", "M4"][..]),
        ("06_inertia_identity_1kgm2", &["M4"]),
        ("21_nonwatertight_collision", &["G2", "G3"]),
        ("22_inverted_winding", &["G1", "G2"]),
        ("33_rest_outside_limits", &["J2"]),
    ] {
        let found = verdict(&folder, name);
        let is_mine =
            |id: &str| !id.starts_with(['C', 'S', 'P']) && !["F4", "M7", "J7"].contains(&id);
        let failed: Vec<_> =
            found.failures().map(|c| c.id.as_str()).filter(|id| is_mine(id)).collect();
        assert!(failed.iter().all(|id| allowed.contains(id)), "{name}: {failed:?}");
    }
}

#[test]
fn the_same_file_gives_the_same_bytes() {
    let Some(folder) = folder() else { return };
    let twice = [0, 1].map(|_| verdict(&folder, "16_overlap_along_range_only").to_json());
    assert_eq!(twice[0], twice[1]);
    let back: Verdict = serde_json::from_str(&twice[0]).unwrap();
    assert!(back.checks.iter().any(|c| c.status == Status::Fail));
}
