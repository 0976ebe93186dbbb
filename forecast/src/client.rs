//! The clients that a forecast is made for.

use serde::Serialize;

/// A program that reads model files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Client {
    /// MuJoCo's own readers of URDF and MJCF.
    Mujoco,
    /// PyBullet's `loadURDF`.
    Pybullet,
    /// Drake's `Parser`.
    Drake,
    /// Newton's `add_urdf` and `add_usd`.
    Newton,
    /// Isaac Sim's URDF importer and its physics engine.
    Isaac,
    /// SAPIEN's URDF loader.
    Sapien,
    /// Genesis' `gs.morphs.URDF`.
    Genesis,
    /// Rerun's URDF reader.
    Rerun,
}

/// A word that names no client.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{found}` is no client: expected {}{}", names(), hint(.nearest))]
pub struct UnknownClient {
    /// What was asked for.
    pub found: String,
    /// The client whose name is nearest, if one is near.
    pub nearest: Option<Client>,
}

impl Client {
    /// All of them, in the order in which they are told.
    pub const ALL: [Self; 8] = [
        Self::Mujoco,
        Self::Pybullet,
        Self::Drake,
        Self::Newton,
        Self::Isaac,
        Self::Sapien,
        Self::Genesis,
        Self::Rerun,
    ];

    /// The word by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mujoco => "mujoco",
            Self::Pybullet => "pybullet",
            Self::Drake => "drake",
            Self::Newton => "newton",
            Self::Isaac => "isaac",
            Self::Sapien => "sapien",
            Self::Genesis => "genesis",
            Self::Rerun => "rerun",
        }
    }

    /// Its name as its makers write it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Mujoco => "MuJoCo",
            Self::Pybullet => "PyBullet",
            Self::Drake => "Drake",
            Self::Newton => "Newton",
            Self::Isaac => "Isaac Sim",
            Self::Sapien => "SAPIEN",
            Self::Genesis => "Genesis",
            Self::Rerun => "Rerun",
        }
    }

    /// The clients of a list such as `mujoco,drake`; `all` means every one. Each stands once, in the
    /// order of [`Client::ALL`].
    ///
    /// # Errors
    /// [`UnknownClient`], the first word that names none.
    pub fn list(text: &str) -> Result<Vec<Self>, UnknownClient> {
        let mut asked = Vec::new();
        for word in text.split(',').map(str::trim).filter(|w| !w.is_empty()) {
            if word.eq_ignore_ascii_case("all") {
                asked.extend(Self::ALL);
            } else {
                asked.push(Self::named(word)?);
            }
        }
        if asked.is_empty() {
            return Err(UnknownClient { found: text.chars().take(SHOWN).collect(), nearest: None });
        }
        asked.sort();
        asked.dedup();
        Ok(asked)
    }

    fn named(word: &str) -> Result<Self, UnknownClient> {
        let lower: String = word.to_ascii_lowercase().chars().take(SHOWN).collect();
        if let Some(client) = Self::ALL.into_iter().find(|c| c.name() == lower) {
            return Ok(client);
        }
        let far = |c: &Self| strsim::damerau_levenshtein(c.name(), &lower);
        let nearest = Self::ALL.into_iter().min_by_key(far).filter(|c| far(c) <= NEAR);
        Err(UnknownClient { found: word.chars().take(SHOWN).collect(), nearest })
    }
}

/// Letters by which a word may differ from the name that is suggested; a guess.
const NEAR: usize = 3;
/// Most characters of a word that an error repeats; a guess.
const SHOWN: usize = 40;

fn names() -> String {
    let names: Vec<_> = Client::ALL.iter().map(|c| c.name()).collect();
    format!("{} or all", names.join(", "))
}

fn hint(nearest: &Option<Client>) -> String {
    nearest.map_or_else(String::new, |c| format!("; did you mean `{}`?", c.name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_sorted_and_names_each_client_once() {
        let two = [Client::Mujoco, Client::Rerun];
        assert_eq!(Client::list("rerun, mujoco,rerun"), Ok(two.to_vec()));
        assert_eq!(Client::list("ALL").map(|c| c.len()), Ok(8));
    }

    #[test]
    fn a_misspelt_client_gets_the_nearest_one() {
        let e = Client::list("mujocco").unwrap_err().to_string();
        assert!(e.ends_with("did you mean `mujoco`?"), "{e}");
        let e = Client::list("unity3d-and-more").unwrap_err().to_string();
        assert!(e.ends_with("rerun or all"), "{e}");
        assert!(Client::list(" , ").is_err());
    }
}
