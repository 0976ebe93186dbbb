//! Words in markup.

/// Text as it may stand in a page: no markup, and nothing that turns the direction of writing.
pub(super) fn escaped(text: &str) -> String {
    guard::text::markup(&guard::text::shown(text)).into_owned()
}

/// Markup as a link to an address, where there is one. The address is one of plain letters.
pub(super) fn linked(markup: &str, address: Option<&str>) -> String {
    match address {
        Some(address) => format!("<a href=\"{}\">{markup}</a>", escaped(address)),
        None => markup.to_owned(),
    }
}

/// A card with a title.
pub(super) fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{body}\n</section>\n")
}

/// That there is more than is shown; nothing if there is not.
pub(super) fn more(all: usize, shown: usize, what: &str) -> String {
    let left = all.saturating_sub(shown);
    if left == 0 { String::new() } else { format!("<p class=dim>and {left} more {what}</p>") }
}
