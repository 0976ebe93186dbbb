//! An asset is its shapes and what is made of them: in one go or by way of a file, the same bytes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

mod cabinet;

use asset::{Asset, BuildOptions, Measures, Shapes, build, finish, shape};
use cabinet::{BODY, DOOR, DRAWER, MAP, cabinet};
use object::condition::GivenJoint;
use object::{Condition, Origin, Range};

fn made(condition: &Condition) -> Asset {
    build(&cabinet(), condition, &MAP, &BuildOptions::default()).unwrap()
}

fn shapes(measures: &Measures) -> Shapes {
    shape(&cabinet(), measures, &MAP, 0).unwrap()
}

fn text<T: serde::Serialize>(value: &T) -> String {
    serde_json::to_string(value).unwrap()
}

/// A cabinet whose door goes a given way.
fn given() -> Condition {
    let mut condition = cabinet::condition();
    let range = Some(Range::Limits { lower: -0.1, upper: 1.1 });
    let door = GivenJoint { range, effort: Some(7.5), ..GivenJoint::default() };
    condition.prompts[DOOR].joints = vec![door];
    condition
}

#[test]
fn an_asset_by_way_of_stored_shapes_is_the_same_to_the_last_bit() {
    for condition in [cabinet::condition(), given()] {
        let shapes = shapes(&Measures::of(&condition));
        let stored = text(&shapes);
        let read: Shapes = serde_json::from_str(&stored).unwrap();
        assert!(read == shapes && text(&read) == stored, "it reads as something else");
        let asset = finish(read, &condition, Origin::Model).unwrap();
        assert!(text(&asset) == text(&made(&condition)), "what was stored makes another asset");
    }
}

#[test]
fn another_mass_material_or_drive_finishes_the_same_shapes() {
    let shapes = shapes(&Measures::of(&given()));
    let mut other = given();
    other.prompts[BODY].material = Some("granite".into());
    other.prompts[DOOR].material = Some("chromed metal".into());
    other.prompts[DRAWER].mass = Some(4.0);
    other.prompts[DOOR].joints[0].damping = Some(0.5);
    assert_eq!(Measures::of(&other), Measures::of(&given()));
    let asset = finish(shapes, &other, Origin::Model).unwrap();
    assert!(text(&asset) == text(&made(&other)), "by these shapes it is another asset");
    assert!(text(&asset) != text(&made(&given())), "its masses are others");
}

#[test]
fn another_size_asks_for_other_shapes() {
    let (condition, mut other) = (cabinet::condition(), cabinet::condition());
    other.size.as_mut().unwrap().metres = 0.46;
    let [measures, others] = [&condition, &other].map(Measures::of);
    assert_ne!(measures, others);
    let asset = finish(shapes(&others), &other, Origin::Model).unwrap();
    assert!((asset.scale.value - 1.0).abs() < 1e-12, "{}", asset.scale.value);
    assert!(text(&asset) == text(&made(&other)), "shaped by measures it is another asset");
}

#[test]
fn shapes_that_lead_out_of_their_lists_are_refused() {
    let stored = serde_json::to_value(shapes(&Measures::of(&cabinet::condition()))).unwrap();
    let refused = |alter: &dyn Fn(&mut serde_json::Value)| {
        let mut other = stored.clone();
        alter(&mut other);
        serde_json::from_value::<Shapes>(other).unwrap_err().to_string()
    };
    let parts = refused(&|s| s["parts"].as_array_mut().unwrap().truncate(2));
    assert!(parts.contains("expected the shapes of 5 parts, found 2"), "{parts}");
    let patch = refused(&|s| s["parts"][1]["surface"]["patches"][0]["faces"][0] = 99_999.into());
    assert!(patch.contains("part `door`: expected patches of faces that are there"), "{patch}");
    let piece = refused(&|s| s["parts"][1]["pieces"][0]["faces"][0][0] = 99_999.into());
    assert!(piece.contains("expected collision pieces whose corners are there"), "{piece}");
    let none = refused(&|s| s["parts"][1]["pieces"] = serde_json::json!([]));
    assert!(none.contains("expected collision pieces"), "{none}");
    let wanted = refused(&|s| s["parts"][1]["wanted"] = serde_json::json!([]));
    assert!(wanted.contains("expected a wanted motion for each joint"), "{wanted}");
}
