//! Whatever was asked before, the answer is that of one who is asked for the first time.

use object::condition::Prompt;
use object::{Condition, KinematicTree, Mesh, Part};

use super::*;
use crate::articulate::Articulate;
use crate::classic::Hybrid;
use crate::classic::golden::objects;

/// What a person may make of a condition, one click after another.
fn clicks(mesh: &Mesh, condition: &Condition) -> Vec<Condition> {
    let count = mesh.faces().len();
    let at = |eighth: usize| mesh.centroid(eighth * (count - 1) / 8);
    let mut now = condition.clone();
    let mut all = vec![now.clone()];
    let mut click = |change: &dyn Fn(&mut Condition)| {
        let mut changed = now.clone();
        change(&mut changed);
        if changed.check_points(mesh).is_ok() {
            now = changed;
            all.push(now.clone());
        }
    };
    click(&|c| c.prompts[1].point = Some(at(5)));
    click(&|c| c.prompts[2].not.push(at(3)));
    click(&|c| c.prompts[0].also.push(at(1)));
    click(&|c| c.prompts[1].faces = [2, 3, count as u32 - 1].into_iter().collect());
    click(&|c| c.prompts[2].not.clear());
    click(&|c| c.tree = with_texts(c, "knob"));
    click(&|c| *c = with_part(c, at(7)));
    click(&|c| c.prompts[1] = Prompt::default());
    all.push(condition.clone());
    all
}

fn with_texts(condition: &Condition, text: &str) -> KinematicTree {
    let said = |part: &Part| Part { text: text.into(), ..part.clone() };
    KinematicTree::new(condition.tree.parts().iter().map(said).collect()).unwrap()
}

/// The same with one more part, like the last but for its name.
fn with_part(condition: &Condition, point: DVec3) -> Condition {
    let mut more = condition.clone();
    let mut parts = condition.tree.parts().to_vec();
    let last = Part { name: "new".into(), ..parts[parts.len() - 1].clone() };
    parts.push(last);
    more.tree = KinematicTree::new(parts).unwrap();
    more.prompts.push(Prompt { point: Some(point), ..Prompt::default() });
    more
}

#[test]
fn labels_of_many_conditions_in_a_row_are_those_of_a_fresh_start() {
    for (mesh, condition) in [objects::components(), objects::fused(), objects::cut_up()] {
        let ready = Prepared::new(&mesh).unwrap();
        let clicks = clicks(&mesh, &condition);
        assert!(clicks.len() > 6, "{}", clicks.len());
        for (i, condition) in clicks.iter().enumerate() {
            let fresh = Prepared::new(&mesh).unwrap().labels(condition).unwrap();
            assert_eq!(ready.labels(condition).unwrap(), fresh, "click {i}");
            assert!(fresh.confidence.iter().all(|sure| (0.0..=1.0).contains(sure)));
            for face in condition.prompts.iter().flat_map(|p| p.faces.iter()) {
                assert_eq!(fresh.confidence[face as usize], 1.0, "painted");
            }
        }
    }
}

#[test]
fn a_mesh_that_is_ready_is_articulated_as_ever() {
    let (mesh, condition) = objects::no_texts();
    let ready = Prepared::new(&mesh).unwrap();
    for condition in clicks(&mesh, &condition).iter().step_by(3) {
        let (found, choices) = ready.articulate(condition, 3).unwrap();
        assert_eq!(found, Hybrid.articulate(&mesh, condition, 3).unwrap());
        let labels = ready.labels(condition).unwrap();
        let now = |&part: &u16| found.part_of_condition[usize::from(part)].unwrap() as u16;
        let kept: Vec<u16> = labels.part_of_face.iter().map(now).collect();
        assert_eq!(kept, found.object.part_of_face());
        for choice in &choices {
            let part = found.part_of_condition[choice.part].unwrap();
            assert!(choice.joint < found.object.joints(part).len());
            assert!(!choice.axes.is_empty() && choice.axes.len() <= 12);
            let sum: f64 = choice.axes.iter().map(|axis| axis.probability).sum();
            assert!(sum > 0.0 && sum < 1.0 + 1e-9, "{sum}");
            assert!(choice.axes.windows(2).all(|w| w[0].probability >= w[1].probability));
        }
    }
}

#[test]
fn threads_may_share_a_mesh_that_is_ready() {
    const fn shared<T: Send + Sync>() {}
    const { shared::<Prepared>() };
}
