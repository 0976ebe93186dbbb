//! A small XML writer: indented elements with escaped attributes.

use glamx::DVec3;

/// XML text being written.
#[derive(Debug)]
pub(crate) struct Xml {
    text: String,
    open: Vec<&'static str>,
}

impl Xml {
    /// An empty document.
    pub(crate) fn new() -> Self {
        Self { text: "<?xml version=\"1.0\"?>\n".into(), open: Vec::new() }
    }

    /// An element with children: `content` writes them.
    pub(crate) fn element(
        &mut self,
        name: &'static str,
        attributes: &[(&str, &str)],
        content: impl FnOnce(&mut Self),
    ) {
        self.tag(name, attributes, ">\n");
        self.open.push(name);
        content(self);
        self.open.pop();
        self.indent();
        self.text.push_str(&format!("</{name}>\n"));
    }

    /// An element without children.
    pub(crate) fn empty(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.tag(name, attributes, "/>\n");
    }

    /// An element with a text on one line.
    pub(crate) fn text(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) {
        let end = format!(">{}</{name}>\n", escaped(text));
        self.tag(name, attributes, &end);
    }

    /// The text written.
    pub(crate) fn finish(self) -> String {
        self.text
    }

    fn indent(&mut self) {
        self.open.iter().for_each(|_| self.text.push_str("  "));
    }

    fn tag(&mut self, name: &str, attributes: &[(&str, &str)], end: &str) {
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        for (key, value) in attributes {
            self.text.push_str(&format!(" {key}=\"{}\"", escaped(value)));
        }
        self.text.push_str(end);
    }
}

/// An attribute's value: blanks for line breaks and tabs, no other control characters.
fn escaped(value: &str) -> String {
    let blank = |c| if matches!(c, '\t' | '\n' | '\r') { ' ' } else { c };
    let line: String = value.chars().map(blank).filter(|&c| u32::from(c) >= 0x20).collect();
    guard::text::markup(&line).into_owned()
}

/// A number as plain decimals that read back to the same bits, never with an exponent, and without
/// the noise below 1e-15.
pub(crate) fn number(x: f64) -> String {
    if x.abs() < 1e-15 { "0".into() } else { format!("{x}") }
}

/// Three numbers with blanks between.
pub(crate) fn numbers(v: DVec3) -> String {
    format!("{} {} {}", number(v.x), number(v.y), number(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_exponent_and_read_back_exactly() {
        for x in [1e-7, -2.5e-12, 0.1 + 0.2, 1e20, 1.0 / 3.0] {
            let text = number(x);
            assert!(!text.contains('e') && text.parse::<f64>().unwrap() == x, "{text}");
        }
        assert_eq!(numbers(DVec3::new(-0.0, 1e-17, 2.0)), "0 0 2");
    }

    #[test]
    fn attributes_are_escaped_and_elements_nest() {
        let mut xml = Xml::new();
        xml.element("a", &[("t", "x<\"&\n>")], |xml| xml.empty("b", &[]));
        let expected = "<a t=\"x&lt;&quot;&amp; &gt;\">\n  <b/>\n</a>\n";
        assert_eq!(xml.finish(), format!("<?xml version=\"1.0\"?>\n{expected}"));
    }
}
