//! Meshes as arrays, and arrays as meshes: flat, by rows, in the mesh file's own frame.

use std::path::PathBuf;

use adapters::MeshFile;
use object::mesh::{FileFrame, MAX_FACES, MAX_VERTICES, MeshError, UpAxis};
use object::{DVec3, Mesh};
use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::errors::Wrong;
use crate::threads::alone;

impl From<MeshError> for Wrong {
    fn from(error: MeshError) -> Self {
        let wrong = Self::of("MeshError", &error);
        match error {
            MeshError::IndexOutOfRange { .. } => {
                wrong.hint("faces count vertices from 0; files that count from 1 need `faces - 1`")
            }
            MeshError::NotFinite { .. } => {
                wrong.hint("leave out or mend vertices that are not numbers")
            }
            _ => wrong,
        }
    }
}

/// An up axis by its letter.
pub(crate) fn up_axis(up: &str) -> Result<UpAxis, Wrong> {
    match up {
        "y" => Ok(UpAxis::Y),
        "z" => Ok(UpAxis::Z),
        _ => Err(Wrong::input(format!("up: expected \"y\" or \"z\", found {up:?}"))),
    }
}

/// A mesh of rows: three f64 a vertex, three i64 a face, four u8 a colour.
pub(crate) fn mesh(
    py: Python<'_>,
    (vertices, faces): (&Bound<'_, PyAny>, &Bound<'_, PyAny>),
    colours: Option<&Bound<'_, PyAny>>,
    up: UpAxis,
) -> PyResult<Mesh> {
    let frame = FileFrame { up };
    let wrong = |error: MeshError| Wrong::from(error).raised(py);
    let vertices = rows::<f64, 3>(py, vertices, ("vertices", MAX_VERTICES))?;
    let faces = rows::<i64, 3>(py, faces, ("triangles", MAX_FACES))?;
    let count = vertices.len();
    let mut corners = Vec::with_capacity(faces.len());
    for (face, corner) in faces.into_iter().enumerate() {
        if let Some(odd) = corner.iter().find(|v| u32::try_from(**v).is_err()) {
            let found = format!("face {face} uses vertex {odd}, but the mesh has {count} vertices");
            let hint = "faces count vertices from 0 and upwards";
            return Err(Wrong::input(found).of_class("MeshError").hint(hint).raised(py));
        }
        corners.push(corner.map(|v| v as u32));
    }
    let vertices = vertices.into_iter().map(|v| frame.point_to_object(DVec3::from_array(v)));
    let mesh = Mesh::new(vertices.collect(), corners).map_err(wrong)?.with_frame(frame);
    let colours = colours.map(|c| rows::<u8, 4>(py, c, ("colours", MAX_VERTICES))).transpose()?;
    mesh.with_colours(colours).map_err(wrong)
}

/// The rows of a buffer of such numbers, as they are; more than a mesh may have are not even copied.
fn rows<E: Element, const N: usize>(
    py: Python<'_>,
    from: &Bound<'_, PyAny>,
    (what, most): (&'static str, usize),
) -> PyResult<Vec<[E; N]>> {
    let buffer = PyBuffer::<E>::get(from)?;
    let shape = buffer.shape();
    if shape.len() != 2 || shape[1] != N {
        let found = format!("{what}: expected rows of {N} numbers, found the shape {shape:?}");
        return Err(Wrong::input(found).of_class("MeshError").raised(py));
    }
    if shape[0] > most {
        let error = MeshError::TooLarge { what, limit: most, found: shape[0] };
        return Err(Wrong::from(error).raised(py));
    }
    let all = buffer.to_vec(py)?;
    let (rows, _) = all.as_chunks::<N>();
    Ok(rows.to_vec())
}

/// The bytes of some numbers, as an array of Python reads them on this machine.
pub(crate) fn bytes<const N: usize>(
    py: Python<'_>,
    numbers: impl ExactSizeIterator<Item = [u8; N]>,
) -> PyResult<Bound<'_, PyByteArray>> {
    PyByteArray::new_with(py, numbers.len() * N, |space| {
        let (chunks, _) = space.as_chunks_mut::<N>();
        chunks.iter_mut().zip(numbers).for_each(|(chunk, number)| *chunk = number);
        Ok(())
    })
}

/// The bytes of points in a file's frame.
pub(crate) fn points<'py>(
    py: Python<'py>,
    frame: FileFrame,
    points: impl ExactSizeIterator<Item = DVec3>,
) -> PyResult<Bound<'py, PyByteArray>> {
    let all: Vec<f64> = points.flat_map(|p| frame.point_to_file(p).to_array()).collect();
    bytes(py, all.into_iter().map(f64::to_ne_bytes))
}

/// The bytes of corners of faces, i64.
pub(crate) fn corners<'py>(
    py: Python<'py>,
    faces: &[[u32; 3]],
) -> PyResult<Bound<'py, PyByteArray>> {
    let all: Vec<i64> = faces.iter().flatten().map(|&v| i64::from(v)).collect();
    bytes(py, all.into_iter().map(i64::to_ne_bytes))
}

/// Vertices, faces and colours as bytes of f64, i64 and u8, and the up axis that they have.
type Arrays<'py> = (
    Bound<'py, PyByteArray>,
    Bound<'py, PyByteArray>,
    Option<Bound<'py, PyByteArray>>,
    &'static str,
);

/// Reads a mesh file of any format that `kinfold make` takes, with what lies beside it.
#[pyfunction]
pub(crate) fn read_mesh<'py>(py: Python<'py>, path: PathBuf, up: &str) -> PyResult<Arrays<'py>> {
    let up = up_axis(up).map_err(|wrong| wrong.raised(py))?;
    let read = alone(py, move || Ok(MeshFile { path, up }.read()?.mesh))?;
    let colours = read.colours().map(|all| bytes(py, all.iter().copied())).transpose()?;
    let vertices = points(py, read.frame(), read.vertices().iter().copied())?;
    let up = if read.frame().up == UpAxis::Z { "z" } else { "y" };
    Ok((vertices, corners(py, read.faces())?, colours, up))
}

/// A mesh as a GLB file: y up, single precision.
#[pyfunction]
pub(crate) fn write_glb<'py>(
    py: Python<'py>,
    vertices: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    colours: Option<&Bound<'py, PyAny>>,
    up: &str,
) -> PyResult<Bound<'py, pyo3::types::PyBytes>> {
    let up = up_axis(up).map_err(|wrong| wrong.raised(py))?;
    let mesh = mesh(py, (vertices, faces), colours, up)?;
    let glb = py.detach(|| object::glb::write(&mesh.with_frame(FileFrame::default())));
    Ok(pyo3::types::PyBytes::new(py, &glb))
}

/// The digest that a condition's painted faces name their mesh by.
#[pyfunction]
pub(crate) fn mesh_digest(
    py: Python<'_>,
    vertices: &Bound<'_, PyAny>,
    faces: &Bound<'_, PyAny>,
    up: &str,
) -> PyResult<String> {
    let up = up_axis(up).map_err(|wrong| wrong.raised(py))?;
    let mesh = mesh(py, (vertices, faces), None, up)?;
    Ok(py.detach(|| mesh.digest()))
}
