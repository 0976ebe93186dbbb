//! Words in markup.

/// Text as it may stand in a page: no markup, and nothing that turns the direction of writing.
pub(super) fn escaped(text: &str) -> String {
    let text = guard::text::shown(text);
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}
