//! A mesh and a condition that were given as files: read before anything is made of them, so that all that
//! is wrong with them is said at once.

use adapters::{AdapterError, ConditionFile, GeneratedMesh, MeshFile, Photo};
use object::Condition;
use object::mesh::UpAxis;
use runner::StageError;

use crate::cli::args::MakeArgs;
use crate::cli::speech::Complaint;
use crate::pictured;
use crate::stages::explained;

/// An object lies on its back, perhaps, if it is deeper than high and wide by this: a guess.
const DEEPER: f64 = 1.2;

/// The mesh that was given, as it is to be read: with the up axis that was said, else with that of a
/// condition that was given beside it.
pub(super) fn mesh(args: &MakeArgs) -> Option<MeshFile> {
    let path = args.mesh.clone()?;
    Some(match args.up {
        Some(up) => MeshFile { path, up },
        None => MeshFile::beside(path, condition(args).as_ref()),
    })
}

/// The photo that was given; without one, a view of the mesh that was given stands in its place.
///
/// # Errors
/// [`AdapterError`], naming the file, the rule and what was found.
pub(super) fn photo(args: &MakeArgs) -> Result<Photo, AdapterError> {
    pictured::photo(args.photo.as_deref(), mesh(args))
}

/// The condition that was given, as it is to be read.
pub(super) fn condition(args: &MakeArgs) -> Option<ConditionFile> {
    let path = args.condition.clone()?;
    Some(ConditionFile { path, snap: args.snap, up: args.up.unwrap_or_default() })
}

/// Refuses a condition that does not fit the mesh it was given with, or says what should be known of them.
///
/// # Errors
/// [`StageError`], with everything that is wrong with the condition. What is wrong with the mesh is said by
/// who reads it.
pub(super) fn looked_at(args: &MakeArgs) -> Result<Vec<String>, StageError> {
    let Some(file) = condition(args) else { return Ok(vec![]) };
    let failed = |e: AdapterError| explained(&e);
    let Some(mesh) = mesh(args).and_then(|mesh| mesh.read().ok()) else {
        return file.read().map(|_| vec![]).map_err(failed);
    };
    let (condition, moved) = file.of(&mesh.mesh).map_err(failed)?;
    Ok(remarks((args, moved), &mesh, &condition))
}

/// Refuses an up axis that the condition contradicts.
///
/// # Errors
/// [`Complaint`], naming both.
pub(super) fn agree(args: &MakeArgs) -> Result<(), Complaint> {
    let said = condition(args).and_then(|file| file.read().ok()).map(|c| c.frame.up);
    match (args.up, said) {
        (Some(up), Some(said)) if up != said => {
            let name = |up| if up == UpAxis::Y { "y" } else { "z" };
            let told = format!("--up {}, but the condition says `up` is {}", name(up), name(said));
            Err(Complaint::misused(told).hint("leave out one of the two"))
        }
        _ => Ok(()),
    }
}

fn remarks(
    (args, moved): (&MakeArgs, usize),
    mesh: &GeneratedMesh,
    condition: &Condition,
) -> Vec<String> {
    let mut remarks = Vec::new();
    if args.photo.is_none() {
        remarks.push("no photo was given: a view of the mesh stands in its place".to_owned());
    }
    if moved > 0 {
        let points = if moved == 1 { "point was" } else { "points were" };
        remarks.push(format!("{moved} {points} moved onto the mesh (--snap)"));
    }
    let size = mesh.mesh.bounds().size();
    if condition.size.is_none() {
        remarks.push(format!(
            "size unknown: the mesh file's unit is taken as a metre, so it is {:.2} m high; say `size` in \
             the condition",
            size.z
        ));
    }
    if args.up.is_none() && condition.frame.up == UpAxis::Y && size.y > DEEPER * size.z.max(size.x)
    {
        remarks.push(format!(
            "the mesh is {:.2} deep, {:.2} wide and {:.2} high: if it lies on its back, say --up z",
            size.y, size.x, size.z
        ));
    }
    remarks
}
