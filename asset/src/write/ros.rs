//! The asset as a ROS 2 package: URDF and meshes under `package://`, install rules, a launch file that
//! shows it in RViz with a slider per joint.
//!
//! The package builds with `colcon build`; `ros2 launch NAME display.launch.py` shows it.

use std::collections::BTreeMap;

use crate::asset::Asset;
use crate::write::appearance::look::AssetAppearance;
use crate::write::urdf::Package;
use crate::write::xml::Xml;

impl Asset {
    /// The asset as the files of a ROS 2 package `NAME_description`, each path below a folder of that
    /// name. The same asset gives the same bytes.
    pub fn to_ros_with(&self, appearance: &AssetAppearance) -> Package {
        let name = package_name(&self.name);
        let mut files = BTreeMap::new();
        let mut add = |path: String, bytes: Vec<u8>| files.insert(format!("{name}/{path}"), bytes);
        for (path, bytes) in self.to_urdf_with(appearance).files {
            match path.as_str() {
                "asset.urdf" => {
                    let text = String::from_utf8_lossy(&bytes);
                    let from_package = format!("filename=\"package://{name}/meshes/");
                    let text = text.replace("filename=\"meshes/", &from_package);
                    add(format!("urdf/{}.urdf", self.name), text.into_bytes());
                }
                "asset.json" => {}
                _ => {
                    add(path, bytes);
                }
            }
        }
        let root = self.links.first().map_or("", |l| l.name.as_str());
        add("package.xml".into(), manifest(self, &name).into_bytes());
        add("CMakeLists.txt".into(), rules(&name).into_bytes());
        add("launch/display.launch.py".into(), launch(&name, &self.name).into_bytes());
        add("rviz/display.rviz".into(), view(root).into_bytes());
        Package { files }
    }
}

/// ROS 2's rule for names (REP 144): lower case, digits and single underscores, a letter first.
fn package_name(name: &str) -> String {
    let mut out = String::new();
    for c in name.to_lowercase().chars() {
        let c = if c.is_ascii_alphanumeric() { c } else { '_' };
        if !(c == '_' && out.ends_with('_')) {
            out.push(c);
        }
    }
    let out = out.trim_matches('_');
    let letter = out.starts_with(|c: char| c.is_ascii_lowercase());
    format!("{}{out}_description", if letter { "" } else { "asset_" })
}

fn manifest(asset: &Asset, name: &str) -> String {
    let mut xml = Xml::new();
    xml.element("package", &[("format", "3")], |xml| {
        xml.text("name", &[], name);
        xml.text("version", &[], "1.0.0");
        let words = if asset.category.is_empty() { &asset.name } else { &asset.category };
        xml.text("description", &[], &format!("Links, joints and meshes of: {words}"));
        // Whose it is and under which licence is for its user to say.
        xml.text("maintainer", &[("email", "nobody@example.com")], "not stated");
        xml.text("license", &[], "not stated");
        xml.text("buildtool_depend", &[], "ament_cmake");
        let shows =
            ["joint_state_publisher_gui", "launch", "launch_ros", "robot_state_publisher", "rviz2"];
        shows.iter().for_each(|package| xml.text("exec_depend", &[], package));
        xml.element("export", &[], |xml| xml.text("build_type", &[], "ament_cmake"));
    });
    xml.finish()
}

fn rules(name: &str) -> String {
    format!(
        "cmake_minimum_required(VERSION 3.8)\nproject({name})\n\nfind_package(ament_cmake REQUIRED)\n\n\
         install(DIRECTORY launch meshes rviz urdf\n  DESTINATION share/${{PROJECT_NAME}})\n\n\
         ament_package()\n"
    )
}

fn launch(name: &str, asset: &str) -> String {
    format!(
        r#""""Shows {asset} in RViz, with a slider for each joint."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    share = Path(get_package_share_directory("{name}"))
    description = (share / "urdf" / "{asset}.urdf").read_text()
    return LaunchDescription([
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            parameters=[{{"robot_description": description}}],
        ),
        Node(package="joint_state_publisher_gui", executable="joint_state_publisher_gui"),
        Node(
            package="rviz2",
            executable="rviz2",
            arguments=["-d", str(share / "rviz" / "display.rviz")],
        ),
    ])
"#
    )
}

fn view(root: &str) -> String {
    format!(
        "Visualization Manager:\n  Class: \"\"\n  Displays:\n    - Class: rviz_default_plugins/Grid\n      \
         Name: Grid\n      Enabled: true\n    - Class: rviz_default_plugins/RobotModel\n      \
         Name: Asset\n      Enabled: true\n      Description Source: Topic\n      \
         Description Topic:\n        Value: /robot_description\n    \
         - Class: rviz_default_plugins/TF\n      Name: Frames\n      Enabled: false\n  \
         Global Options:\n    Fixed Frame: {root}\n  Tools:\n    \
         - Class: rviz_default_plugins/MoveCamera\n  Views:\n    Current:\n      \
         Class: rviz_default_plugins/Orbit\n      Distance: 2\n"
    )
}

#[cfg(test)]
mod tests {
    use super::package_name;

    #[test]
    fn packages_have_names_that_ros_allows() {
        let names = ["Oven__door", "3_legs", "cabinet_"].map(package_name);
        let due = ["oven_door_description", "asset_3_legs_description", "cabinet_description"];
        assert_eq!(names, due);
    }
}
