//! Words in markup.

/// Text as it may stand in a page: no markup, and nothing that turns the direction of writing.
pub(super) fn escaped(text: &str) -> String {
    guard::text::markup(&guard::text::shown(text)).into_owned()
}
