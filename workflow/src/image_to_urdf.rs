//! The flow: one photo to one checked URDF, one stage per line.

use adapters::{GeneratedMesh, Photo};
use object::Condition;
use runner::{Dag, Handle};

use crate::stages::{
    Articulate, BuildAsset, CheckInSim, Criticise, Export, GenerateMesh, ProposeCondition,
    RenderViews, SelectMeasures, SelectPrompts, ShapeParts, Tools, TransferAppearance, WritePage,
    WritePictures, WriteUrdf,
};

/// Name of the flow.
pub const NAME: &str = "image-to-urdf";

/// One photo to one checked URDF, to the other formats asked for, and to a critique if that is.
pub fn image_to_urdf(photo: Photo, exports: &[Export], critic: Option<Criticise>) -> Dag<Tools> {
    let mut dag = Dag::new(NAME);
    let photo = dag.input(photo);
    steps(&mut dag, photo, exports, critic);
    dag // the runner writes the trace
}

/// The first steps of the same flow: one photo to a mesh and what its parts are.
pub fn image_to_condition(photo: Photo) -> Dag<Tools> {
    let mut dag = Dag::new("image-to-condition");
    let photo = dag.input(photo);
    asked(&mut dag, photo);
    dag
}

/// The same flow, in every format, of no photo in particular: for whoever does single stages.
pub fn any_image_to_urdf() -> Dag<Tools> {
    of_any_photo(&Export::ALL)
}

/// The same in some formats.
pub fn of_any_photo(exports: &[Export]) -> Dag<Tools> {
    let mut dag = Dag::new(NAME);
    let photo = dag.blank();
    steps(&mut dag, photo, exports, None);
    dag
}

/// The first step of the same flow: one photo to a mesh.
pub fn image_to_mesh(photo: Photo) -> Dag<Tools> {
    let mut dag = Dag::new("image-to-mesh");
    let photo = dag.input(photo);
    dag.stage(GenerateMesh, photo);
    dag
}

fn steps(
    dag: &mut Dag<Tools>,
    photo: Handle<Photo>,
    exports: &[Export],
    critic: Option<Criticise>,
) {
    let (mesh, condition) = asked(dag, photo);
    let prompts = dag.stage(SelectPrompts, condition); // object: without size, mass, material
    let object = dag.stage(Articulate, (mesh, prompts)); // model: segmentation, then joints
    if let Some(critic) = critic {
        dag.stage(critic, (photo, object)); // adapters::Critic: may only flag
    }
    let measures = dag.stage(SelectMeasures, condition); // asset: size, walls, given joints
    let shapes = dag.stage(ShapeParts, (object, measures)); // asset: repair, hulls, clearance
    let asset = dag.stage(BuildAsset, (shapes, condition)); // asset: mass, drives; sim_check
    let looks = dag.stage(TransferAppearance, (asset, object, mesh)); // asset: materials, textures
    let urdf = dag.stage(WriteUrdf, (asset, looks)); // asset
    exports.iter().for_each(|format| format.add_to(dag, (asset, looks))); // asset: MJCF, USD, GLB
    let checked = dag.stage(CheckInSim, (urdf, condition)); // sim_check
    if exports.contains(&Export::Page) {
        dag.stage(WritePage, (urdf, checked)); // page
    }
    if exports.contains(&Export::Pictures) {
        dag.stage(WritePictures, urdf); // view
    }
}

fn asked(dag: &mut Dag<Tools>, photo: Handle<Photo>) -> (Handle<GeneratedMesh>, Handle<Condition>) {
    let mesh = dag.stage(GenerateMesh, photo); // adapters::ImageTo3d
    let views = dag.stage(RenderViews, mesh); // view
    let condition = dag.stage(ProposeCondition, (photo, mesh, views)); // adapters::Vlm
    (mesh, condition)
}
