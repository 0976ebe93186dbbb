use super::*;

const TEXT: &str = r#"<?xml version="1.0"?>
<!-- kinfold: allow L1: labels come later -->
<robot name="desk">
  <link name="top"/> <link name='leg "1"'>
    <!-- kinfold: allow G2, G3 until 2027-01-31: a bowl,
         cast in one piece -->
    <collision><geometry><box size="1 > 0"/></geometry></collision>
  </link>
  <!-- a word -->
  <joint name="a&amp;b" type="fixed"><parent link="top"/></joint>
</robot>
"#;

#[test]
fn links_and_joints_are_found_at_their_line_and_column() {
    let source = Source::read(TEXT);
    let at = |finding: &str| {
        let Place { line, column } = source.place_of(finding);
        (line, column)
    };
    assert_eq!(at("link `top`: no label"), (4, 3));
    assert_eq!(at("link `leg \"1\"`: not convex"), (4, 22));
    assert_eq!(at("joint `a&b`: no axis"), (10, 3));
    assert_eq!(at("`nobody` is missing"), (3, 1));
    assert_eq!(at("line 7: not XML"), (7, 1));
}

#[test]
fn a_comment_lets_pass_what_stands_behind_it_and_before_the_root_the_whole_file() {
    let found = Source::read(TEXT).allowances;
    let short: Vec<_> =
        found.iter().map(|a| (a.check.as_str(), a.about.as_deref(), a.until.as_deref())).collect();
    let last = Some("2027-01-31");
    let leg = Some("leg \"1\"");
    assert_eq!(short, [("L1", None, None), ("G2", leg, last), ("G3", leg, last)]);
    assert_eq!(found[1].reason, "a bowl, cast in one piece");
    assert_eq!(found[1].line, Some(5));
}

#[test]
fn a_comment_that_is_not_understood_allows_nothing_and_is_told() {
    for (comment, word) in [
        ("allow C1", "no reason"),
        ("allow C1:  ", "no reason"),
        ("allow C99: x", "unknown id `C99`"),
        ("allow C1 until tomorrow: x", "found `tomorrow`"),
        ("allow C1 until 2027-13-01: x", "YYYY-MM-DD"),
        ("ignore C1: x", "found `ignore C1: x`"),
    ] {
        let source =
            Source::read(&format!("<robot name=\"r\">\n<!-- kinfold: {comment} --></robot>"));
        assert!(source.allowances.is_empty(), "{comment}");
        assert!(source.misread[0].starts_with("line 2: "), "{:?}", source.misread);
        assert!(source.misread[0].contains(word), "{:?}", source.misread);
    }
    assert!(Source::read("<robot><!-- kinfold is good --></robot>").misread.is_empty());
}

#[test]
fn any_text_has_places() {
    for text in [
        "",
        "<",
        "<!--",
        "<a b='",
        "</",
        "<<>>",
        "<a name",
        "<a name=",
        "<a name='",
        "é<é name='é'",
    ] {
        let _ = Source::read(text).place_of("`é`");
    }
}
