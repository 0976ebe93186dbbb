//! Asset to one more format each: MJCF, USD, GLB, SDFormat, packages for ROS 2, Isaac Lab and SimReady.
//! Only those asked for are in the flow.

use std::sync::Arc;

use asset::{Asset, AssetAppearance};
use runner::{Artefact, Dag, Handle, Stage, StageError};

use super::artefacts::{Glb, IsaacLab, Mjcf, Page, Ros, Sdf, Simready, Usd, Usdz};
use super::code;
use super::page::WritePage;
use super::simready::WriteSimready;
use super::tools::Tools;

/// A format the asset is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Export {
    /// URDF with its meshes; always written, because it is what gets checked
    Urdf,
    /// MuJoCo's own format; uses the meshes of the URDF
    Mjcf,
    /// USD with `UsdPhysics`, as text
    Usd,
    /// USD and its textures in one file
    Usdz,
    /// glTF with an animation per joint
    Glb,
    /// SDFormat, for Gazebo and Drake; uses the meshes of the URDF
    Sdf,
    /// A ROS 2 package
    Ros,
    /// Configurations for Isaac Lab; of the URDF
    #[value(name = "isaaclab")]
    IsaacLab,
    /// A package as NVIDIA's SimReady profile wants it
    Simready,
    /// A page for a browser; of the URDF and of what was found about it
    #[value(skip)]
    Page,
    /// Pictures of its parts and of its joints at work
    #[value(skip)]
    Pictures,
}

impl Export {
    /// Every format.
    pub const ALL: [Self; 11] = [
        Self::Urdf,
        Self::Mjcf,
        Self::Usd,
        Self::Usdz,
        Self::Glb,
        Self::Sdf,
        Self::Ros,
        Self::IsaacLab,
        Self::Simready,
        Self::Page,
        Self::Pictures,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
            Self::Usd => "usd",
            Self::Usdz => "usdz",
            Self::Glb => "glb",
            Self::Sdf => "sdf",
            Self::Ros => "ros",
            Self::IsaacLab => "isaaclab",
            Self::Simready => "simready",
            Self::Page => "page",
            Self::Pictures => "pictures",
        }
    }

    /// Whether it is there for people to look at, beside the formats for machines.
    pub fn is_for_looking(self) -> bool {
        matches!(self, Self::Page | Self::Pictures)
    }

    /// The stage that writes it and the file it is; nothing for what is several files.
    pub fn stage_and_file(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Urdf | Self::Pictures | Self::Sdf | Self::Ros | Self::Simready => None,
            Self::IsaacLab => Some((WriteIsaacLab::NAME, IsaacLab::FILE_NAME)),
            Self::Mjcf => Some((WriteMjcf::NAME, Mjcf::FILE_NAME)),
            Self::Usd => Some((WriteUsd::NAME, Usd::FILE_NAME)),
            Self::Usdz => Some((WriteUsdz::NAME, Usdz::FILE_NAME)),
            Self::Glb => Some((WriteGlb::NAME, Glb::FILE_NAME)),
            Self::Page => Some((WritePage::NAME, Page::FILE_NAME)),
        }
    }

    /// The stage that writes it as several files, what a trace calls them together, the folder they go
    /// to (with its slash, if it is one of their own) and what shows that they are there; nothing for
    /// what is one file, for the URDF's own package and for the pictures.
    pub fn package(self) -> Option<Package> {
        let of = |stage, bundle, folder, shown| Some(Package { stage, bundle, folder, shown });
        match self {
            Self::Sdf => of(WriteSdf::NAME, Sdf::FILE_NAME, "", "asset.sdf"),
            Self::Ros => of(WriteRos::NAME, Ros::FILE_NAME, "ros/", "ros"),
            Self::Simready => of(WriteSimready::NAME, Simready::FILE_NAME, "simready/", "simready"),
            _ => None,
        }
    }

    /// Adds the stage that writes it to a flow; nothing for what is written once the asset is checked.
    pub fn add_to(self, dag: &mut Dag<Tools>, asset: (Handle<Asset>, Handle<AssetAppearance>)) {
        match self {
            Self::Urdf | Self::Page | Self::Pictures => {}
            Self::Mjcf => {
                dag.stage(WriteMjcf, asset);
            }
            Self::Usd => {
                dag.stage(WriteUsd, asset);
            }
            Self::Usdz => {
                dag.stage(WriteUsdz, asset);
            }
            Self::Glb => {
                dag.stage(WriteGlb, asset);
            }
            Self::Sdf => {
                dag.stage(WriteSdf, asset);
            }
            Self::Ros => {
                dag.stage(WriteRos, asset);
            }
            Self::IsaacLab => {
                dag.stage(WriteIsaacLab, asset);
            }
            Self::Simready => {
                dag.stage(WriteSimready, asset);
            }
        }
    }
}

/// A format of several files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Package {
    /// The stage that writes it.
    pub stage: &'static str,
    /// What a trace calls all of its files together.
    pub bundle: &'static str,
    /// The folder that its files go to: nothing, or a name with a slash behind it.
    pub folder: &'static str,
    /// The file or folder to look at.
    pub shown: &'static str,
}

macro_rules! writer {
    ($(#[$doc:meta])* $stage:ident, $name:literal, $output:ident, $write:expr) => {
        $(#[$doc])*
        pub struct $stage;

        impl Stage<Tools> for $stage {
            type Input = (Arc<Asset>, Arc<AssetAppearance>);
            type Output = $output;
            const NAME: &'static str = $name;

            fn code(&self) -> String {
                code::version(&[code::ASSET])
            }

            fn run(&self, (asset, looks): Self::Input, _: &Tools) -> Result<$output, StageError> {
                let write: fn(&Asset, &AssetAppearance) -> _ = $write;
                Ok(write(&asset, &looks).into())
            }
        }
    };
}

writer!(
    /// Asset to an MJCF model.
    WriteMjcf, "write-mjcf", Mjcf, Asset::to_mjcf_with
);
writer!(
    /// Asset to a USD layer.
    WriteUsd, "write-usd", Usd, Asset::to_usd_with
);
writer!(
    /// Asset to a USDZ file.
    WriteUsdz, "write-usdz", Usdz, Asset::to_usdz_with
);
writer!(
    /// Asset to a GLB file.
    WriteGlb, "write-glb", Glb, Asset::to_glb_with
);
writer!(
    /// Asset to an SDFormat model.
    WriteSdf, "write-sdf", Sdf, Asset::to_sdf_with
);
writer!(
    /// Asset to a ROS 2 package.
    WriteRos, "write-ros", Ros, Asset::to_ros_with
);
writer!(
    /// Asset to configurations for Isaac Lab.
    WriteIsaacLab, "write-isaaclab", IsaacLab, |asset, _| asset.to_isaaclab()
);
