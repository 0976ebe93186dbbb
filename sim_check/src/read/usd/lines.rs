//! Where in a USD text each prim begins. Binary layers have no lines: all stands on the first.

use std::collections::BTreeMap;

/// Most bytes of a line that is looked at: longer ones hold the points of a mesh.
const LOOKED_AT: usize = 512;

/// Lines by path.
#[derive(Default)]
pub(super) struct Lines(BTreeMap<String, u32>);

impl Lines {
    pub(super) fn of(bytes: &[u8]) -> Self {
        let mut found = BTreeMap::new();
        if !bytes.starts_with(b"#usda") {
            return Self(found);
        }
        // The path of what is open, and how many braces were open before it was.
        let (mut open, mut depth): (Vec<(String, usize)>, usize) = (Vec::new(), 0);
        // Braces of metadata stand in round ones.
        let mut round = 0usize;
        let mut named: Option<String> = None;
        for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
            if line.len() > LOOKED_AT {
                continue;
            }
            let text = String::from_utf8_lossy(line);
            let text = text.trim_start();
            let is_prim = ["def ", "over ", "class "].iter().any(|word| text.starts_with(word));
            if let Some(name) = text.split('"').nth(1).filter(|_| is_prim) {
                let above = open.last().map_or("", |(path, _)| path.as_str());
                let path = format!("{above}/{name}");
                found.entry(path.clone()).or_insert(number as u32 + 1);
                named = Some(path);
            }
            let mut is_quoted = false;
            for c in text.chars() {
                match c {
                    '#' if !is_quoted => break,
                    '"' => is_quoted = !is_quoted,
                    '(' if !is_quoted => round += 1,
                    ')' if !is_quoted => round = round.saturating_sub(1),
                    '{' if !is_quoted && round == 0 => {
                        if let Some(path) = named.take() {
                            open.push((path, depth));
                        }
                        depth += 1;
                    }
                    '}' if !is_quoted && round == 0 => {
                        depth = depth.saturating_sub(1);
                        if open.last().is_some_and(|(_, before)| *before == depth) {
                            open.pop();
                        }
                    }
                    _ => {}
                }
            }
        }
        Self(found)
    }

    /// The line of a prim, or of the nearest above it that stands in the file.
    pub(super) fn of_path(&self, path: &str) -> u32 {
        let mut at = path;
        while !at.is_empty() {
            if let Some(line) = self.0.get(at) {
                return *line;
            }
            at = at.rsplit_once('/').map_or("", |(above, _)| above);
        }
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prims_are_found_past_metadata_dictionaries_and_variants() {
        let text = b"#usda 1.0\n(\n    doc = \"a { brace\"\n)\n\ndef Xform \"a\" (\n    variants = {\n        string s = \"x\"\n    }\n)\n{\n    def Mesh \"b\" {\n    }\n    over \"c\" { def \"d\" {} }\n}\ndef \"e\" {}\n";
        let lines = Lines::of(text);
        let of = |path: &str| lines.of_path(path);
        assert_eq!([of("/a"), of("/a/b"), of("/a/c"), of("/e")], [6, 12, 14, 16]);
        assert_eq!((of("/a/b/in/another/file"), of("/nowhere")), (12, 1));
        assert_eq!(Lines::of(b"PXR-USDC").of_path("/a"), 1);
    }
}
