//! What providers' licences allow, and the policy that refuses before anything is spent.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What a result is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// For money.
    Commercial,
    /// In the European Union.
    Eu,
    /// In the United Kingdom.
    Uk,
    /// In South Korea.
    Kr,
}

impl Purpose {
    const ALL: [Self; 4] = [Self::Commercial, Self::Eu, Self::Uk, Self::Kr];

    /// Its word in a policy.
    pub fn name(self) -> &'static str {
        match self {
            Self::Commercial => "commercial",
            Self::Eu => "eu",
            Self::Uk => "uk",
            Self::Kr => "kr",
        }
    }
}

/// What results are meant for: words of [`Purpose`] joined by `-`, or `any` for nothing in particular.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Policy(pub BTreeSet<Purpose>);

impl FromStr for Policy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "any" {
            return Ok(Self::default());
        }
        let purpose = |word: &str| {
            let known = Purpose::ALL.into_iter().find(|p| p.name() == word);
            let expected = || {
                format!(
                    "expected `any`, or words of commercial, eu, uk and kr with - between, found `{word}`"
                )
            };
            known.ok_or_else(expected)
        };
        text.split('-').map(purpose).collect::<Result<_, _>>().map(Self)
    }
}

impl fmt::Display for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<_> = self.0.iter().map(|p| p.name()).collect();
        f.write_str(if words.is_empty() { "any".to_owned() } else { words.join("-") }.as_str())
    }
}

/// What is known of a provider's licence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Terms {
    /// Its name.
    pub licence: &'static str,
    /// What it is known to allow.
    pub allows: &'static [Purpose],
    /// What it is known to forbid.
    pub forbids: &'static [Purpose],
    /// What else should be known of it.
    pub note: &'static str,
}

const EVERYTHING: &[Purpose] = &Purpose::ALL;

/// Nobody has told what it allows: the user's contract, or the user's own program.
pub const OF_YOUR_ACCOUNT: Terms = Terms {
    licence: "the contract of your account",
    allows: &[],
    forbids: &[],
    note: "say what it allows with `allowed = [...]`",
};

/// A program or a model server of the user's own, whose licence nobody has told.
pub const UNTOLD: Terms = Terms { licence: "not told", ..OF_YOUR_ACCOUNT };

/// Tencent Cloud's hosted Hunyuan3D.
pub const TENCENT_CLOUD: Terms = Terms {
    note: "the community licence of the open weights is not it; say what it allows with `allowed = [...]`",
    ..OF_YOUR_ACCOUNT
};

/// Tencent's community licence (Hunyuan3D-2, 2.1).
pub const TENCENT_COMMUNITY: Terms = Terms {
    licence: "Tencent Hunyuan community licence",
    allows: &[Purpose::Commercial],
    forbids: &[Purpose::Eu, Purpose::Uk, Purpose::Kr],
    note: "outputs included; above a million monthly users another licence is needed",
};

/// TRELLIS and TRELLIS.2.
pub const MIT: Terms = Terms {
    licence: "MIT",
    allows: EVERYTHING,
    forbids: &[],
    note: "some of its dependencies (nvdiffrast) have licences of their own",
};

/// Stability's community licence (SF3D, SPAR3D).
pub const STABILITY_COMMUNITY: Terms = Terms {
    licence: "Stability AI community licence",
    allows: EVERYTHING,
    forbids: &[],
    note: "below a million dollars of revenue a year, after registration",
};

impl Terms {
    /// Whether a policy and these terms go together; `declared` is what the user's own contract
    /// allows besides. What is not known to be allowed is not.
    ///
    /// # Errors
    /// What is forbidden or not known, in words.
    pub fn permit(&self, policy: &Policy, declared: &[Purpose]) -> Result<(), String> {
        for purpose in &policy.0 {
            let (licence, word) = (self.licence, purpose.name());
            if declared.contains(purpose) {
                continue;
            }
            if self.forbids.contains(purpose) {
                return Err(format!("{licence} forbids `{word}`"));
            }
            if !self.allows.contains(purpose) {
                return Err(format!("nobody has said that {licence} allows `{word}`"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn policy(text: &str) -> Policy {
        text.parse().unwrap()
    }

    #[test]
    fn a_policy_is_read_by_its_words() {
        assert_eq!(policy("commercial-eu").0, [Purpose::Commercial, Purpose::Eu].into());
        assert_eq!(policy("eu-commercial").to_string(), "commercial-eu");
        assert_eq!(policy("any"), Policy::default());
        assert!("commercial-mars".parse::<Policy>().unwrap_err().contains("found `mars`"));
    }

    #[test]
    fn what_is_forbidden_or_unknown_is_refused_and_what_is_declared_is_not() {
        let refused = |terms: &Terms, text: &str| terms.permit(&policy(text), &[]).unwrap_err();
        let told = refused(&TENCENT_COMMUNITY, "commercial-eu");
        assert_eq!(told, "Tencent Hunyuan community licence forbids `eu`");
        TENCENT_COMMUNITY.permit(&policy("commercial"), &[]).unwrap();
        assert!(refused(&OF_YOUR_ACCOUNT, "eu").starts_with("nobody has said"));
        OF_YOUR_ACCOUNT.permit(&policy("eu"), &[Purpose::Eu]).unwrap();
        MIT.permit(&policy("commercial-eu-uk-kr"), &[]).unwrap();
        UNTOLD.permit(&policy("any"), &[]).unwrap();
    }
}
