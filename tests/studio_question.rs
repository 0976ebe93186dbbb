//! The question that the studio asks first, answered as a person answers it.

use object::glb;
use serde_json::{Value, json};

use crate::browser::CTRL;
use crate::cabinet::{self, Cabinet};
use crate::desk::{Page, Studio};

/// A studio of a cabinet whose door is a plain slab: nothing tells at which side its hinge is.
fn undecided() -> Studio {
    let folder = tempfile::tempdir().unwrap();
    Cabinet::write(folder.path());
    let mut condition = cabinet::condition();
    condition["schema"] = json!("kinfold-condition/2");
    std::fs::write(folder.path().join("mine.json"), format!("{condition:#}\n")).unwrap();
    let named = ["photo.png", "--mesh", "cabinet.glb"];
    let files = ["--condition", "mine.json", "--state", "state"];
    Studio::start(folder, &[&named[..], &files].concat())
}

#[test]
fn the_studio_asks_how_a_door_moves_and_an_answer_stands_in_the_file() {
    let studio = undecided();
    let Some(mut page) = Page::open(&studio) else { return };
    assert!(
        page.text("#notice-question").contains("How does door move?"),
        "{}",
        page.text("#notices")
    );
    let answers = page
        .browser
        .run("[...document.querySelectorAll('#notice-question button')].map((b) => b.innerText)");
    let answers: Vec<&str> = answers.as_array().unwrap().iter().filter_map(Value::as_str).collect();
    let first = answers.first().copied().unwrap_or_default();
    assert!(first.contains("axis"), "{answers:?}");
    page.click("#notice-question button:not(.icon)");
    page.rest();
    let door = studio.part("door");
    for field in ["axis", "pivot", "range"] {
        assert!(door[field].is_array(), "{door}");
    }
    assert!(!page.text("#notices").contains("How does door move?"), "it is not asked again");
    page.browser.key_with("z", CTRL);
    page.rest();
    assert!(studio.part("door").get("axis").is_none(), "it is undone like any other change");
    assert_eq!(page.browser.complaints(), Vec::<String>::new());
}

/// A studio of a chest with two lids side by side: nothing tells at which sides their hinges are.
fn undecided_twice() -> Studio {
    let folder = tempfile::tempdir().unwrap();
    Cabinet::write(folder.path());
    let body = [[-0.4, 0.0, 0.0], [0.4, 0.3, 0.6]];
    let lids = [[[-0.4, 0.0, 0.602], [-0.002, 0.3, 0.62]], [[0.002, 0.0, 0.602], [0.4, 0.3, 0.62]]];
    let mesh = cabinet::boxes(&[body, lids[0], lids[1]]);
    std::fs::write(folder.path().join("cabinet.glb"), glb::write(&mesh)).unwrap();
    let lid = |name: &str, x: f64| {
        json!({ "name": name, "text": "lid", "parent": "body", "joint": "revolute",
                "point": cabinet::in_file([x, 0.15, 0.62]) })
    };
    let condition = json!({
        "schema": "kinfold-condition/2",
        "category": "device",
        "size": { "height": 0.6 },
        "parts": [
            { "name": "body", "text": "body", "point": cabinet::in_file([0.4, 0.15, 0.3]) },
            lid("lid_1", -0.2),
            lid("lid_2", 0.2),
        ],
    });
    std::fs::write(folder.path().join("mine.json"), format!("{condition:#}\n")).unwrap();
    let named = ["photo.png", "--mesh", "cabinet.glb"];
    let files = ["--condition", "mine.json", "--state", "state"];
    Studio::start(folder, &[&named[..], &files].concat())
}

#[test]
fn an_answer_holds_for_both_lids_unless_a_person_says_otherwise() {
    for is_for_both in [true, false] {
        let studio = undecided_twice();
        let Some(mut page) = Page::open(&studio) else { return };
        let asked = page.text("#notice-question");
        assert!(asked.contains("How does lid_1 move?"), "{asked}");
        assert!(asked.contains("so for lid_2"), "{asked}");
        if !is_for_both {
            page.click("#notice-question input");
        }
        page.click("#notice-question button:not(.icon)");
        page.rest();
        assert!(studio.part("lid_1")["range"].is_array());
        let other = studio.part("lid_2");
        assert_eq!(other["range"].is_array(), is_for_both, "{other}");
        assert_eq!(page.browser.complaints(), Vec::<String>::new());
    }
}

#[test]
fn a_question_that_was_waved_away_stays_away() {
    let studio = undecided();
    let Some(mut page) = Page::open(&studio) else { return };
    page.click("#notice-question button.icon");
    page.browser.settle();
    assert!(!page.text("#notices").contains("How does door move?"));
    let before = studio.condition();
    page.fill("#object-category", "wardrobe");
    page.rest();
    assert_ne!(studio.condition(), before);
    assert!(!page.text("#notices").contains("How does door move?"));
}
