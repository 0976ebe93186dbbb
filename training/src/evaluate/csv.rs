//! One line per case, every number in full, for spreadsheets.

use crate::metrics::Scores;

use super::Row;

const CASE: [&str; 5] = ["case", "set", "parts", "lost", "error"];
const SCORES: [&str; 22] = [
    "precision",
    "recall",
    "giou",
    "chamfer",
    "box_iou",
    "point_iou",
    "moved_giou",
    "moved_points",
    "moved_chamfer",
    "moved_overall",
    "joints",
    "joints_compared",
    "angle",
    "line",
    "within_15",
    "within_15_and_line",
    "range_iou",
    "one_way",
    "opens_right",
    "opens_both",
    "opens_wrong",
    "fully_right",
];

/// Rows as comma-separated values with a heading; scores twice, by number, where numbers say anything,
/// and by centroid.
pub fn csv(rows: &[Row]) -> String {
    heading() + &rows.iter().map(line).collect::<String>()
}

/// The heading alone.
pub fn heading() -> String {
    let headed = |prefix: &'static str| SCORES.iter().map(move |name| format!("{prefix}_{name}"));
    let head = CASE.iter().map(|c| (*c).to_owned());
    let head: Vec<_> = head.chain(headed("identity")).chain(headed("hungarian")).collect();
    head.join(",") + "\n"
}

/// One row alone.
pub fn line(row: &Row) -> String {
    let fields = case(row).into_iter();
    let by_number = row.identity.as_ref().map_or_else(Default::default, scores);
    let fields = fields.chain(by_number).chain(scores(&row.hungarian));
    fields.map(|f| quoted(&f)).collect::<Vec<_>>().join(",") + "\n"
}

fn case(row: &Row) -> [String; 5] {
    let (set, error) = (row.set.name().to_owned(), row.error.clone().unwrap_or_default());
    [row.case.clone(), set, row.parts.to_string(), row.lost.join(" "), error]
}

fn scores(s: &Scores) -> [String; 22] {
    let some = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let sure = |value: f64| some(value.is_finite().then_some(value));
    [
        sure(s.precision),
        sure(s.recall),
        sure(s.giou),
        sure(s.chamfer),
        sure(s.box_iou),
        some(s.point_iou),
        sure(s.moved_giou),
        sure(s.moved_points),
        sure(s.moved_chamfer),
        sure(s.moved_overall),
        s.joints.joints.to_string(),
        s.joints.compared.to_string(),
        some(s.joints.angle),
        some(s.joints.line),
        some(s.joints.near),
        some(s.joints.found),
        some(s.joints.range),
        s.joints.opening.joints.to_string(),
        some(s.joints.opening.right),
        some(s.joints.opening.both),
        some(s.joints.opening.wrong),
        s.fully_right.map_or_else(String::new, |right| u8::from(right).to_string()),
    ]
}

/// A field that may hold anything, as RFC 4180 wants it.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_with_a_comma_or_a_quote_is_quoted() {
        assert_eq!(quoted("a b"), "a b");
        assert_eq!(quoted("part `a`, \"b\""), "\"part `a`, \"\"b\"\"\"");
    }
}
