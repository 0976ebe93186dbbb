//! Whether names and paths that a file says may be asked of its stage.
//!
//! The library asks no grammar of them, and looks for the parents of some that have none without end. Letters
//! and digits of any script count, as in USD 24 and later.

use super::error::UsdError;

/// Whether it is a property's name: words joined by colons.
pub(super) fn is_property(name: &str) -> bool {
    !name.is_empty() && name.split(':').all(is_word)
}

/// Whether it is the whole path of a prim, or of one of its properties.
pub(super) fn is_path(path: &str) -> bool {
    let Some(rest) = path.strip_prefix('/') else { return false };
    let (prims, property) = rest.split_once('.').map_or((rest, None), |(p, n)| (p, Some(n)));
    prims.split('/').all(is_word) && property.is_none_or(is_property)
}

/// Refuses what is neither.
pub(super) fn asked(prim: &str, is_sound: bool, found: &str) -> Result<(), UsdError> {
    if is_sound {
        return Ok(());
    }
    let rule = "names and paths are words of letters, digits and underscores";
    let found: String = found.chars().take(80).flat_map(char::escape_default).collect();
    let found = format!("`{found}`");
    Err(UsdError::Rule { prim: prim.into(), rule: rule.into(), found })
}

fn is_word(word: &str) -> bool {
    !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_words_and_paths_of_words_are_asked_for() {
        for sound in ["points", "primvars:st", "xformOp:translate:pivot", "größe_2"] {
            assert!(is_property(sound), "{sound}");
        }
        for broken in ["", "a b", "a.b", "a/b", ":a", "a::b", "a]", "a\n"] {
            assert!(!is_property(broken), "{broken:?}");
        }
        for sound in ["/World", "/World/mat.outputs:surface"] {
            assert!(is_path(sound), "{sound}");
        }
        for broken in ["", "/", "World", "/a//b", "/a.b.c", "/a{v=x}b", "../a", "/a/.b", "/a b"] {
            assert!(!is_path(broken), "{broken:?}");
        }
    }
}
