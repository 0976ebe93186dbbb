//! An asset amended by what a verdict found: a few rounds, each step kept only if the verdict is
//! better for it.

use std::path::Path;

use asset::{Amendment, Asset};
use runner::StageError;
use sim_check::advice::{Advice, Remedy, advice, jams};
use sim_check::read::load;
use sim_check::{CheckOptions, Tier, Verdict};

use super::check_in_sim::{Passing, URDF};

/// Most rounds of checking and amending.
const ROUNDS: usize = 3;
/// How much more firmly joints are held that give way when the asset is set down.
const FIRMER: [f64; 4] = [2.0, 4.0, 8.0, 16.0];
const SETTLES: &str = "what is shown standing stands (S2)";
const CLEAR: &str = "what moves stays clear of the other parts all the way (C2, C5)";
const REACHES: &str = "what is driven gets to both ends (S3)";

fn steps(advice: Vec<Advice>, why: &'static str) -> Vec<Step> {
    advice.into_iter().map(|a| Step::new(a, why)).collect()
}

/// The asset with the joints amended whose motion the verdict found at fault, and those that let it
/// down.
///
/// # Errors
/// [`StageError`] if the asset cannot be written to `scratch` to be looked at.
pub fn repaired(asset: Asset, seed: u64, scratch: &Path) -> Result<Asset, StageError> {
    let options = CheckOptions { seed, up_to: Tier::Dynamic, ..CheckOptions::default() };
    let mut best = Looked::at(asset, &options, scratch)?;
    for _ in 0..ROUNDS {
        match best.step(&options, scratch)? {
            Some(better) => best = better,
            None => break,
        }
    }
    best.settled(&options, scratch)
}

/// An asset and what the checker makes of it.
struct Looked {
    asset: Asset,
    verdict: Verdict,
    steps: Vec<Step>,
}

/// An amendment of a joint, and what for.
struct Step {
    joint: String,
    amendment: Amendment,
    why: &'static str,
}

impl Step {
    fn new(advice: Advice, why: &'static str) -> Self {
        let amendment = match advice.remedy {
            Remedy::Clamp(range) => Amendment::Range(range),
            Remedy::Flip => Amendment::Flip,
        };
        Self { joint: advice.joint, amendment, why }
    }
}

impl Looked {
    fn at(asset: Asset, options: &CheckOptions, scratch: &Path) -> Result<Self, StageError> {
        let folder = Passing::write(&asset.to_urdf().files, scratch)?;
        let path = folder.path().join(URDF);
        let verdict = sim_check::check(&path, options);
        let fails = |id: &str| verdict.check(id).is_some_and(|c| !c.holds());
        let steps = match load::read(&path, options).robot {
            Some(robot) if fails("C2") || fails("C5") => steps(advice(&robot), CLEAR),
            Some(robot) if fails("S3") => steps(jams(&robot), REACHES),
            _ => vec![],
        };
        Ok(Self { asset, verdict, steps })
    }

    /// The first step that makes the verdict better, taken.
    fn step(&self, options: &CheckOptions, scratch: &Path) -> Result<Option<Self>, StageError> {
        for Step { joint, amendment, why } in &self.steps {
            let with =
                |after: &str| self.asset.amended(joint, *amendment, [&self.summary(), after], why);
            let Some(trial) = with("") else { continue };
            let looked = Self::at(trial, options, scratch)?;
            if looked.rank() > self.rank() {
                let asset = with(&looked.summary()).unwrap_or_else(|| looked.asset.clone());
                return Ok(Some(Self { asset, ..looked }));
            }
        }
        Ok(None)
    }

    /// The asset, its joints held more firmly where they give way when it is set down.
    fn settled(self, options: &CheckOptions, scratch: &Path) -> Result<Asset, StageError> {
        let gives_way = self.verdict.check("S2").is_some_and(|c| !c.holds());
        if self.verdict.tier < Tier::Kinematic || !gives_way {
            return Ok(self.asset);
        }
        for times in FIRMER {
            let with = |after: &str| self.asset.firmer(times, [&self.summary(), after], SETTLES);
            let firm = Self::at(with(""), options, scratch)?;
            if firm.rank() > self.rank() {
                return Ok(with(&firm.summary()));
            }
        }
        Ok(self.asset)
    }

    /// Better verdicts compare greater: a higher tier, then fewer failures, then less overlap.
    fn rank(&self) -> (Tier, std::cmp::Reverse<usize>, i64) {
        let failures = std::cmp::Reverse(self.verdict.failures().count());
        let depth = self.verdict.check("C2").and_then(|c| c.value).unwrap_or(f64::MAX);
        (self.verdict.tier, failures, -((depth * 1000.0).min(1e15) as i64))
    }

    fn summary(&self) -> String {
        let failed: Vec<&str> = self.verdict.failures().map(|c| c.id.as_str()).collect();
        match failed.is_empty() {
            true => self.verdict.tier.name().to_owned(),
            false => format!("{}, not {}", self.verdict.tier.name(), failed.join(" ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use asset::{BuildOptions, build};
    use object::{
        ArticulatedObject, Condition, DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part,
        Range,
    };

    use super::*;

    fn block(size: DVec3, centre: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
            centre + size * DVec3::new(sign(0), sign(1), sign(2))
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
        ((0..8).map(corner).collect(), faces.collect())
    }

    /// A sledge that slides along x on a floor, 0.3 m before a wall; its joint has this range.
    fn sledge(range: [f64; 2]) -> Asset {
        let floor = block(DVec3::new(1.4, 0.4, 0.1), DVec3::new(0.0, 0.0, 0.05));
        let wall = block(DVec3::new(0.1, 0.4, 0.4), DVec3::new(0.65, 0.0, 0.3));
        let sledge = block(DVec3::new(0.6, 0.2, 0.2), DVec3::new(0.0, 0.0, 0.203));
        let (mut vertices, mut faces, mut labels) = (vec![], vec![], vec![]);
        for ((v, f), label) in [(floor, 0), (wall, 0), (sledge, 1)] {
            let first = vertices.len() as u32;
            labels.extend(f.iter().map(|_| label));
            faces.extend(f.into_iter().map(|f| f.map(|i| i + first)));
            vertices.extend(v);
        }
        let text = r#"{"schema": "kinfold-condition/1", "category": "sledge", "parts": [
            {"name": "floor"}, {"name": "sledge", "parent": "floor", "joint": "prismatic"}]}"#;
        let condition = Condition::from_json(text).unwrap();
        let parts = condition.tree.parts().to_vec();
        let parts = parts.into_iter().map(|p| Part { text: p.name.clone(), ..p });
        let tree = KinematicTree::new(parts.collect()).unwrap();
        let slide = JointMotion {
            kind: JointKind::Prismatic,
            axis: DVec3::X,
            pivot: DVec3::new(0.0, 0.0, 0.1),
            range: Range::Limits { lower: -0.2, upper: 0.2 },
        };
        let mesh = Mesh::new(vertices, faces).unwrap();
        let joints = vec![vec![], vec![slide]];
        let object = ArticulatedObject::new(mesh, tree, labels, joints).unwrap();
        let asset = build(&object, &condition, &[Some(0), Some(1)], &BuildOptions::default());
        let asset = asset.unwrap();
        let name = asset.joints[0].name.clone();
        let amendment = Amendment::Range(range);
        asset.amended(&name, amendment, ["", ""], "the test").unwrap()
    }

    fn repaired_range(range: [f64; 2]) -> (Asset, [f64; 2]) {
        let scratch = tempfile::tempdir().unwrap();
        let asset = repaired(sledge(range), 0, scratch.path()).unwrap();
        let limits = asset.joints[0].motion.as_ref().unwrap().limits.clone().unwrap();
        (asset, limits.map(|l| l.value))
    }

    #[test]
    fn a_range_that_runs_into_a_wall_is_clamped_with_both_verdicts_on_record() {
        let (asset, [lower, upper]) = repaired_range([-0.1, 0.6]);
        assert_eq!(lower, -0.1);
        assert!(upper > 0.28 && upper < 0.31, "{upper}");
        let change = asset.changes.last().unwrap();
        assert_eq!((change.part.as_str(), change.what.as_str()), ("sledge", "range"));
        assert!(change.before.contains("C2"), "{change:?}");
        assert!(!change.after.contains("C2"), "{change:?}");
    }

    #[test]
    fn what_is_free_stays_as_it_is() {
        let range = [-0.2, 0.1];
        let (asset, found) = repaired_range(range);
        assert_eq!((found, asset), (range, sledge(range)));
    }
}
