//! The sources of the page, which a browser could load as they are: plain modules and a style.
//!
//! Here they become one script. A module names what it takes by `import` lines, one a line, and what
//! it gives by `export`; both words go, and the modules stand one behind the other, needed ones first.

use std::sync::LazyLock;

/// The frame that everything else is put into.
pub(crate) const FRAME: &str = include_str!("web/page.html");
/// How it looks.
pub const STYLE: &str = include_str!("web/page.css");
/// The whole script.
pub static SCRIPT: LazyLock<String> = LazyLock::new(|| script(MODULES));

/// The frame of the studio.
pub(crate) const STUDIO_FRAME: &str = include_str!("web/studio/studio.html");
/// How the studio looks: as the page, and what is its own.
pub(crate) const STUDIO_STYLE: &str =
    concat!(include_str!("web/page.css"), include_str!("web/studio/studio.css"));
/// The studio's whole script.
pub(crate) static STUDIO_SCRIPT: LazyLock<String> = LazyLock::new(|| script(STUDIO));

/// A module: its name and its text.
type Module = (&'static str, &'static str);

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("web/", $name)))),*]
    };
}

/// The modules of the page, each behind those that it takes from.
const MODULES: &[Module] = modules!(
    "maths.js",
    "decode.js",
    "surface.js",
    "shapes.js",
    "model.js",
    "camera.js",
    "gl.js",
    "shaders.js",
    "render.js",
    "marks.js",
    "view.js",
    "dom.js",
    "labels.js",
    "joints.js",
    "findings.js",
    "parts.js",
    "tools.js",
    "overview.js",
    "keys.js",
    "main.js",
);

/// The modules of the studio: those of the page but its last, and its own.
const STUDIO: &[Module] = modules!(
    "maths.js",
    "decode.js",
    "surface.js",
    "shapes.js",
    "model.js",
    "camera.js",
    "gl.js",
    "shaders.js",
    "render.js",
    "marks.js",
    "view.js",
    "dom.js",
    "labels.js",
    "joints.js",
    "findings.js",
    "parts.js",
    "tools.js",
    "overview.js",
    "keys.js",
    "studio/text.js",
    "studio/store.js",
    "studio/edits.js",
    "studio/api.js",
    "studio/keeper.js",
    "studio/bvh.js",
    "studio/body.js",
    "studio/geometry.js",
    "studio/rig.js",
    "studio/bench.js",
    "studio/desk.js",
    "studio/floats.js",
    "studio/question.js",
    "studio/pins.js",
    "studio/snaps.js",
    "studio/handles.js",
    "studio/fields.js",
    "studio/side.js",
    "studio/jointcard.js",
    "studio/panel.js",
    "studio/notices.js",
    "studio/photo.js",
    "studio/hands.js",
    "studio/build.js",
    "studio/first.js",
    "studio/bar.js",
    "studio/begin.js",
);

fn script(modules: &[Module]) -> String {
    let mut all = String::from("\"use strict\";\n(() => {\n");
    for (_, text) in modules {
        for line in text.lines().filter(|l| !l.starts_with("import ")) {
            all.push_str(line.strip_prefix("export ").unwrap_or(line));
            all.push('\n');
        }
    }
    all + "})();\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    const WORDS: [&str; 5] = ["async function ", "function ", "class ", "const ", "let "];

    /// The name that a line of a module declares for all of it.
    fn declared(line: &str) -> Option<&str> {
        let rest = WORDS.iter().find_map(|w| line.strip_prefix(w))?;
        rest.split(|c: char| !c.is_alphanumeric() && c != '_' && c != '$').next()
    }

    /// The name of a module that another one takes from.
    fn resolved(name: &str, from: &str) -> String {
        match (from.strip_prefix("../"), name.split_once('/')) {
            (Some(above), Some(_)) => above.to_owned(),
            (None, Some((folder, _))) => format!("{folder}/{}", from.strip_prefix("./").unwrap()),
            (_, None) => from.strip_prefix("./").unwrap().to_owned(),
        }
    }

    #[test]
    fn modules_take_only_what_earlier_ones_give() {
        [MODULES, STUDIO].into_iter().for_each(takes_what_is_given);
    }

    fn takes_what_is_given(modules: &[Module]) {
        let mut known: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (name, text) in modules {
            for line in text.lines().filter(|l| l.starts_with("import ")) {
                let (taken, from) = line.split_once(" from \"").unwrap();
                let from = &resolved(name, from.strip_suffix("\";").unwrap());
                let given = known
                    .get(from.as_str())
                    .unwrap_or_else(|| panic!("{name}: {from} comes later"));
                let taken = taken.trim_start_matches("import {").trim_end_matches('}').split(',');
                for taken in taken.map(str::trim).filter(|t| !t.is_empty()) {
                    assert!(given.contains(&taken), "{name}: {from} gives no {taken}");
                }
            }
            let given = text.lines().filter_map(|l| declared(l.strip_prefix("export ")?));
            known.insert(name, given.collect());
        }
    }

    /// One scope holds them all.
    #[test]
    fn no_two_modules_declare_one_name() {
        [MODULES, STUDIO].into_iter().for_each(declares_once);
    }

    fn declares_once(modules: &[Module]) {
        let mut known = BTreeMap::new();
        for (name, text) in modules {
            for line in text.lines() {
                let Some(word) = declared(line.strip_prefix("export ").unwrap_or(line)) else {
                    continue;
                };
                let before = known.insert(word.to_owned(), name).filter(|_| !word.is_empty());
                assert!(before.is_none(), "{word}: {before:?} and {name}");
            }
        }
    }

    #[test]
    fn the_script_cannot_end_its_element() {
        for (script, style) in [(&*SCRIPT, STYLE), (&*STUDIO_SCRIPT, STUDIO_STYLE)] {
            assert!(!script.contains("</script") && !script.contains("<!--"));
            assert!(!style.contains("</style"));
        }
    }

    /// The studio has all that the page has, but the module that begins it.
    #[test]
    fn the_studio_is_built_of_the_page() {
        let own = STUDIO.iter().position(|(name, _)| name.starts_with("studio/")).unwrap();
        assert_eq!(&STUDIO[..own], &MODULES[..MODULES.len() - 1]);
    }
}
