//! `kinfold points`: views of a mesh with a grid of pixels, which point of the surface each shows, and the
//! faces around it.

mod patch;

use std::path::{Path, PathBuf};

use adapters::MeshFile;
use object::Mesh;
use object::condition::Runs;
use object::mesh::{FileFrame, UpAxis};
use object::sample::SurfacePoint;
use rayon::prelude::*;
use serde_json::{Value, json};
use view::draw::{Ink, stroke, write as write_text};
use view::{Paint, Picture, Unprojector, View, caption, eight_views, encode_png, render_views};

use super::trace_extract::{is_there, write};
use crate::cli::args::PointsArgs;
use crate::cli::speech::{Answer, Complaint};

/// Width and height of the views, pixels: those that a model is shown.
const SIZE: u32 = 1024;
/// A line of the grid every so many pixels.
const LINES: u32 = 128;
/// The table's file.
const TABLE: &str = "points.json";
/// A row of the table every so many pixels.
const ROWS: u32 = 32;

/// Writes views and table, or says which point one pixel shows.
///
/// # Errors
/// [`Complaint`] when the mesh cannot be read, a view is unknown, nothing is seen at a pixel, or a file
/// cannot be written.
pub fn points(args: &PointsArgs) -> Result<Answer, Complaint> {
    let file = MeshFile { path: args.mesh.clone(), up: args.up.unwrap_or_default() };
    let mesh = file.read().map_err(|e| Complaint::from_error(&e))?.mesh;
    let frame = FileFrame { up: file.up };
    let views = eight_views(&mesh.bounds(), SIZE);
    let rays = Unprojector::new(&mesh);
    if let Some((view, pixel)) = &args.at {
        let (found, point) = at((&views, &rays, frame), (view, *pixel))?;
        let faces = args.faces.map(|bend| patch::patch(&mesh, found.face, bend.to_radians()));
        return Ok(Answer::done(match (args.json, faces) {
            (true, faces) => told((view, *pixel), (point, found.face), (&mesh, faces)),
            (false, Some(faces)) => format!("{faces}\n"),
            (false, None) => format!("[{}, {}, {}]\n", point[0], point[1], point[2]),
        }));
    }
    let out = args.out.clone().unwrap_or_else(|| beside(&args.mesh));
    let names = views.iter().map(|view| format!("{}.png", view.name)).chain([TABLE.into()]);
    let there = names.map(|name| out.join(name)).find(|path| path.symlink_metadata().is_ok());
    if let Some(path) = there.filter(|_| !args.force) {
        return Err(is_there(&path));
    }
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", out.display()));
    std::fs::create_dir_all(&out).map_err(failed)?;
    let pictures = render_views(&mesh, &Paint::Surface, &views);
    let drawn = views.par_iter().zip(pictures).map(|(view, picture)| {
        let png =
            encode_png(&gridded(picture, view.name)).map_err(|e| Complaint::from_error(&e))?;
        Ok((format!("{}.png", view.name), png))
    });
    let mut files = drawn.collect::<Result<Vec<_>, Complaint>>()?;
    files.push((TABLE.into(), table((&mesh, frame), &views, &rays).into_bytes()));
    for (name, bytes) in &files {
        write(&out.join(name), bytes, args.force)?;
    }
    let told = |name: &str| guard::text::shown(&out.join(name).to_string_lossy()).into_owned();
    let result = match args.json {
        true => format!(
            "{:#}\n",
            json!({ "files": files.iter().map(|(n, _)| told(n)).collect::<Vec<_>>() })
        ),
        false => files.iter().map(|(name, _)| told(name) + "\n").collect(),
    };
    Ok(Answer::done(result))
}

/// `MESH.points`, in the working folder.
fn beside(mesh: &Path) -> PathBuf {
    let mut name = mesh.file_stem().unwrap_or(mesh.as_os_str()).to_os_string();
    name.push(".points");
    PathBuf::from(name)
}

/// The point that one pixel of one view shows.
fn at(
    (views, rays, frame): (&[View], &Unprojector, FileFrame),
    (name, pixel): (&str, [f64; 2]),
) -> Result<(SurfacePoint, [f64; 3]), Complaint> {
    let Some(view) = views.iter().find(|view| view.name == name) else {
        let names: Vec<&str> = views.iter().map(|view| view.name).collect();
        let told = format!("no view is called `{}`", guard::text::shown(name));
        return Err(Complaint::misused(told).hint(format!("there are {}", names.join(", "))));
    };
    let [x, y] = pixel;
    if !view.camera.holds(pixel) {
        let told = format!("pixel {x}, {y} lies outside of the view, which is {SIZE} x {SIZE}");
        return Err(Complaint::misused(told));
    }
    let Some(found) = rays.pixel(&view.camera, pixel) else {
        let told =
            format!("pixel {x}, {y} of the view {name} shows background, of {SIZE} x {SIZE}");
        return Err(
            Complaint::failed(told).hint("`kinfold points MESH` writes the views with a grid")
        );
    };
    Ok((found, written(frame, &found)))
}

/// What a pixel shows, in JSON; with the faces around it and the mesh they are counted in, where they were
/// asked for.
fn told(
    (view, pixel): (&str, [f64; 2]),
    (point, face): ([f64; 3], u32),
    (mesh, faces): (&Mesh, Option<Runs>),
) -> String {
    let mut value = json!({ "view": view, "pixel": pixel, "point": point, "face": face });
    if let Some(faces) = faces {
        value["mesh"] = json!(mesh.digest());
        value["faces"] = json!(faces);
    }
    format!("{value}\n")
}

/// A point as a condition has it: file coordinates, to a hundred-thousandth of the file's unit or six digits.
fn written(frame: FileFrame, found: &SurfacePoint) -> [f64; 3] {
    frame.point_to_file(found.position).to_array().map(|c| {
        let digits = format!("{c:.6}").parse().unwrap_or(c);
        if digits == 0.0 { 0.0 } else { digits }
    })
}

/// For each view, what the surface shows every [`ROWS`] pixels, and the faces of all that hangs together.
fn table((mesh, frame): (&Mesh, FileFrame), views: &[View], rays: &Unprojector) -> String {
    let (pieces, piece_of_face) = patch::pieces(mesh);
    let of = |view: &View| {
        let steps = || (ROWS / 2..SIZE).step_by(ROWS as usize);
        let spots = steps().flat_map(|y| steps().map(move |x| [f64::from(x), f64::from(y)]));
        let spots: Vec<[f64; 2]> = spots.collect();
        let row = |pixel: &[f64; 2]| {
            let found = rays.pixel(&view.camera, *pixel)?;
            let piece = piece_of_face.get(found.face as usize);
            let point = written(frame, &found);
            Some(json!({ "pixel": pixel, "point": point, "face": found.face, "piece": piece }))
        };
        let rows: Vec<Value> = spots.par_iter().filter_map(row).collect();
        (view.name.to_owned(), Value::from(rows))
    };
    let views: serde_json::Map<String, Value> = views.iter().map(of).collect();
    let up = if frame.up == UpAxis::Z { "z" } else { "y" };
    let table = json!({
        "mesh": mesh.digest(),
        "up": up,
        "size": [SIZE, SIZE],
        "pieces": pieces,
        "views": views,
    });
    format!("{table:#}\n")
}

/// A view with lines every [`LINES`] pixels, each with its number, and its name.
fn gridded(mut picture: Picture, name: &str) -> Picture {
    let side = f64::from(SIZE);
    let ink = Ink { colour: [20, 60, 160], opacity: 0.45 };
    for at in (LINES..SIZE).step_by(LINES as usize) {
        let here = f64::from(at);
        stroke(&mut picture, [[here, 0.0], [here, side]], 0.6, ink);
        stroke(&mut picture, [[0.0, here], [side, here]], 0.6, ink);
        let number = Ink::solid([20, 60, 160]);
        write_text(&mut picture, [here + 4.0, side - 20.0], 1.6, number, &at.to_string());
        write_text(&mut picture, [4.0, here + 4.0], 1.6, number, &at.to_string());
    }
    caption(&mut picture, &name.replace('_', " "));
    picture
}
