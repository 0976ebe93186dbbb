//! Peculiar links and joints.

use super::{AXIS, BOX, LIMIT, Peculiar, SOLID};
use super::{boxed, felt, hinge, inertial, joint, link, moving, robot};

/// The usual file with this joint.
fn jointed(name: &'static str, kind: &str, inner: &str, rules: &'static str) -> Peculiar {
    robot(name, &[boxed("base"), boxed("a"), joint("j", kind, "base", "a", inner)], rules)
}

fn limited(name: &'static str, kind: &str, limit: &str, rules: &'static str) -> Peculiar {
    jointed(name, kind, &format!("{AXIS}<limit {limit}/>"), rules)
}

/// A third link `b`, on a joint `k`.
fn third(name: &'static str, k: String, rules: &'static str) -> Peculiar {
    robot(name, &[boxed("base"), boxed("a"), boxed("b"), hinge(), k], rules)
}

const MOTOR: &str = "<transmission name='t'><type>transmission_interface/SimpleTransmission</type>\
    <joint name='j'><hardwareInterface>EffortJointInterface</hardwareInterface></joint>\
    <actuator name='m'><mechanicalReduction>1</mechanicalReduction></actuator></transmission>";

/// What weighs half a kilogram 0.2 m from its hinge.
const LEVER: &str = "<inertial><origin xyz='0.2 0 0'/><mass value='0.5'/><inertia ixx='0.001' \
    iyy='0.001' izz='0.001' ixy='0' ixz='0' iyz='0'/></inertial>";

pub(crate) fn files() -> Vec<Peculiar> {
    let mut files = weights();
    files.extend(ranges());
    files.extend(kinds());
    files.extend(couplings());
    files
}

fn weights() -> Vec<Peculiar> {
    let shaped = |weight: &str| link("a", weight, &felt(BOX));
    vec![
        moving("nothing_peculiar", boxed("a"), ""),
        moving(
            "triangle",
            shaped(&inertial(1.0, [0.01, 0.01, 0.05])),
            "mujoco.inertia-triangle pybullet.inertia-ignored drake.inertia-triangle \
             newton.inertia-triangle",
        ),
        moving(
            "weighs_zero",
            shaped(&inertial(0.0, [0.0; 3])),
            "mujoco.mass-zero pybullet.mass-zero drake.no-mass newton.mass-zero sapien.mass-zero",
        ),
        moving(
            "moments_without_mass",
            shaped(&inertial(0.0, [1.0; 3])),
            "mujoco.mass-zero pybullet.mass-zero drake.mass-zero newton.mass-zero sapien.mass-zero",
        ),
        moving(
            "no_inertial",
            shaped(""),
            "mujoco.no-inertial pybullet.no-inertial drake.no-mass newton.no-inertial \
             isaac.no-inertial sapien.no-inertial genesis.no-inertial",
        ),
        moving(
            "nothing_at_all",
            link("a", "", ""),
            "mujoco.no-mass pybullet.no-inertial drake.no-mass newton.mass-zero isaac.no-inertial \
             sapien.no-mass",
        ),
        moving(
            "no_collision",
            link("a", &inertial(1.0, SOLID), ""),
            "pybullet.inertia-without-collision",
        ),
        moving(
            "other_moments",
            shaped(&inertial(1.0, [0.02, 0.03, 0.04])),
            "pybullet.inertia-ignored",
        ),
        third(
            "fixed",
            joint("k", "fixed", "a", "b", ""),
            "mujoco.fixed-fused genesis.fixed-merged",
        ),
        robot(
            "link_twice",
            &[boxed("base"), boxed("a"), boxed("a"), hinge()],
            "mujoco.link-twice pybullet.link-twice drake.link-twice newton.link-twice \
             isaac.link-twice sapien.link-twice genesis.link-twice",
        ),
        robot(
            "odd_name",
            &[boxed("base"), boxed("2 a-b"), hinge().replace("link='a'", "link='2 a-b'")],
            "isaac.names",
        ),
    ]
}

fn ranges() -> Vec<Peculiar> {
    let rest = "effort='5' velocity='2'";
    vec![
        jointed(
            "continuous_with_range",
            "continuous",
            &format!("{AXIS}{LIMIT}"),
            "mujoco.continuous-limit pybullet.continuous-limit drake.continuous-limit \
             newton.continuous-limit isaac.continuous-limit sapien.continuous-limit \
             genesis.continuous-limit rerun.continuous-limit",
        ),
        limited(
            "range_zero",
            "revolute",
            &format!("lower='0' upper='0' {rest}"),
            "mujoco.range-zero",
        ),
        limited(
            "no_range",
            "revolute",
            rest,
            "mujoco.range-missing pybullet.range-missing drake.range-missing newton.range-missing \
             isaac.range-missing sapien.range-missing genesis.range-incomplete rerun.range-missing",
        ),
        jointed(
            "no_limit",
            "revolute",
            AXIS,
            "mujoco.range-missing pybullet.limit-missing drake.range-missing newton.range-missing \
             newton.strength-missing isaac.range-missing sapien.limit-missing \
             genesis.limit-missing rerun.range-missing",
        ),
        limited(
            "lower_alone",
            "prismatic",
            &format!("lower='-1' {rest}"),
            "mujoco.range-one-sided pybullet.range-one-sided drake.range-one-sided \
             newton.range-one-sided isaac.range-one-sided sapien.slide-range-missing \
             genesis.range-incomplete rerun.range-one-sided",
        ),
        limited(
            "upper_alone",
            "revolute",
            &format!("upper='1' {rest}"),
            "mujoco.range-one-sided drake.range-one-sided newton.range-one-sided \
             isaac.range-one-sided sapien.range-missing genesis.range-incomplete \
             rerun.range-one-sided",
        ),
        limited(
            "effort_zero",
            "revolute",
            "lower='-1' upper='1' effort='0' velocity='2'",
            "mujoco.effort-zero genesis.effort-zero",
        ),
        robot(
            "motor_without_effort",
            &[
                boxed("base"),
                boxed("a"),
                hinge().replace("effort='5'", "effort='0'"),
                MOTOR.to_string(),
            ],
            "mujoco.effort-zero drake.effort-zero genesis.effort-zero",
        ),
        limited(
            "no_strength",
            "revolute",
            "lower='-1' upper='1'",
            "newton.strength-missing isaac.limit-incomplete rerun.limit-incomplete",
        ),
    ]
}

fn kinds() -> Vec<Peculiar> {
    let axis = |xyz: &str| format!("<axis xyz='{xyz}'/>{LIMIT}");
    vec![
        jointed(
            "axis_of_two",
            "prismatic",
            &axis("0 0 2"),
            "pybullet.axis-length rerun.axis-length",
        ),
        jointed(
            "axis_zero",
            "revolute",
            &axis("0 0 0"),
            "mujoco.axis-zero pybullet.axis-zero drake.axis-zero newton.axis-zero \
             isaac.axis-zero",
        ),
        jointed(
            "floating",
            "floating",
            "",
            "pybullet.floating-fixed drake.floating-joint newton.floating-origin \
             isaac.floating-joint sapien.floating-joint rerun.joint-unmoved",
        ),
        jointed(
            "planar_with_range",
            "planar",
            &axis("0 0 1"),
            "mujoco.planar-limit drake.planar-limit newton.planar-turn isaac.planar-limit \
             sapien.joint-type genesis.joint-type rerun.joint-unmoved",
        ),
        jointed(
            "ball",
            "ball",
            &axis("0 0 1"),
            "mujoco.joint-type pybullet.joint-type drake.joint-type newton.joint-type \
             isaac.joint-type sapien.joint-type genesis.joint-type rerun.joint-type",
        ),
        jointed(
            "friction",
            "revolute",
            &format!("{AXIS}{LIMIT}<dynamics damping='0' friction='0.2'/>"),
            "pybullet.friction-dropped drake.friction-dropped sapien.friction-dropped",
        ),
        jointed(
            "friction_alone",
            "revolute",
            &format!("{AXIS}{LIMIT}<dynamics friction='0.2'/>"),
            "pybullet.friction-dropped drake.friction-dropped sapien.friction-dropped \
             sapien.dynamics-without-damping",
        ),
        robot(
            "friction_held",
            &[
                boxed("base"),
                link("a", LEVER, &felt(BOX)),
                joint(
                    "j",
                    "revolute",
                    "base",
                    "a",
                    &format!("<axis xyz='0 1 0'/>{LIMIT}<dynamics damping='0.04' friction='2'/>"),
                ),
            ],
            "mujoco.friction-creeps newton.sinks pybullet.friction-dropped pybullet.sinks \
             pybullet.inertia-ignored \
             drake.friction-dropped drake.sinks sapien.friction-dropped sapien.sinks",
        ),
        jointed(
            "safety",
            "revolute",
            &format!(
                "{AXIS}{LIMIT}<safety_controller soft_lower_limit='-0.5' soft_upper_limit='0.5' \
                 k_position='9' k_velocity='9'/>"
            ),
            "mujoco.safety-ignored pybullet.safety-ignored drake.safety-ignored \
             newton.safety-ignored sapien.safety-ignored genesis.safety-gains",
        ),
    ]
}

fn couplings() -> Vec<Peculiar> {
    let follows = |name: &str, parent: &str, child: &str, multiplier: &str| {
        let mimic = format!("<mimic joint='j' multiplier='{multiplier}'/>");
        joint(name, "revolute", parent, child, &format!("{AXIS}{LIMIT}{mimic}"))
    };
    let apart = [
        boxed("base"),
        boxed("a"),
        boxed("b"),
        boxed("c"),
        hinge(),
        joint("m", "revolute", "base", "b", &format!("{AXIS}{LIMIT}")),
        follows("k", "b", "c", "2"),
    ];
    vec![
        third(
            "mimic_beside",
            follows("k", "base", "b", "2"),
            "mujoco.mimic-soft pybullet.mimic-dropped sapien.mimic-inverted",
        ),
        third(
            "mimic_mirrored",
            follows("k", "base", "b", "-1"),
            "mujoco.mimic-soft pybullet.mimic-dropped",
        ),
        third(
            "mimic_above",
            follows("k", "a", "b", "2"),
            "mujoco.mimic-soft pybullet.mimic-dropped",
        ),
        robot(
            "mimic_apart",
            &apart,
            "mujoco.mimic-soft pybullet.mimic-dropped sapien.mimic-dropped",
        ),
    ]
}
