//! `${…}` and `$(…)` in a text.

use super::expand::Machine;
use super::formula::work_out;
use super::macros::Symbol;
use super::value::Value;

/// Deepest chain of properties that name each other.
const DEEPEST: usize = 32;

impl Machine<'_> {
    /// A text with everything in it worked out; a text that is one expression keeps its kind.
    pub(super) fn value(&mut self, text: &str) -> Result<Value, String> {
        if !text.contains('$') {
            return Ok(Value::Text(text.to_owned()));
        }
        self.depth += 1;
        let made = if self.depth > DEEPEST {
            Err(format!("properties name each other at most {DEEPEST} deep"))
        } else {
            self.pieces(text)
        };
        self.depth -= 1;
        made
    }

    /// The same as a text.
    pub(super) fn text(&mut self, text: &str) -> Result<String, String> {
        self.value(text).map(|value| value.shown())
    }

    fn pieces(&mut self, text: &str) -> Result<Value, String> {
        let (mut whole, mut rest, mut only) = (String::new(), text, None);
        while let Some(at) = rest.find('$') {
            let (before, from) = rest.split_at(at);
            whole.push_str(before);
            // `$${` stands for `${` itself.
            let dollars = from.len() - from.trim_start_matches('$').len();
            let (open, close) = match from.as_bytes().get(dollars) {
                Some(b'{') => ('{', '}'),
                Some(b'(') => ('(', ')'),
                _ => {
                    whole.push_str(&from[..dollars]);
                    rest = &from[dollars..];
                    continue;
                }
            };
            if dollars > 1 {
                whole.extend(["$".repeat(dollars - 1).as_str(), &from[dollars..=dollars]]);
                rest = &from[dollars + 1..];
                continue;
            }
            let inner = &from[2..];
            let end =
                closing(inner, open, close).ok_or_else(|| format!("`{text}` does not end"))?;
            let value = match open {
                '{' => self.expression(&inner[..end])?,
                _ => self.command(&inner[..end])?,
            };
            rest = &inner[end + 1..];
            if whole.is_empty() && rest.is_empty() {
                only = Some(value);
            } else {
                whole.push_str(&value.shown());
            }
        }
        whole.push_str(rest);
        Ok(only.unwrap_or(Value::Text(whole)))
    }

    pub(super) fn expression(&mut self, text: &str) -> Result<Value, String> {
        let made = work_out(text, &mut |name| self.name(name));
        made.map_err(|why| format!("`{}`: {why}", crate::read::xml::shown(text.trim())))
    }

    /// What a name stands for, where it is asked for: a text that reads as a number is one.
    pub(super) fn name(&mut self, name: &str) -> Result<Value, String> {
        let found = self.frames.iter().rev().find_map(|frame| frame.get(name)).cloned();
        match found {
            Some(Symbol::Known(Value::Text(text))) => Ok(Value::of(&text)),
            Some(Symbol::Known(value)) => Ok(value),
            Some(Symbol::Lazy(text)) => match self.value(&text)? {
                Value::Text(text) => Ok(Value::of(&text)),
                value => Ok(value),
            },
            Some(Symbol::Block(_)) => Err(format!("`{name}` is a block of elements, no value")),
            None => Err(format!("`{name}` is not known")),
        }
    }

    fn command(&mut self, text: &str) -> Result<Value, String> {
        let text = self.text(text)?;
        let (command, rest) = text.trim().split_once(char::is_whitespace).unwrap_or((&text, ""));
        let rest = rest.trim();
        let (first, default) = match rest.split_once(char::is_whitespace) {
            Some((first, default)) => (first, default.trim()),
            None => (rest, ""),
        };
        let env = |machine: &Self, name: &str| machine.shelf.places().env.get(name).cloned();
        match command.trim() {
            "arg" => match self.args.get(rest) {
                Some(value) => Ok(Value::Text(value.clone())),
                None => Err(format!("the argument `{rest}` has no value")),
            },
            "find" => Ok(Value::Text(format!("package://{rest}"))),
            "env" => match env(self, rest) {
                Some(value) => Ok(Value::Text(value)),
                None => Err(format!("`$(env {rest})` was given no value (--env {rest}=…)")),
            },
            "optenv" => Ok(Value::Text(env(self, first).unwrap_or_else(|| default.to_owned()))),
            "eval" => self.expression(rest),
            "dirname" | "cwd" => Ok(Value::Text(".".into())),
            other => Err(format!("`$({other} …)` is not known")),
        }
    }
}

/// Where what was opened closes again, quotes passed over.
fn closing(text: &str, open: char, close: char) -> Option<usize> {
    let (mut depth, mut quote) = (0, None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(q), c) if q == c => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, c) if c == open => depth += 1,
            (None, c) if c == close && depth == 0 => return Some(at),
            (None, c) if c == close => depth -= 1,
            _ => {}
        }
    }
    None
}
