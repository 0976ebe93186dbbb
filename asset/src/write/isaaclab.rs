//! The asset for Isaac Lab: a Python file with two `ArticulationCfg`s beside the URDF.
//!
//! One leaves the joints to whoever pulls them: damping and dry friction of the asset, no stiffness. The
//! other drives each joint to a position, with gains from the inertia that hangs on the joint and from its
//! effort. Names of fields are those of Isaac Lab's main branch, autumn 2026.

use crate::asset::{Asset, Joint, JointType, Motion};
use crate::write::moved::inertia;
use crate::write::xml::number;

/// A drive pushes with its whole effort at this share of its range away from its target; a guess that
/// keeps the steady error of a held joint below a few hundredths of its range.
const FULL_EFFORT: f64 = 0.1;
/// What stands for the range of a joint that turns without end, radians.
const TURN: f64 = std::f64::consts::TAU;

impl Asset {
    /// The text of a Python module for Isaac Lab, to lie beside `asset.urdf`. The same asset gives the
    /// same bytes.
    pub fn to_isaaclab(&self) -> String {
        let name = self.name.to_uppercase();
        let mut text = head(&self.name, &name);
        let moving = self.joints.iter().filter_map(|j| Some((j, j.motion.as_ref()?)));
        let joints: Vec<(&Joint, &Motion)> = moving.collect();
        text.push_str("_JOINT_POS = {\n");
        for (joint, _) in &joints {
            text.push_str(&format!("    \"{}\": 0.0,\n", joint.name));
        }
        text.push_str("}\n");
        let all = |group: &dyn Fn(&Joint, &Motion) -> String| {
            joints.iter().map(|(j, m)| group(j, m)).collect::<String>()
        };
        text.push_str(&configuration(&format!("{name}_CFG"), &all(&passive)));
        text.push_str("\"\"\"Joints that stay where they are left, and move when pulled.\"\"\"\n");
        let driven = |joint: &Joint, motion: &Motion| driven(joint, motion, inertia(self, joint));
        text.push_str(&configuration(&format!("{name}_DRIVEN_CFG"), &all(&driven)));
        text.push_str("\"\"\"Joints that go to the position they are told.\"\"\"\n");
        text
    }
}

fn head(name: &str, upper: &str) -> String {
    format!(
        r#""""Isaac Lab configurations of {name}, written by kinfold.

Take one where a scene needs it: {upper}_CFG.replace(prim_path="{{ENV_REGEX_NS}}/{name}").
Efforts, speeds, damping and friction are those of asset.urdf; asset.json says where each comes from.
Stiffness of the driven one: effort / ({FULL_EFFORT} x range), so that a drive pushes with its whole
effort a tenth of its range away from its target. Its damping: 2 x sqrt(stiffness x inertia about the
joint), which is critical, and never less than the file's.
"""

from pathlib import Path

import isaaclab.sim as sim_utils
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets.articulation import ArticulationCfg

_URDF = str(Path(__file__).resolve().parent / "asset.urdf")

_SPAWN = sim_utils.UrdfFileCfg(
    asset_path=_URDF,
    # The object stands where it is put. False lets it be pushed over.
    fix_base=True,
    # Links keep their names; False also keeps handles and feet as links of their own.
    merge_fixed_joints=False,
    # Gains come from the actuators below.
    joint_drive=sim_utils.UrdfConverterCfg.JointDriveCfg(
        gains=sim_utils.UrdfConverterCfg.JointDriveCfg.PDGainsCfg(stiffness=0.0, damping=0.0),
    ),
)

"#
    )
}

fn configuration(name: &str, groups: &str) -> String {
    format!(
        "\n{name} = ArticulationCfg(\n    spawn=_SPAWN,\n    \
         init_state=ArticulationCfg.InitialStateCfg(joint_pos=_JOINT_POS),\n    actuators={{\n{groups}    \
         }},\n    soft_joint_pos_limit_factor=1.0,\n)\n"
    )
}

/// A group of one joint: its name, its bounds, and gains with what they follow from.
fn group(joint: &Joint, motion: &Motion, gains: [(&str, f64, &str); 3]) -> String {
    let name = &joint.name;
    let bound = |field: &str, value: f64| format!("            {field}={},\n", float(value));
    let mut text = format!("        \"{name}\": ImplicitActuatorCfg(\n");
    text.push_str(&format!("            joint_names_expr=[\"{name}\"],\n"));
    text.push_str(&bound("joint_effort_limit", motion.effort.value));
    text.push_str(&bound("joint_velocity_limit", motion.velocity.value));
    for (field, value, why) in gains {
        text.push_str(&format!("            {field}={},  # {why}\n", float(value)));
    }
    text.push_str("        ),\n");
    text
}

fn passive(joint: &Joint, motion: &Motion) -> String {
    let gains = [
        ("stiffness", 0.0, "nothing pulls it anywhere"),
        ("damping", motion.damping.value, "of the asset"),
        ("friction", motion.friction.value, "of the asset: it stays where it is left"),
    ];
    group(joint, motion, gains)
}

fn driven(joint: &Joint, motion: &Motion, inertia: f64) -> String {
    let range = motion.limits.as_ref().map_or(TURN, |[l, u]| u.value - l.value);
    let stiffness = motion.effort.value / (FULL_EFFORT * range.max(1e-9));
    let damping = (2.0 * (stiffness * inertia).sqrt()).max(motion.damping.value);
    let unit = if joint.kind == JointType::Prismatic { "kg" } else { "kg m^2" };
    let why = format!("critical for {} {unit} on the joint", float(inertia));
    let gains = [
        ("stiffness", stiffness, "effort over a tenth of the range"),
        ("damping", damping, why.as_str()),
        ("friction", motion.friction.value, "of the asset"),
    ];
    group(joint, motion, gains)
}

/// A number that Python reads as a float, six digits.
fn float(x: f64) -> String {
    if x == 0.0 {
        return "0.0".into();
    }
    let digits = (5 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = number(format!("{x:.digits$}").parse().unwrap_or(x));
    if text.contains('.') { text } else { format!("{text}.0") }
}

#[cfg(test)]
mod tests {
    use super::float;

    #[test]
    fn numbers_are_floats_of_six_digits() {
        assert_eq!(
            [0.0, 2.0, 1234567.8, 0.00123456789].map(float),
            ["0.0", "2.0", "1234568.0", "0.00123457"]
        );
    }
}
