//! What a condition file says, as plain JSON: for programs that change it.

use jsonc_parser::ast::Value as Read;
use jsonc_parser::{CollectOptions, CommentCollectionStrategy, ParseOptions, parse_to_ast};
use serde_json::{Map, Number, Value};

use super::fault::{ConditionError, Fault};

/// A condition file as plain JSON, whatever is wrong with what it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Plain {
    /// What it says: of a field that stands twice, the last.
    pub document: Value,
    /// Whether it has comments, which the document has not.
    pub has_comments: bool,
}

/// Reads a condition file as plain JSON.
///
/// ```
/// let plain = object::condition::plain("{ parts: [], /* later */ }")?;
/// assert_eq!(plain.document, serde_json::json!({ "parts": [] }));
/// assert!(plain.has_comments);
/// # Ok::<(), object::condition::ConditionError>(())
/// ```
///
/// # Errors
/// [`ConditionError`] with the line where it is no JSON, comments and commas aside.
pub fn plain(text: &str) -> Result<Plain, ConditionError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (value, has_comments) = parsed(text)?;
    Ok(Plain { document: document(&value), has_comments })
}

/// The JSON of a text without a byte-order mark, as conditions may be written, and whether comments stand
/// in it.
pub(super) fn parsed(text: &str) -> Result<(Read<'_>, bool), ConditionError> {
    let options = ParseOptions {
        allow_missing_commas: false,
        allow_hexadecimal_numbers: false,
        allow_non_finite_numbers: false,
        ..ParseOptions::default()
    };
    let collect = CollectOptions { comments: CommentCollectionStrategy::Separate, tokens: false };
    let parsed = parse_to_ast(text, &collect, &options).map_err(|e| {
        let (line, column) = (e.line_display(), e.column_display());
        let what = format!("not a condition: not JSON: {}, column {column}", e.kind());
        ConditionError::single(Fault::new(Some(line), what))
    })?;
    let has_comments = parsed.comments.is_some_and(|comments| !comments.is_empty());
    let value = parsed.value;
    let value = value.ok_or_else(|| ConditionError::one("not a condition: the file is empty"))?;
    Ok((value, has_comments))
}

fn document(value: &Read<'_>) -> Value {
    match value {
        Read::NullKeyword(_) => Value::Null,
        Read::BooleanLit(lit) => Value::Bool(lit.value),
        Read::StringLit(lit) => Value::String(lit.value.to_string()),
        // A number that JSON does not know stays what was written.
        Read::NumberLit(lit) => lit
            .value
            .parse::<Number>()
            .map_or_else(|_| Value::String(lit.value.to_string()), Value::Number),
        Read::Array(list) => Value::Array(list.elements.iter().map(document).collect()),
        Read::Object(object) => {
            let one = |p: &jsonc_parser::ast::ObjectProp<'_>| {
                (p.name.as_str().to_owned(), document(&p.value))
            };
            Value::Object(object.properties.iter().map(one).collect::<Map<_, _>>())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_wrong_with_a_condition_is_no_matter_here() {
        let text = "\u{feff}{ schema: 'kinfold-condition/9', \"parts\": [{\"name\": 7, \"point\": [1e-3, -0.5, 2]}], }";
        let expected = json!({
            "schema": "kinfold-condition/9",
            "parts": [{ "name": 7, "point": [1e-3, -0.5, 2] }],
        });
        assert_eq!(plain(text), Ok(Plain { document: expected, has_comments: false }));
    }

    #[test]
    fn comments_are_noticed_and_what_is_no_json_has_a_line() {
        assert!(plain("// mine\n{}").is_ok_and(|p| p.has_comments));
        assert_eq!(
            plain("{}\n{").map_err(|e| e.faults().next().and_then(|f| f.line)),
            Err(Some(2))
        );
        assert!(plain(" // nothing").is_err_and(|e| e.to_string().ends_with("the file is empty")));
    }
}
