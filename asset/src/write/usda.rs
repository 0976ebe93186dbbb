//! A small writer of USD's text format: prims that nest, metadata, values.

use glamx::{DQuat, DVec3};

/// USD text being written.
#[derive(Debug)]
pub(crate) struct Usda {
    text: String,
    depth: usize,
}

impl Usda {
    /// A layer with the given metadata lines.
    pub(crate) fn new(metadata: &[String]) -> Self {
        let mut this = Self { text: "#usda 1.0\n".into(), depth: 0 };
        this.bracketed('(', ')', |usda| metadata.iter().for_each(|m| usda.line(m)));
        this
    }

    /// A prim: `kind` is its type, `metadata` the lines between the parentheses, `content` writes
    /// properties and children.
    pub(crate) fn prim(
        &mut self,
        kind: &str,
        name: &str,
        metadata: &[String],
        content: impl FnOnce(&mut Self),
    ) {
        self.spec(&format!("def {kind} \"{name}\""), metadata, content);
    }

    /// Opinions over a prim that another layer defines.
    pub(crate) fn over(
        &mut self,
        name: &str,
        metadata: &[String],
        content: impl FnOnce(&mut Self),
    ) {
        self.spec(&format!("over \"{name}\""), metadata, content);
    }

    fn spec(&mut self, head: &str, metadata: &[String], content: impl FnOnce(&mut Self)) {
        self.text.push('\n');
        self.line(head);
        if !metadata.is_empty() {
            self.bracketed('(', ')', |usda| metadata.iter().for_each(|m| usda.line(m)));
        }
        self.bracketed('{', '}', content);
    }

    /// One line: a property, say.
    pub(crate) fn line(&mut self, line: &str) {
        (0..self.depth).for_each(|_| self.text.push_str("    "));
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// A property with a value.
    pub(crate) fn set(&mut self, property: &str, value: &str) {
        self.line(&format!("{property} = {value}"));
    }

    /// A property of a surface with many values: one for each `vertex`, say.
    pub(crate) fn set_each(&mut self, property: &str, values: &str, interpolation: &str) {
        self.line(&format!("{property} = {values} ("));
        self.line(&format!("    interpolation = \"{interpolation}\""));
        self.line(")");
    }

    /// The text written.
    pub(crate) fn finish(self) -> String {
        self.text
    }

    fn bracketed(&mut self, open: char, close: char, content: impl FnOnce(&mut Self)) {
        self.line(&open.to_string());
        self.depth += 1;
        content(self);
        self.depth -= 1;
        self.line(&close.to_string());
    }
}

/// The metadata line that applies schemas.
pub(crate) fn schemas(names: &[&str]) -> String {
    format!("prepend apiSchemas = {}", tokens(names))
}

/// A list of tokens or strings.
pub(crate) fn tokens(names: &[&str]) -> String {
    format!("[{}]", names.iter().map(|n| quoted(n)).collect::<Vec<_>>().join(", "))
}

/// A string in quotes, on one line.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A number in single precision, which is what most attributes of USD hold.
pub(crate) fn float(x: f64) -> String {
    let x = x as f32;
    if x.abs() < 1e-15 { "0".into() } else { format!("{x}") }
}

/// Three numbers, single precision.
pub(crate) fn triple(v: DVec3) -> String {
    format!("({}, {}, {})", float(v.x), float(v.y), float(v.z))
}

/// A quaternion as USD writes it, real part first.
pub(crate) fn quaternion(q: DQuat) -> String {
    format!("({}, {}, {}, {})", float(q.w), float(q.x), float(q.y), float(q.z))
}

/// A list of values already written.
pub(crate) fn list(values: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", values.into_iter().collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prims_nest_and_strings_are_quoted() {
        let mut usda = Usda::new(&["upAxis = \"Z\"".into()]);
        usda.prim("Xform", "a", &[schemas(&["X", "Y"])], |usda| {
            usda.set("string s", &quoted("\"\n\\"))
        });
        let expected = "#usda 1.0\n(\n    upAxis = \"Z\"\n)\n\ndef Xform \"a\"\n(\n    \
            prepend apiSchemas = [\"X\", \"Y\"]\n)\n{\n    string s = \"\\\" \\\\\"\n}\n";
        assert_eq!(usda.finish(), expected);
    }

    #[test]
    fn numbers_are_single_precision_without_noise() {
        assert_eq!(triple(DVec3::new(1.0 / 3.0, 1e-17, -2.0)), "(0.33333334, 0, -2)");
        assert_eq!(quaternion(DQuat::IDENTITY), "(1, 0, 0, 0)");
    }
}
