//! Arguments read from their words; whoever gets one wrong is told the rule and what was found.

use std::error::Error;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use object::mesh::UpAxis;
use sim_check::Tier;
use sim_check::profile::RULES;

use crate::batch::plan::Share;
use crate::mutate::kinds;

/// Words that an argument may be, each with what `--help` says of it.
pub(super) type Words = &'static [(&'static str, &'static str)];

/// One of these words, as the library reads it: `--help` lists them, and another is refused with them.
pub(super) fn one_of<T>(words: Words) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: Error + Send + Sync + 'static> + Clone + Send + Sync + 'static,
{
    let listed = words.iter().map(|&(word, meaning)| PossibleValue::new(word).help(meaning));
    PossibleValuesParser::new(listed).try_map(|word| word.parse::<T>())
}

/// A tier by its name.
pub(super) fn tier(text: &str) -> Result<Tier, String> {
    let known = || Tier::ALL.into_iter().skip(1);
    known().find(|t| t.name() == text).ok_or_else(|| {
        let names: Vec<_> = known().map(Tier::name).collect();
        format!("expected one of {}, found `{text}`", names.join(", "))
    })
}

/// The id of a rule of the profile, in either case.
pub(super) fn rule(text: &str) -> Result<String, String> {
    let id = text.trim().to_ascii_uppercase();
    if RULES.iter().any(|r| r.id == id) {
        return Ok(id);
    }
    let ids: Vec<_> = RULES.iter().map(|r| r.id).collect();
    Err(format!("expected the id of a check, found `{text}`; there are {}", ids.join(" ")))
}

/// The id of a kind of planted defects.
pub(super) fn planted(text: &str) -> Result<String, String> {
    match kinds::known(text.trim()) {
        Some(kind) => Ok(kind.id.to_owned()),
        None => Err(format!(
            "expected a kind of defect, found `{text}`; `kinfold mutate --list` names them"
        )),
    }
}

/// `ID=REASON`: a check that may fail, and why.
pub(super) fn waiver(text: &str) -> Result<(String, String), String> {
    let (id, reason) = text.split_once('=').unwrap_or((text, ""));
    if !RULES.iter().any(|r| r.id == id) {
        let ids: Vec<_> = RULES.iter().map(|r| r.id).collect();
        return Err(format!(
            "expected the id of a check, found `{id}`; there are {}",
            ids.join(" ")
        ));
    }
    match reason.trim() {
        "" => Err(format!("expected a reason, as in {id}=\"why this may be\"")),
        reason => Ok((id.to_owned(), reason.to_owned())),
    }
}

fn two(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err(format!("expected a name, `=` and what it is, found `{text}`")),
    }
}

/// `NAME=VALUE`: an argument of a xacro.
pub(super) fn argument(text: &str) -> Result<(String, String), String> {
    two(text)
}

/// `NAME=DIR`: where a package lies.
pub(super) fn package(text: &str) -> Result<(String, PathBuf), String> {
    let (name, folder) = two(text)?;
    let folder = PathBuf::from(folder);
    match folder.is_dir() {
        true => Ok((name, folder)),
        false => Err(format!("expected the folder of package `{name}`, which is not there")),
    }
}

/// `NAME=VALUE`, or `NAME` for the value that this environment has.
pub(super) fn variable(text: &str) -> Result<(String, String), String> {
    if text.contains('=') {
        return two(text);
    }
    let value = std::env::var(text).map_err(|_| format!("the environment has no `{text}`"))?;
    Ok((text.to_owned(), value))
}

/// A number of at least 1.
pub(super) fn at_least_one(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|&n| n > 0);
    number.ok_or_else(|| format!("expected a number of at least 1, found `{text}`"))
}

/// A time above nothing, in seconds.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let number = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    let duration = number.and_then(|s| Duration::try_from_secs_f64(s).ok());
    duration.ok_or_else(|| format!("expected a number of seconds above 0, found `{text}`"))
}

/// A tier that a made asset can reach.
pub(super) fn made_tier(text: &str) -> Result<Tier, String> {
    match tier(text)? {
        Tier::Audited => Err("expected a tier up to dynamic: `kinfold audit` says the rest".into()),
        tier => Ok(tier),
    }
}

/// An up axis.
pub(super) fn up_axis(text: &str) -> Result<UpAxis, String> {
    match text {
        "y" | "Y" => Ok(UpAxis::Y),
        "z" | "Z" => Ok(UpAxis::Z),
        _ => Err(format!("expected y or z, found `{text}`")),
    }
}

/// `VIEW:X,Y`: a pixel of a view, from its top left corner.
pub(super) fn pixel(text: &str) -> Result<(String, [f64; 2]), String> {
    let read = || {
        let (view, pixel) = text.split_once(':')?;
        let (x, y) = pixel.split_once(',')?;
        let number = |word: &str| word.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        Some((view.to_owned(), [number(x)?, number(y)?]))
    };
    read().ok_or_else(|| format!("expected VIEW:X,Y like front:512,300, found `{text}`"))
}

/// An angle between faces, degrees.
pub(super) fn bend(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| (0.0..=180.0).contains(n));
    number.ok_or_else(|| format!("expected 0 to 180 degrees, found `{text}`"))
}

/// An amount of money, at least 0.
pub(super) fn amount(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| n.is_finite() && *n >= 0.0);
    number.ok_or_else(|| format!("expected an amount like 0.25, found `{text}`"))
}

/// How many times a second: a number above nothing.
pub(super) fn rate(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| format!("expected a number a second above 0, found `{text}`"))
}

/// A probability, 0 to 1.
pub(super) fn probability(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| (0.0..=1.0).contains(n));
    number.ok_or_else(|| format!("expected a probability from 0 to 1, found `{text}`"))
}

/// `K/N`: a share of a manifest.
pub(super) fn share(text: &str) -> Result<Share, String> {
    let numbers =
        text.split_once('/').and_then(|(k, of)| Some((k.parse().ok()?, of.parse().ok()?)));
    let share = numbers.map(|(k, of)| Share { k, of }).filter(|s| s.k < s.of);
    share.ok_or_else(|| format!("expected K/N with K from 0 to N - 1, found `{text}`"))
}

/// An address that begins with `http://` or `https://`.
pub(super) fn url(text: &str) -> Result<String, String> {
    let rest = ["http://", "https://"].iter().find_map(|scheme| text.strip_prefix(scheme));
    match rest {
        Some(rest) if !rest.is_empty() && !rest.starts_with('/') => Ok(text.to_owned()),
        _ => Err(format!("expected an address like http://host:8080, found `{text}`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_waiver_names_a_check_and_a_reason() {
        assert_eq!(waiver("C1=a = b"), Ok(("C1".into(), "a = b".into())));
        assert!(waiver("C9=why").unwrap_err().contains("found `C9`; there are F1 F2"));
        assert!(waiver("C1").unwrap_err().contains("C1=\"why this may be\""));
        assert!(waiver("C1= ").is_err());
    }

    #[test]
    fn a_deadline_is_a_time_above_nothing() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        assert!(["0", "-1", "nan", "1e300", "soon"].iter().all(|t| seconds(t).is_err()));
    }

    #[test]
    fn a_tier_is_read_by_its_name() {
        assert_eq!(tier("dynamic"), Ok(Tier::Dynamic));
        assert!(tier("great").unwrap_err().contains("parse, static, kinematic, dynamic, audited"));
    }

    #[test]
    fn an_address_of_restate_is_http() {
        assert!(url("http://127.0.0.1:8080").is_ok() && url("https://restate").is_ok());
        for text in ["127.0.0.1:8080", "http://", "http:///x", "ftp://x"] {
            assert!(url(text).unwrap_err().contains("expected an address like"), "{text}");
        }
    }
}
