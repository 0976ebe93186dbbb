//! Models of ours with one defect each.

use std::path::Path;

const CUPBOARD: &str = r#"<?xml version="1.0"?>
<robot name="cupboard">
  <!-- the body stands still -->
  <link name="body">
    <inertial>
      <mass value="20"/>
      <inertia ixx="0.8667" iyy="1.0167" izz="0.6833" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual><geometry><box size="0.5 0.4 0.6"/></geometry></visual>
    <collision><geometry><box size="0.5 0.4 0.6"/></geometry></collision>
  </link>
  <link name="door">
    <inertial>
      <origin xyz="0.011 0.2 0"/><!-- weight -->
      <mass value="2"/>
      <inertia ixx="0.0868" iyy="0.0601" izz="0.0268" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual><!-- door --><origin xyz="0.011 0.2 0"/><geometry><box size="0.02 0.4 0.6"/></geometry></visual>
    <collision><!-- door --><origin xyz="0.011 0.2 0"/><geometry><box size="0.02 0.4 0.6"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <origin xyz="0.26 -0.2 0"/>
    <parent link="body"/>
    <child link="door"/>
    <axis xyz="0 0 -1"/>
    <limit lower="0" upper="1.50" effort="10" velocity="1"/>
    <dynamics damping="0.1" friction="0.1"/>
  </joint>
</robot>
"#;

/// A cupboard with a door, and one place of its text told otherwise.
pub fn cupboard(from: &str, to: &str) -> String {
    assert!(CUPBOARD.contains(from), "{from}");
    if from.is_empty() { CUPBOARD.to_owned() } else { CUPBOARD.replacen(from, to, 1) }
}

const MJCF: &str = r#"<mujoco model="cupboard">
  <worldbody>
    <body name="body">
      <inertial pos="0 0 0" mass="10" diaginertia="0.4333 0.5083 0.3417"/>
      <geom name="body" type="box" size="0.25 0.2 0.3"/>
    <!-- the door -->
    <body name="door" pos="0.271 0 0">
      <joint name="hinge" axis="0 0 -1" pos="0 -0.2 0" range="0 85" damping="0.1" frictionloss="0.1"/>
      <inertial pos="0 0 0" mass="2" diaginertia="0.0868 0.0601 0.0268"/>
      <geom name="door" type="box" size="0.01 0.2 0.3"/>
    </body>
    </body>
  </worldbody>
</mujoco>
"#;

/// The same cupboard in MJCF, and one place of its text told otherwise.
pub fn mjcf(from: &str, to: &str) -> String {
    assert!(MJCF.contains(from), "{from}");
    MJCF.replacen(from, to, 1)
}

/// One link of one mesh, which is seen and touched.
pub fn cup(mesh: &str) -> String {
    let shape = format!("<geometry><mesh filename=\"{mesh}\"/></geometry>");
    format!(
        "<robot name=\"cup\">\n  <link name=\"cup\">\n    <inertial>\n      <mass value=\"1\"/>\n      \
         <inertia ixx=\"0.004\" iyy=\"0.004\" izz=\"0.004\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\n    \
         </inertial>\n    <visual>{shape}</visual>\n    <collision name=\"skin\">{shape}</collision>\n  \
         </link>\n</robot>\n"
    )
}

/// Corners of boxes, and their sides outward or inward.
fn boxes(all: &[([f64; 3], [f64; 3])], inward: bool) -> String {
    let mut text = String::from("mtllib none.mtl\n");
    let mut faces = String::new();
    for (i, (low, high)) in all.iter().enumerate() {
        for corner in 0..8 {
            let at = |k: usize| if corner >> k & 1 == 1 { high[k] } else { low[k] };
            text += &format!("v {} {} {}\n", at(0), at(1), at(2));
        }
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        for side in sides {
            let told: Vec<String> = side.iter().map(|v| (v + 1 + 8 * i).to_string()).collect();
            let told = if inward { told.into_iter().rev().collect() } else { told };
            faces += &format!("f {}\n", told.join(" "));
        }
    }
    text + &faces
}

/// A box, open and inside out, and a trough of three boxes.
pub fn write_meshes(folder: &Path) {
    let cube = [([-0.1, -0.1, 0.0], [0.1, 0.1, 0.2])];
    let open: String = {
        let whole = boxes(&cube, false);
        let cut = whole.trim_end().rfind('\n').unwrap();
        whole[..=cut].to_owned()
    };
    let trough = [
        ([-0.1, -0.1, 0.0], [0.1, 0.1, 0.02]),
        ([-0.1, -0.1, 0.02], [-0.08, 0.1, 0.2]),
        ([0.08, -0.1, 0.02], [0.1, 0.1, 0.2]),
    ];
    std::fs::write(folder.join("open.obj"), open).unwrap();
    std::fs::write(folder.join("inward.obj"), boxes(&cube, true)).unwrap();
    std::fs::write(folder.join("hollow.obj"), boxes(&trough, false)).unwrap();
}
