//! Peculiar MJCF models.

use super::Peculiar;

fn model(name: &'static str, head: &str, body: &str, rules: &'static str) -> Peculiar {
    let text = format!(
        "<mujoco>{head}\n<worldbody>\n<body name='a'>\n{body}\n<geom size='.1'/></body>\n\
         </worldbody>\n</mujoco>\n"
    );
    Peculiar { name, extension: "xml", text, beside: Vec::new(), rules }
}

pub(crate) fn files() -> Vec<Peculiar> {
    let weight = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>";
    vec![
        model("mjcf_plain", "<compiler angle='radian'/>", "<joint name='j' range='-1 1'/>", ""),
        model("mjcf_degrees", "", "<joint name='j' range='-1.57 1.57'/>", "mujoco.mjcf-degrees"),
        model("mjcf_range_zero", "", "<joint name='j' range='0 0'/>", "mujoco.mjcf-range-zero"),
        model(
            "mjcf_visual_mass",
            "",
            "<joint name='j'/><geom size='.1' contype='0' conaffinity='0'/>",
            "mujoco.mjcf-visual-mass",
        ),
        model(
            "mjcf_autolimits_off",
            "<compiler autolimits='false'/>",
            "<joint name='j' range='-10 10'/>",
            "mujoco.mjcf-autolimits-off",
        ),
        model(
            "mjcf_inertial_overruled",
            "<compiler inertiafromgeom='true'/>",
            &format!("{weight}<joint name='j'/>"),
            "mujoco.mjcf-inertial-overruled",
        ),
    ]
}
