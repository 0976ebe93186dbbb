//! What a studio is opened on: a photo and a mesh, or an asset that was made.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use adapters::{GeneratedMesh, MeshFile, Photo};
use object::{Condition, Mesh};
use studio::Picture;
use trace::Reading;

use super::ask;
use crate::cli::args::{Cli, Command, MakeArgs, StudioArgs};
use crate::cli::commands::sealed::{meant, sealed};
use crate::cli::commands::trace_extract::in_trace;
use crate::cli::commands::{given, make};
use crate::cli::speech::Complaint;

/// What a studio is opened on.
pub(super) struct Opened {
    /// What it is called.
    pub title: String,
    /// What `make` is asked with.
    pub make: MakeArgs,
    /// The photo.
    pub photo: Option<Picture>,
    /// The mesh's file, or who made it.
    pub mesh_name: String,
    /// The mesh.
    pub mesh: Mesh,
    /// The condition file.
    pub condition: PathBuf,
    /// Where an asset goes.
    pub out: PathBuf,
    /// What a person should know.
    pub remarks: Vec<String>,
}

/// The files a studio works on.
struct Files {
    photo: Option<PathBuf>,
    mesh: Option<PathBuf>,
    condition: PathBuf,
    out: PathBuf,
    remarks: Vec<String>,
}

/// Opens what was named.
///
/// # Errors
/// [`Complaint`] when a file cannot be read, or nobody makes a mesh.
pub(super) fn opened(args: &StudioArgs) -> Result<Opened, Complaint> {
    let files = files(args)?;
    let make = asked(args, &files)?;
    given::agree(&make)?;
    let photo = files.photo.as_deref().map(picture).transpose()?;
    let (mesh_name, mesh) = match given::mesh(&make) {
        Some(file) => read(&file)?,
        None => ("the generator's".to_owned(), ask::mesh(&make)?.mesh),
    };
    let named = files.photo.as_deref().or(files.mesh.as_deref()).unwrap_or(Path::new("object"));
    let title = match args.path.as_deref().filter(|path| path.is_dir()) {
        Some(folder) => stem(folder),
        None => stem(named),
    };
    let Files { condition, out, remarks, .. } = files;
    Ok(Opened { title, make, photo, mesh_name, mesh, condition, out, remarks })
}

fn read(file: &MeshFile) -> Result<(String, Mesh), Complaint> {
    let GeneratedMesh { mesh, .. } = file.read().map_err(|e| Complaint::from_error(&e))?;
    let name = file.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((guard::text::shown(&name).into_owned(), mesh))
}

fn picture(path: &Path) -> Result<Picture, Complaint> {
    let photo = Photo::open(path).map_err(|e| Complaint::from_error(&e))?;
    let media_type = photo.media_type.clone();
    Ok(Picture { bytes: photo.bytes, media_type })
}

fn files(args: &StudioArgs) -> Result<Files, Complaint> {
    match &args.path {
        Some(folder) if folder.is_dir() => of_asset(args, folder),
        path => {
            let named = path.as_deref().or(args.mesh.as_deref()).unwrap_or(Path::new("object"));
            let condition = || PathBuf::from(format!("{}.condition.json", stem(named)));
            Ok(Files {
                photo: path.clone(),
                mesh: args.mesh.clone(),
                condition: args.condition.clone().unwrap_or_else(condition),
                out: args.out.clone().unwrap_or_else(|| make::default_out(named)),
                remarks: vec![],
            })
        }
    }
}

/// A name without its ending.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// What an asset was made from, out of its trace, into a folder beside it; what stands there already is
/// gone on with.
fn of_asset(args: &StudioArgs, folder: &Path) -> Result<Files, Complaint> {
    let trace = meant(folder);
    if trace == folder {
        let message = format!(
            "{}: expected an asset that was made, found no trace.mcap in it",
            folder.display()
        );
        return Err(Complaint::misused(message).hint("name a photo, with --mesh FILE, instead"));
    }
    let named =
        |c: Complaint| Complaint { message: format!("{}: {}", trace.display(), c.message), ..c };
    let reading = sealed(&trace).map_err(named)?;
    let whole = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    let beside = whole.with_file_name(format!("{}.studio", stem(&whole)));
    std::fs::create_dir_all(&beside)
        .map_err(|e| Complaint::failed(format!("{}: {e}", beside.display())))?;
    let mut remarks = Vec::new();
    let photo = reading.pictures.iter().find(|p| p.topic == "/input/photo");
    let photo = photo.ok_or_else(|| named(Complaint::failed("it has no photo")))?;
    let kind = Photo::read(photo.bytes.clone(), "photo").map_err(|e| Complaint::from_error(&e))?;
    let ending = kind.media_type.rsplit('/').next().unwrap_or("png").to_owned();
    let photo = put(&beside.join(format!("photo.{ending}")), &photo.bytes)?;
    let (name, bytes) = mesh_of(&reading).map_err(named)?;
    let mesh = put(&beside.join(name), &bytes)?;
    let condition = beside.join("condition.json");
    if condition.exists() {
        remarks.push(format!("{} is gone on with", condition.display()));
    } else {
        put(&condition, condition_of(&reading).map_err(named)?.as_bytes())?;
    }
    Ok(Files {
        photo: Some(photo),
        mesh: Some(args.mesh.clone().unwrap_or(mesh)),
        condition: args.condition.clone().unwrap_or(condition),
        out: args.out.clone().unwrap_or_else(|| folder.to_path_buf()),
        remarks,
    })
}

/// Writes a file that is not there, or finds the same one.
fn put(path: &Path, bytes: &[u8]) -> Result<PathBuf, Complaint> {
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", path.display()));
    let most = (bytes.len() as u64).saturating_add(1);
    if guard::files::read(path, most).is_ok_and(|there| there == bytes) {
        return Ok(path.to_path_buf());
    }
    let file = std::fs::OpenOptions::new().write(true).create_new(true).open(path);
    let mut file = file.map_err(|e| match e.kind() {
        std::io::ErrorKind::AlreadyExists => {
            Complaint::failed(format!("{}: another file stands there", path.display()))
                .hint("move it away, or name files with --mesh, --condition and --out")
        }
        _ => failed(e),
    })?;
    std::io::Write::write_all(&mut file, bytes).map_err(failed)?;
    Ok(path.to_path_buf())
}

/// The mesh of a trace, as the generator gave it.
fn mesh_of(reading: &Reading) -> Result<(&'static str, Vec<u8>), Complaint> {
    let made = trace::verify::made(reading).filter(|(event, _)| event.stage == "generate-mesh");
    let (_, made) = made.last().ok_or_else(|| Complaint::failed("it has no mesh"))?;
    let bytes = in_trace(reading, &made.digest);
    let bytes = bytes.ok_or_else(|| Complaint::failed("its mesh is too large to stand in it"))?;
    Ok((if made.name.ends_with(".obj") { "mesh.obj" } else { "mesh.glb" }, bytes))
}

/// The condition of a trace, as a person would write it.
fn condition_of(reading: &Reading) -> Result<String, Complaint> {
    let made = trace::verify::made(reading).filter(|(event, _)| event.stage == "propose-condition");
    let (_, made) = made.last().ok_or_else(|| Complaint::failed("it has no condition"))?;
    let bytes = in_trace(reading, &made.digest);
    let bytes = bytes.ok_or_else(|| Complaint::failed("its condition does not stand in it"))?;
    let condition: Condition = serde_json::from_slice(&bytes)
        .map_err(|e| Complaint::failed(format!("its condition cannot be read: {e}")))?;
    Ok(text_of(&condition))
}

/// A condition as the text of a file.
pub(super) fn text_of(condition: &Condition) -> String {
    let file = object::ConditionFile::from(condition);
    serde_json::to_string_pretty(&file).unwrap_or_default() + "\n"
}

/// What `make` would be asked with.
fn asked(args: &StudioArgs, files: &Files) -> Result<MakeArgs, Complaint> {
    let mut words: Vec<OsString> =
        ["kinfold", "make", "--json", "--quiet"].map(OsString::from).into();
    let mut option = |name: &str, value: Option<OsString>| {
        words.extend(value.map(|value| {
            let mut word = OsString::from(format!("--{name}="));
            word.push(value);
            word
        }));
    };
    option("mesh", files.mesh.clone().map(Into::into));
    option("condition", Some(files.condition.clone().into()));
    option("out", Some(files.out.clone().into()));
    option("config", args.config.clone().map(Into::into));
    option("state", args.state.clone().map(Into::into));
    if args.trust_config {
        words.push("--trust-config".into());
    }
    words.push("--".into());
    // Where there is none, nothing is made.
    words.push(files.photo.clone().unwrap_or_else(|| "no photo".into()).into());
    let cli = <Cli as clap::Parser>::try_parse_from(words);
    let Ok(Cli { command: Command::Make(mut make) }) = cli else {
        return Err(Complaint::failed("the words for `make` are not understood"));
    };
    make.up = args.up;
    Ok(make)
}
