//! Asset to one more format each: MJCF, USD, GLB. Only those asked for are in the flow.

use std::sync::Arc;

use asset::{Asset, AssetAppearance};
use runner::{Artefact, Dag, Handle, Stage, StageError};

use super::artefacts::{Glb, Mjcf, Page, Usd, Usdz};
use super::code;
use super::page::WritePage;
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
    /// A page for a browser; of the URDF and of what was found about it
    #[value(skip)]
    Page,
    /// Pictures of its parts and of its joints at work
    #[value(skip)]
    Pictures,
}

impl Export {
    /// Every format.
    pub const ALL: [Self; 7] =
        [Self::Urdf, Self::Mjcf, Self::Usd, Self::Usdz, Self::Glb, Self::Page, Self::Pictures];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
            Self::Usd => "usd",
            Self::Usdz => "usdz",
            Self::Glb => "glb",
            Self::Page => "page",
            Self::Pictures => "pictures",
        }
    }

    /// Whether it is there for people to look at, beside the formats for machines.
    pub fn is_for_looking(self) -> bool {
        matches!(self, Self::Page | Self::Pictures)
    }

    /// The stage that writes it and the file it is; nothing for what is several files: the URDF's package
    /// and the pictures.
    pub fn stage_and_file(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Urdf | Self::Pictures => None,
            Self::Mjcf => Some((WriteMjcf::NAME, Mjcf::FILE_NAME)),
            Self::Usd => Some((WriteUsd::NAME, Usd::FILE_NAME)),
            Self::Usdz => Some((WriteUsdz::NAME, Usdz::FILE_NAME)),
            Self::Glb => Some((WriteGlb::NAME, Glb::FILE_NAME)),
            Self::Page => Some((WritePage::NAME, Page::FILE_NAME)),
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
        }
    }
}

macro_rules! writer {
    ($(#[$doc:meta])* $stage:ident, $name:literal, $output:ident, $write:ident) => {
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
                Ok($output(asset.$write(&looks).into()))
            }
        }
    };
}

writer!(
    /// Asset to an MJCF model.
    WriteMjcf, "write-mjcf", Mjcf, to_mjcf_with
);
writer!(
    /// Asset to a USD layer.
    WriteUsd, "write-usd", Usd, to_usd_with
);
writer!(
    /// Asset to a USDZ file.
    WriteUsdz, "write-usdz", Usdz, to_usdz_with
);
writer!(
    /// Asset to a GLB file.
    WriteGlb, "write-glb", Glb, to_glb_with
);
