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
pub static SCRIPT: LazyLock<String> = LazyLock::new(script);

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        /// The modules, each behind those that it takes from.
        const MODULES: &[(&str, &str)] = &[$(($name, include_str!(concat!("web/", $name)))),*];
    };
}

modules!(
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
    "keys.js",
    "main.js",
);

fn script() -> String {
    let mut all = String::from("\"use strict\";\n(() => {\n");
    for (_, text) in MODULES {
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

    #[test]
    fn modules_take_only_what_earlier_ones_give() {
        let mut known: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (name, text) in MODULES {
            for line in text.lines().filter(|l| l.starts_with("import ")) {
                let (taken, from) = line.split_once(" from \"./").unwrap();
                let from = from.strip_suffix("\";").unwrap();
                let given = known.get(from).unwrap_or_else(|| panic!("{name}: {from} comes later"));
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
        let mut known = BTreeMap::new();
        for (name, text) in MODULES {
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
        assert!(
            !SCRIPT.contains("</script") && !SCRIPT.contains("<!--") && !STYLE.contains("</style")
        );
    }
}
