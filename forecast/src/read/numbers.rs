//! Numbers in attributes.

use crate::read::error::Reason;
use crate::read::tree::Element;

/// Most characters of a value that an error repeats; a guess.
const SHOWN: usize = 60;

/// The `N` numbers of an attribute; `None` where it is missing.
///
/// # Errors
/// [`Reason::Number`] when they are not `N` finite numbers.
pub(crate) fn numbers<const N: usize>(
    of: &Element,
    attribute: &'static str,
) -> Result<Option<[f64; N]>, Reason> {
    let Some(text) = of.get(attribute) else { return Ok(None) };
    let broken = || Reason::Number {
        line: of.line,
        attribute,
        found: text.chars().take(SHOWN).collect(),
        expected: N,
    };
    let mut made = [0.0; N];
    let mut words = text.split_whitespace();
    for slot in &mut made {
        let number = words.next().and_then(|w| w.parse::<f64>().ok()).filter(|x| x.is_finite());
        *slot = number.ok_or_else(broken)?;
    }
    if words.next().is_some() {
        return Err(broken());
    }
    Ok(Some(made))
}

/// The one number of an attribute.
///
/// # Errors
/// [`Reason::Number`].
pub(crate) fn number(of: &Element, attribute: &'static str) -> Result<Option<f64>, Reason> {
    Ok(numbers::<1>(of, attribute)?.map(|[x]| x))
}
