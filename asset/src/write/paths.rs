//! Where the meshes of an asset lie, the same for every format that names files.

use crate::asset::Link;
use crate::write::appearance::look::AssetAppearance;

/// Where a link's meshes are written.
pub(crate) struct MeshPaths {
    /// One for each material; one where nothing is known of materials.
    pub(crate) visuals: Vec<String>,
    pub(crate) collision: Vec<String>,
}

impl MeshPaths {
    /// The first of what is seen.
    pub(crate) fn visual(&self) -> &str {
        self.visuals.first().map_or("", String::as_str)
    }

    /// Where the materials of the link are written.
    pub(crate) fn materials(&self) -> String {
        self.visual().replace(".obj", ".mtl")
    }
}

/// Paths that stay apart on file systems that do not tell case.
pub(crate) fn mesh_paths(links: &[Link], appearance: &AssetAppearance) -> Vec<MeshPaths> {
    let mut taken: Vec<String> = Vec::new();
    let mut free = |stem: &str| {
        let numbered = (2..).map(|n| format!("{stem}_{n}"));
        let mut candidates = std::iter::once(stem.to_string()).chain(numbered);
        let is_free = |s: &String| !taken.contains(&s.to_lowercase());
        let stem = candidates.find(is_free).unwrap_or_default();
        taken.push(stem.to_lowercase());
        format!("meshes/{stem}.obj")
    };
    let paths = |(index, link): (usize, &Link)| {
        let pieces = link.body.as_ref().map_or(0, |b| b.collision.len());
        let groups = appearance.groups(index).iter().skip(1);
        let names = std::iter::once(&link.name).chain(groups.map(|g| &g.name));
        MeshPaths {
            visuals: names.map(|n| free(n)).collect(),
            collision: (0..pieces).map(|i| free(&format!("{}_c{i:02}", link.name))).collect(),
        }
    };
    links.iter().enumerate().map(paths).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asset::Inertial;
    use glamx::{DMat3, DVec3};
    use object::{Origin, Sourced};

    fn carrier(name: &str) -> Link {
        let inertial = Inertial {
            mass: Sourced::new(1.0, Origin::Default, ""),
            centre: Sourced::new(DVec3::ZERO, Origin::Default, ""),
            inertia: Sourced::new(DMat3::IDENTITY, Origin::Default, ""),
        };
        let (name, label) = (name.into(), String::new());
        Link { name, part: 0, label, frame: DVec3::ZERO, inertial, body: None }
    }

    #[test]
    fn names_that_differ_in_case_alone_get_files_apart() {
        let links = ["Door", "door", "DOOR_2", "knob"].map(carrier);
        let paths = mesh_paths(&links, &AssetAppearance::default());
        let visual: Vec<&str> = paths.iter().map(MeshPaths::visual).collect();
        let due =
            ["meshes/Door.obj", "meshes/door_2.obj", "meshes/DOOR_2_2.obj", "meshes/knob.obj"];
        assert_eq!(visual, due);
        assert!(paths.iter().all(|p| p.collision.is_empty()));
    }
}
