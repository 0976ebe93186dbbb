//! What xacro knows by name: macros with their parameters, and properties in their scopes.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::value::Value;
use crate::read::element::Element;

/// A macro.
#[derive(Clone, Debug)]
pub(super) struct Macro {
    pub params: Vec<Param>,
    pub body: Arc<Element>,
}

/// A parameter of a macro.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Param {
    pub name: String,
    pub kind: Kind,
}

/// How a parameter is given.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// As an attribute, or else this text; `forward`: or first what stands around the call.
    Plain { default: Option<String>, forward: bool },
    /// As a child element.
    Block,
    /// As what stands in a child element.
    Inner,
}

/// What a name stands for.
#[derive(Clone, Debug)]
pub(super) enum Symbol {
    /// A text that is worked out when it is asked for.
    Lazy(String),
    /// A value.
    Known(Value),
    /// Elements.
    Block(Vec<Arc<Element>>),
}

/// A scope: the file's, or that of a call.
pub(super) type Frame = BTreeMap<String, Symbol>;

/// The parameters of `params="a b:=1 *block **inner c:=^ d:=^|2"`. Blanks within quotes and braces
/// part nothing.
pub(super) fn params(text: &str) -> Vec<Param> {
    let (mut words, mut word, mut quote, mut depth) = (Vec::new(), String::new(), None, 0_usize);
    for c in text.chars() {
        match (quote, c) {
            (None, '\'' | '"') => quote = Some(c),
            (Some(open), c) if open == c => quote = None,
            (None, '{' | '(') => depth += 1,
            (None, '}' | ')') => depth = depth.saturating_sub(1),
            _ => {}
        }
        if c.is_whitespace() && quote.is_none() && depth == 0 {
            words.extend((!word.is_empty()).then(|| std::mem::take(&mut word)));
        } else {
            word.push(c);
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    words.iter().map(|word| param(word)).collect()
}

fn param(word: &str) -> Param {
    if let Some(name) = word.strip_prefix("**") {
        return Param { name: name.to_owned(), kind: Kind::Inner };
    }
    if let Some(name) = word.strip_prefix('*') {
        return Param { name: name.to_owned(), kind: Kind::Block };
    }
    let (name, default) = match word.split_once(":=").or_else(|| word.split_once('=')) {
        Some((name, default)) => (name, Some(default)),
        None => (word, None),
    };
    let (forward, default) = match default {
        Some("^") => (true, None),
        Some(text) => match text.strip_prefix("^|") {
            Some(default) => (true, Some(default)),
            None => (false, Some(text)),
        },
        None => (false, None),
    };
    let plain = |text: &str| {
        let quoted =
            text.len() >= 2 && text.starts_with(['\'', '"']) && text.ends_with(['\'', '"']);
        if quoted { text[1..text.len() - 1].to_owned() } else { text.to_owned() }
    };
    let kind = Kind::Plain { default: default.map(plain), forward };
    Param { name: name.trim_end_matches(':').to_owned(), kind }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_defaults_and_blocks() {
        let plain = |default: Option<&str>, forward| Kind::Plain {
            default: default.map(str::to_owned),
            forward,
        };
        let found = params("a b:=1 c:='0 0 1' *d **e f:=^ g:=^|2 h:=${x + 1}");
        let names: Vec<_> = found.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c", "d", "e", "f", "g", "h"]);
        let kinds: Vec<_> = found.into_iter().map(|p| p.kind).collect();
        let due = [
            plain(None, false),
            plain(Some("1"), false),
            plain(Some("0 0 1"), false),
            Kind::Block,
            Kind::Inner,
            plain(None, true),
            plain(Some("2"), true),
            plain(Some("${x + 1}"), false),
        ];
        assert_eq!(kinds, due);
    }
}
