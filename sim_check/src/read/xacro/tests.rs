//! xacro as robot packages write it.

use std::collections::BTreeMap;

use super::expand;
use crate::read::element::{read, write};
use crate::read::meshes::{Outside, Shelf};
use crate::read::places::Places;

/// What a body of xacro becomes, and the faults.
fn expanded(body: &str) -> (String, Vec<String>) {
    let env = BTreeMap::from([("SIDE".to_owned(), "left".to_owned())]);
    let places = Places { env, ..Places::default() };
    let mut shelf = Shelf::with(".".as_ref(), Outside::Refused, &places);
    let text = format!("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>{body}</robot>");
    let made = expand(&read(&text, None).unwrap(), &mut shelf);
    let text = write(&made.root).unwrap();
    let inner = text.strip_prefix("<robot>").and_then(|t| t.strip_suffix("</robot>"));
    (inner.unwrap_or(&text).to_owned(), made.faults)
}

fn clean(body: &str) -> String {
    let (text, faults) = expanded(body);
    assert_eq!(faults, [""; 0], "{body}");
    text
}

#[test]
fn properties_are_worked_out_where_they_are_used() {
    let body = "<xacro:property name='a' value='${b * 2}'/><xacro:property name='b' value='0.25'/>\
                <link name='l_${a}' note='$${a} costs $5'/>";
    assert_eq!(clean(body), "<link name=\"l_0.5\" note=\"${a} costs $5\"/>");
}

#[test]
fn a_macro_takes_values_defaults_and_blocks() {
    let body = "<xacro:macro name='leg' params='side reflect:=1 *origin **more'>\
                <joint name='${side}_hip'><xacro:insert_block name='origin'/>\
                <axis xyz='0 ${reflect} 0'/><xacro:insert_block name='more'/></joint></xacro:macro>\
                <xacro:leg side='left' reflect='-1'><origin xyz='1 2 3'/><x><a/><b/></x></xacro:leg>\
                <xacro:leg side='right'><origin/><x/></xacro:leg>";
    let due = "<joint name=\"left_hip\"><origin xyz=\"1 2 3\"/><axis xyz=\"0 -1 0\"/><a/><b/></joint>\
               <joint name=\"right_hip\"><origin/><axis xyz=\"0 1 0\"/></joint>";
    assert_eq!(clean(body), due);
}

#[test]
fn conditions_take_truths_numbers_and_comparisons() {
    for (value, holds) in [
        ("true", true),
        ("0", false),
        ("${1 == 1.0}", true),
        ("${'a' == 'b'}", false),
        ("$(arg on)", true),
    ] {
        let body = format!(
            "<xacro:arg name='on' default='true'/><xacro:if value=\"{value}\"><a/></xacro:if>\
             <xacro:unless value=\"{value}\"><b/></xacro:unless>"
        );
        assert_eq!(clean(&body), if holds { "<a/>" } else { "<b/>" }, "{value}");
    }
}

#[test]
fn a_package_is_an_address_and_only_given_names_of_the_environment_have_values() {
    let body =
        "<mesh filename='$(find arm)/m/a.obj' side='$(optenv SIDE right) $(optenv HOME none)'/>";
    assert_eq!(clean(body), "<mesh filename=\"package://arm/m/a.obj\" side=\"left none\"/>");
    let (text, faults) = expanded("<link name='$(env HOME)'/>");
    assert_eq!(text, "<link name=\"$(env HOME)\"/>");
    assert!(faults[0].contains("was given no value (--env HOME=…)"), "{faults:?}");
}

#[test]
fn what_is_not_known_is_said_and_the_rest_is_read() {
    let (text, faults) = expanded("<a x='${nope}'/><xacro:missing/><b x='${2+2}'/>");
    assert_eq!(text, "<a x=\"${nope}\"/><b x=\"4\"/>");
    assert_eq!(faults.len(), 2);
    assert!(faults[0].contains("`nope` is not known") && faults[1].contains("no macro `missing`"));
}

#[test]
fn a_macro_that_calls_itself_or_a_property_that_names_itself_ends() {
    let (_, faults) = expanded("<xacro:macro name='m'><xacro:m/></xacro:macro><xacro:m/>");
    assert!(faults[0].contains("nest at most"), "{faults:?}");
    let ring = "<xacro:property name='p' value='${q}'/><xacro:property name='q' value='${p}'/>";
    let (_, faults) = expanded(&format!("{ring}<a x='${{p}}'/>"));
    assert!(faults[0].contains("at most"), "{faults:?}");
    let double = "<xacro:macro name='m' params='n'><a/><xacro:if value='${n > 0}'><xacro:m n='${n-1}'/>\
                  <xacro:m n='${n-1}'/></xacro:if></xacro:macro><xacro:m n='40'/>";
    let (text, faults) = expanded(double);
    assert!(text.len() < 4_000_000 && !faults.is_empty());
}

#[test]
fn what_a_call_makes_stands_on_the_line_of_the_call() {
    let body = "\n<xacro:macro name='m' params='n'>\n<link name='${n}'/></xacro:macro>\n<xacro:m n='x'/>\n<a/>";
    assert_eq!(clean(body), "\n\n\n<link name=\"x\"/>\n<a/>");
}
