//! Identifiers made of words.

use crate::kinematics::is_safe_name;

/// Identifier made of a text: lower case, everything else an underscore, unique by a suffix.
pub fn name_from_text(text: &str, taken: &[String]) -> String {
    let mut name = String::new();
    for c in text.trim().chars().map(|c| c.to_ascii_lowercase()) {
        let plain = if c.is_ascii_alphanumeric() { c } else { '_' };
        if plain != '_' || !name.ends_with('_') {
            name.push(plain);
        }
    }
    let mut name = name.trim_matches('_').to_string();
    if !is_safe_name(&name) {
        name.insert_str(0, "part_");
    }
    let name = name.trim_end_matches('_').to_string();
    let numbered = (2..).map(|n| format!("{name}_{n}"));
    let mut candidates = std::iter::once(name.clone()).chain(numbered);
    candidates.find(|n| !taken.contains(n)).unwrap_or(name)
}
