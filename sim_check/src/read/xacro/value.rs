//! Values of xacro's expressions.

/// What an expression comes to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// A truth.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// A number.
    Float(f64),
    /// A text.
    Text(String),
    /// Values in a row.
    List(Vec<Value>),
}

impl Value {
    /// What a text stands for: a number or a truth where it reads as one.
    pub(crate) fn of(text: &str) -> Self {
        let plain = text.trim();
        if let Ok(whole) = plain.parse::<i64>() {
            return Self::Int(whole);
        }
        let is_number = plain.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        match plain {
            "true" | "True" => Self::Bool(true),
            "false" | "False" => Self::Bool(false),
            _ => match plain.parse::<f64>() {
                Ok(number) if is_number => Self::Float(number),
                _ => Self::Text(text.to_owned()),
            },
        }
    }

    /// As Python writes it.
    pub(crate) fn shown(&self) -> String {
        match self {
            Self::Bool(true) => "True".into(),
            Self::Bool(false) => "False".into(),
            Self::Int(whole) => whole.to_string(),
            Self::Float(number) => format!("{number:?}"),
            Self::Text(text) => text.clone(),
            Self::List(all) => {
                format!("[{}]", all.iter().map(Self::shown).collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// As a number; a truth is 1 or 0.
    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            Self::Bool(b) => Some(f64::from(u8::from(*b))),
            Self::Int(whole) => Some(*whole as f64),
            Self::Float(number) => Some(*number),
            _ => None,
        }
    }

    /// Whether it counts as true: neither nought nor empty.
    pub(crate) fn is_true(&self) -> bool {
        match self {
            Self::Text(text) => !text.is_empty(),
            Self::List(all) => !all.is_empty(),
            other => other.number().is_some_and(|n| n != 0.0),
        }
    }

    /// What a condition of xacro's takes: a truth, a number, or the word for one.
    pub(crate) fn condition(&self) -> Option<bool> {
        match self {
            Self::Text(text) => match text.trim() {
                "" => None,
                text => match Self::of(text) {
                    Self::Text(_) => None,
                    other => Some(other.is_true()),
                },
            },
            other => Some(other.is_true()),
        }
    }
}
