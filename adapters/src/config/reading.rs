//! A configuration file read: refused by line and field, never by quoting what stands there.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::Config;
use super::amounts::senseless;
use crate::AdapterError;

/// Names of fields that hold keys, without `-`, `_` and capitals.
const KEY_FIELDS: [&str; 17] = [
    "accesskey",
    "accesstoken",
    "apikey",
    "apitoken",
    "auth",
    "authorization",
    "authtoken",
    "bearer",
    "credentials",
    "key",
    "passphrase",
    "passwd",
    "password",
    "secret",
    "secretid",
    "secretkey",
    "token",
];
/// Fields that go on to a service as they stand.
const FREE: [&str; 4] = ["calls", "data", "input", "workflow"];
/// How names of fields end that hold keys wherever they stand.
const KEY_ENDINGS: [&str; 5] = ["accesstoken", "apikey", "apitoken", "password", "secretkey"];
/// How keys of known services begin; source: the services' own pages and secret scanners' lists.
const KEY_BEGINNINGS: [&str; 16] = [
    "sk-",
    "sk_",
    "msy_",
    "msy-",
    "tsk_",
    "tcli_",
    "r8_",
    "hf_",
    "AKIA",
    "AKID",
    "AIza",
    "ghp_",
    "github_pat_",
    "xai-",
    "gsk_",
    "Bearer ",
];
/// Shortest value with such a beginning that is taken for a key, characters.
const KEY_LENGTH: usize = 16;
/// Longest name of a variable or field, characters, that is told.
const LONGEST_NAME: usize = 48;

/// The configuration a text is.
///
/// # Errors
/// [`AdapterError::Format`] or [`AdapterError::InlineKey`], naming the line and the field.
pub(super) fn read(name: &str, text: &str) -> Result<Config, AdapterError> {
    let broken = |e: &toml::de::Error| AdapterError::Format {
        path: name.to_owned(),
        expected: "a kinfold configuration",
        found: told(e, text),
    };
    let table = DeTable::parse(text).map_err(|e| broken(&e))?;
    if let Some((field, at)) = inline_key(table.get_ref(), false) {
        return Err(AdapterError::InlineKey {
            path: name.to_owned(),
            line: line(text, &at),
            field: sayable(&field).to_owned(),
        });
    }
    let config: Config = toml::from_str(text).map_err(|e| broken(&e))?;
    match senseless(&config) {
        Some(field) => Err(AdapterError::Format {
            path: name.to_owned(),
            expected: "amounts that are finite and not below zero",
            found: format!("another one, as `{field}`"),
        }),
        None => Ok(config),
    }
}

/// An error without what stands in the file but names of fields.
fn told(error: &toml::de::Error, text: &str) -> String {
    let message = unquoted(error.message().lines().next().unwrap_or_default());
    let field = message.split('`').nth(1).unwrap_or_default();
    let named = || {
        text.lines().position(|l| l.trim_start().starts_with(field)).filter(|_| !field.is_empty())
    };
    let line = error.span().map(|span| line(text, &span)).or_else(|| named().map(|n| n + 1));
    match line {
        Some(line) => format!("{message}, in line {line}"),
        None => message,
    }
}

/// A message without values: what stands between double quotes goes, and what stands between
/// backticks unless it is a short word.
fn unquoted(message: &str) -> String {
    let message = match (message.find('"'), message.rfind('"')) {
        (Some(first), Some(last)) if first < last => {
            format!("{}…{}", &message[..first], &message[last + 1..])
        }
        _ => message.to_owned(),
    };
    let pieces = message.split('`').enumerate();
    let told = pieces.map(|(n, piece)| if n % 2 == 0 { piece } else { sayable(piece) });
    told.collect::<Vec<_>>().join("`")
}

/// A name as it may be told: what could be a key is not.
fn sayable(name: &str) -> &str {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-.#".contains(c);
    let may = name.len() <= LONGEST_NAME && name.chars().all(plain) && !looks_like_a_key(name);
    if may { name } else { "…" }
}

/// The line, from one, that a span begins in.
fn line(text: &str, span: &Range<usize>) -> usize {
    text.bytes().take(span.start).filter(|b| *b == b'\n').count() + 1
}

/// The first field that holds a key, and where. What goes on to a service as it stands is `free`:
/// it has fields of names that we do not know.
fn inline_key(table: &DeTable<'_>, free: bool) -> Option<(String, Range<usize>)> {
    table.iter().find_map(|(name, value)| {
        let free = free || FREE.contains(&&**name.get_ref());
        let found = match value.get_ref() {
            DeValue::String(text) => holds_a_key(name.get_ref(), text, free),
            DeValue::Array(items) => {
                let mut tables = items.iter().filter_map(|item| item.get_ref().as_table());
                if let Some(found) = tables.find_map(|table| inline_key(table, free)) {
                    return Some(found);
                }
                let texts: Vec<_> =
                    items.iter().filter_map(|item| item.get_ref().as_str()).collect();
                texts.iter().any(|text| looks_like_a_key(text)) || key_by_flag(&texts)
            }
            DeValue::Table(inner) => return inline_key(inner, free),
            _ => false,
        };
        found.then(|| (name.get_ref().to_string(), name.span()))
    })
}

/// Whether a program's arguments give a key to a flag whose name says so: `--api-key KEY`, `--token=KEY`.
fn key_by_flag(arguments: &[&str]) -> bool {
    let is_key = |flag: &str| {
        let plain: String = flag.chars().filter(|c| !"-_".contains(*c)).collect();
        let plain = plain.to_ascii_lowercase();
        KEY_FIELDS.contains(&plain.as_str()) || KEY_ENDINGS.iter().any(|end| plain.ends_with(end))
    };
    let given = |value: &str| !value.is_empty() && !value.starts_with(['-', '{', '$']);
    arguments.iter().enumerate().any(|(at, argument)| {
        let Some(flag) = argument.strip_prefix('-') else { return false };
        match flag.split_once('=') {
            Some((flag, value)) => is_key(flag) && given(value),
            None => is_key(flag) && arguments.get(at + 1).is_some_and(|value| given(value)),
        }
    })
}

fn holds_a_key(name: &str, value: &str, free: bool) -> bool {
    let plain: String = name.chars().filter(|c| !"-_".contains(*c)).collect();
    let plain = plain.to_ascii_lowercase();
    let named = if free {
        KEY_ENDINGS.iter().any(|end| plain.ends_with(end))
    } else {
        KEY_FIELDS.contains(&plain.as_str()) || plain.ends_with("apikey")
    };
    let variable = name.ends_with("_env") && !free;
    (named && !value.is_empty()) || looks_like_a_key(value) || (variable && !is_variable(value))
}

/// Whether a text may be the name of a variable, and is no key by its looks.
fn is_variable(text: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let random = text.len() >= 24
        && text.contains(|c: char| c.is_ascii_lowercase())
        && text.contains(|c: char| c.is_ascii_digit());
    !text.is_empty() && text.len() <= LONGEST_NAME && text.chars().all(plain) && !random
}

fn looks_like_a_key(text: &str) -> bool {
    let key =
        |word: &str| word.len() >= KEY_LENGTH && KEY_BEGINNINGS.iter().any(|b| word.starts_with(b));
    key(text) || text.split(['=', ' ', ':', '/', '?', '&', '@']).any(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "sk-CANARY0123456789abcdef";

    fn error(text: &str) -> String {
        let error = read("kinfold.toml", text).unwrap_err();
        format!("{error} {error:?} {}", error.hint().unwrap_or_default())
    }

    #[test]
    fn a_key_in_the_file_is_refused_by_line_and_field_and_not_quoted() {
        let vlm = "[vlm]\nprovider = 'openai'\nmodel = 'm'\n";
        let fields =
            ["key", "api_key", "apiKey", "token", "OPENAI_API_KEY", "key_env", "model_", "base"];
        for field in fields {
            let told = error(&format!("{vlm}{field} = '{KEY}'\n"));
            assert!(told.contains("line 4") && told.contains(&format!("`{field}`")), "{told}");
            assert!(!told.contains("CANARY"), "{told}");
        }
        let others = [
            format!("key = 'short'\n{vlm}"),
            format!(
                "[image_to_3d]\nprovider = 'fal'\nmodel = 'm'\ninput = {{ api_key = '{KEY}' }}\n"
            ),
            format!(
                "[image_to_3d]\nprovider = 'command'\nprogram = 'p'\narguments = ['--key={KEY}']\n"
            ),
            format!("{vlm}base = 'https://h.example/v1?key={KEY}'\n"),
            format!("{vlm}key_env = 'CANARY of somebody'\n"),
            format!("{vlm}key_env = 'canary0123456789abcdef0123'\n"),
        ];
        for text in others {
            let told = error(&text);
            assert!(
                told.contains("line ") && !told.to_ascii_lowercase().contains("canary"),
                "{told}"
            );
        }
    }

    #[test]
    fn a_key_behind_a_flag_of_a_program_is_refused_and_a_variable_is_not() {
        let with = |arguments: &str| {
            let head = "[image_to_3d]\nprovider = 'command'\nprogram = 'p'\n";
            read("k", &format!("{head}arguments = [{arguments}]\n")).map_err(|e| e.to_string())
        };
        for key in [
            "'--api-key', 'zzTOPSECRETzz2'",
            "'--token=zzTOPSECRETzz2'",
            "'-p', '--my_password=zzTOPSECRETzz2'",
            "'--Secret', 'zzTOPSECRETzz2'",
        ] {
            let told = with(key).unwrap_err();
            assert!(told.contains("arguments") && !told.contains("TOPSECRET"), "{told}");
        }
        for fine in
            ["'--api-key', '$KEY'", "'--token', '--fast'", "'--tokens=4000'", "'{image}', '{mesh}'"]
        {
            assert!(with(fine).is_ok(), "{fine}");
        }
    }

    /// A budget that is not a number was one without limit.
    #[test]
    fn an_amount_that_is_no_amount_is_refused_by_field() {
        for (field, text) in [
            ("budget.money", "[budget]\nmoney = nan"),
            ("budget.money", "[budget]\nmoney = inf"),
            ("budget.credits", "[budget]\ncredits = -1.0"),
            ("budget.lost.money", "[budget]\nmoney = 1.0\nlost = { money = -5.0 }"),
            ("budget.lost.credits", "[budget]\nlost = { credits = nan }"),
            ("manners.vlm.price", "[manners.vlm]\nprice = { call = nan }"),
            (
                "manners.image_to_3d.price",
                "[manners.image_to_3d]\nprice = { million_input = -inf }",
            ),
        ] {
            let told = error(text);
            assert!(
                told.contains(&format!("`{field}`")) && told.contains("not below zero"),
                "{told}"
            );
        }
        assert!(read("k", "[budget]\nmoney = 0.0\n").is_ok());
    }

    #[test]
    fn no_error_quotes_a_line() {
        let vlm = "[vlm]\nprovider = 'openai'\n";
        let broken = [
            format!("{vlm}model = CANARY-secret\n"),
            format!("{vlm}model = 'CANARY-secret\n"),
            format!("{vlm}model = 'm'\npoints = 'CANARY secret, long and odd'\n"),
            "[vlm]\nprovider = \"CANARY \\\" secret\"\nmodel = 'm'\n".to_owned(),
            format!("{vlm}model = ['CANARY secret']\n"),
            "[budget]\ncalls = 'CANARY secret'\n".to_owned(),
            "CANARY secret\n".to_owned(),
            format!("{vlm}model = 'm'\n\"CANARY secret\" = 1\n"),
            "[image_to_3d]\nprovider = 'meshy'\nmodel = 'm'\nfaces = 'CANARY secret'\n".to_owned(),
        ];
        for text in broken {
            let told = error(&text);
            assert!(!told.contains("CANARY"), "{text}: {told}");
            assert!(told.contains("line ") || told.contains("expected"), "{told}");
        }
    }
}
