//! Small files by hand, each with one peculiarity, and the rules that it must wake: all of them but
//! notes, and no others. None of them crashes or hangs an engine; some are refused.

mod mjcf;
mod shapes;
mod urdf;
mod usd;

use std::path::{Path, PathBuf};

/// A file with one peculiarity.
pub(crate) struct Peculiar {
    /// What is peculiar; the file's name as well.
    pub(crate) name: &'static str,
    /// Its extension, without the dot.
    pub(crate) extension: &'static str,
    /// What it says.
    pub(crate) text: String,
    /// What stands beside it.
    pub(crate) beside: Vec<(&'static str, Vec<u8>)>,
    /// The rules that it must wake, parted by spaces, without notes.
    pub(crate) rules: &'static str,
}

impl Peculiar {
    /// Writes it into a folder of its own below `folder`; gives back its path.
    pub(crate) fn write(&self, folder: &Path) -> PathBuf {
        let folder = folder.join(self.name);
        std::fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in &self.beside {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        let path = folder.join(format!("{}.{}", self.name, self.extension));
        let text = self.text.replace("FOLDER", &folder.display().to_string());
        std::fs::write(&path, text).unwrap();
        path
    }
}

/// All of them; the first has nothing peculiar.
pub(crate) fn all() -> Vec<Peculiar> {
    let mut files = urdf::files();
    files.extend(shapes::files());
    files.extend(mjcf::files());
    files.extend(usd::files());
    files
}

/// A box of 0.2 m.
pub(crate) const BOX: &str = "<geometry><box size='0.2 0.2 0.2'/></geometry>";
/// What a solid one of 1 kg weighs: 1/12 * (0.04 + 0.04).
pub(crate) const SOLID: [f64; 3] = [0.006_666_7; 3];

pub(crate) fn inertial(mass: f64, [x, y, z]: [f64; 3]) -> String {
    format!(
        "<inertial><mass value='{mass}'/><inertia ixx='{x}' iyy='{y}' izz='{z}' ixy='0' ixz='0' \
         iyz='0'/></inertial>"
    )
}

/// A link: what it weighs, and its visuals and collisions.
pub(crate) fn link(name: &str, weight: &str, shapes: &str) -> String {
    format!("<link name='{name}'>{weight}{shapes}</link>")
}

/// The usual link, a box.
pub(crate) fn boxed(name: &str) -> String {
    link(name, &inertial(1.0, SOLID), &felt(BOX))
}

pub(crate) fn felt(geometry: &str) -> String {
    format!("<collision>{geometry}</collision>")
}

pub(crate) fn seen(geometry: &str) -> String {
    format!("<visual>{geometry}</visual>")
}

pub(crate) fn mesh(name: &str) -> String {
    format!("<geometry><mesh filename='{name}'/></geometry>")
}

/// A joint half a metre above its parent; `inner` is what stands in it besides.
pub(crate) fn joint(name: &str, kind: &str, parent: &str, child: &str, inner: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
         <origin xyz='0 0 0.5'/>{inner}</joint>"
    )
}

pub(crate) const AXIS: &str = "<axis xyz='0 0 1'/>";
pub(crate) const LIMIT: &str = "<limit lower='-1' upper='1' effort='5' velocity='2'/>";

/// The usual joint: a hinge from base to a.
pub(crate) fn hinge() -> String {
    joint("j", "revolute", "base", "a", &format!("{AXIS}{LIMIT}"))
}

/// A URDF of these parts.
pub(crate) fn robot(name: &'static str, parts: &[String], rules: &'static str) -> Peculiar {
    let text = format!("<robot name='m'>\n{}\n</robot>\n", parts.join("\n"));
    Peculiar { name, extension: "urdf", text, beside: Vec::new(), rules }
}

/// The usual file with this link moving.
pub(crate) fn moving(name: &'static str, a: String, rules: &'static str) -> Peculiar {
    robot(name, &[boxed("base"), a, hinge()], rules)
}
