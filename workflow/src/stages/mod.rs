//! The steps of the flow, and what they reach the outside through.

pub mod artefacts;
mod articulate;
mod build_asset;
pub mod bundle;
mod check_in_sim;
mod code;
mod criticise;
mod exports;
mod generate_mesh;
mod motion_views;
pub mod page;
mod pictures;
mod propose_condition;
mod render_views;
pub mod repair;
mod seen;
mod select_measures;
mod select_prompts;
mod shape_parts;
mod shared;
mod simready;
mod tools;
mod transfer_appearance;
mod write_urdf;

pub use artefacts::{
    Checked, Frame, Glb, IsaacLab, LinkPose, Mjcf, Page, Pictures, Prompts, Ros, Sdf, Simready,
    UrdfPackage, Usd, Usdz, Views,
};
pub use articulate::Articulate;
pub use build_asset::BuildAsset;
pub use check_in_sim::CheckInSim;
pub use criticise::Criticise;
pub use exports::{
    Export, Package, WriteGlb, WriteIsaacLab, WriteMjcf, WriteRos, WriteSdf, WriteUsd, WriteUsdz,
};
pub use generate_mesh::GenerateMesh;
pub use page::WritePage;
pub use pictures::WritePictures;
pub use propose_condition::ProposeCondition;
pub(crate) use propose_condition::explained;
pub use render_views::RenderViews;
pub use select_measures::SelectMeasures;
pub use select_prompts::SelectPrompts;
pub use shape_parts::ShapeParts;
pub use shared::Shared;
pub use simready::WriteSimready;
pub use tools::Tools;
pub use transfer_appearance::TransferAppearance;
pub use write_urdf::WriteUrdf;
