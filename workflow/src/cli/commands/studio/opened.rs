//! What a studio is opened on: a photo and a mesh, or an asset that was made.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use adapters::{GeneratedMesh, MeshFile, Photo};
use object::mesh::FileFrame;
use object::{Condition, Mesh};
use studio::Picture;
use trace::Reading;

use super::ask;
use crate::cli::args::{Cli, Command, MakeArgs, StudioArgs};
use crate::cli::commands::sealed::{meant, sealed};
use crate::cli::commands::trace_extract::in_trace;
use crate::cli::commands::{given, make};
use crate::cli::speech::Complaint;

/// Conditions of one asset's folder: a guess, far above what one person begins.
const MOST: usize = 99;

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
    let mut name = whole.file_name().unwrap_or_default().to_owned();
    name.push(".studio");
    let beside = whole.with_file_name(name);
    std::fs::create_dir_all(&beside).map_err(|e| {
        Complaint::failed(format!("{}: {e}", beside.display()))
            .hint("a folder is made there for the photo, the mesh and the condition")
    })?;
    let mut remarks = Vec::new();
    let photo = reading.pictures.iter().find(|p| p.topic == "/input/photo");
    let photo = photo.ok_or_else(|| named(Complaint::failed("it has no photo")))?;
    let kind = Photo::read(photo.bytes.clone(), "photo").map_err(|e| Complaint::from_error(&e))?;
    let ending = kind.media_type.rsplit('/').next().unwrap_or("png").to_owned();
    let photo = put(&beside.join(format!("photo.{ending}")), &photo.bytes)?;
    let (name, bytes) = mesh_of(&reading).map_err(named)?;
    let mesh = put(&beside.join(name), &bytes)?;
    let made = condition_of(&reading).map_err(named)?;
    let condition = own_condition(&beside, &made, &mut remarks)?;
    Ok(Files {
        photo: Some(photo),
        mesh: Some(args.mesh.clone().unwrap_or(mesh)),
        condition: args.condition.clone().unwrap_or(condition),
        out: args.out.clone().unwrap_or_else(|| folder.to_path_buf()),
        remarks,
    })
}

/// The condition that is edited: the one that stands there if the asset was made from it, or if it was
/// begun from what the asset was made from; a new one otherwise.
fn own_condition(
    beside: &Path,
    made: &Condition,
    remarks: &mut Vec<String>,
) -> Result<PathBuf, Complaint> {
    let text = text_of(made);
    for number in 1..=MOST {
        let tail = if number == 1 { String::new() } else { format!("-{number}") };
        let condition = beside.join(format!("condition{tail}.json"));
        // What it was begun from.
        let origin = beside.join(format!("condition{tail}.begun.json"));
        if !condition.exists() {
            put(&origin, text.as_bytes())?;
            put(&condition, text.as_bytes())?;
            if number > 1 {
                let told =
                    format!("the conditions in {} are of other assets, and stay", beside.display());
                remarks.push(told);
            }
            return Ok(condition);
        }
        let read = |path: &Path| std::fs::read_to_string(path).ok();
        let is_made_from_it = read(&condition)
            .and_then(|text| Condition::from_json(&text).ok())
            .is_some_and(|there| text_of(&there) == text);
        if is_made_from_it || read(&origin).is_some_and(|begun| begun == text) {
            remarks.push(format!("{} is gone on with", condition.display()));
            return Ok(condition);
        }
    }
    Err(Complaint::failed(format!("{}: {MOST} conditions stand there already", beside.display()))
        .hint("move some of them away, or name one with --condition FILE"))
}

/// Writes a file that is not there, or finds the same one.
fn put(path: &Path, bytes: &[u8]) -> Result<PathBuf, Complaint> {
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", path.display()));
    let most = (bytes.len() as u64).saturating_add(1);
    if guard::files::read(path, most).is_ok_and(|there| there == bytes) {
        return Ok(path.to_path_buf());
    }
    let mut file = tempfile::NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")));
    let written = file.as_mut().map(|file| std::io::Write::write_all(file, bytes));
    match written {
        Ok(Ok(())) => {}
        Ok(Err(e)) => return Err(failed(e)),
        Err(_) => return file.map_err(failed).map(|_| path.to_path_buf()),
    }
    let kept = file.map_err(failed)?.persist_noclobber(path);
    kept.map(|_| path.to_path_buf()).map_err(|e| match e.error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            Complaint::failed(format!("{}: another file stands there", path.display()))
                .hint("move it away, or name files with --mesh, --condition and --out")
        }
        _ => failed(e.error),
    })
}

/// The mesh of a trace, as the generator gave it.
fn mesh_of(reading: &Reading) -> Result<(&'static str, Vec<u8>), Complaint> {
    let made = trace::verify::made(reading).filter(|(event, _)| event.stage == "generate-mesh");
    let (_, made) = made.last().ok_or_else(|| Complaint::failed("it has no mesh"))?;
    let bytes = in_trace(reading, &made.digest);
    let bytes = bytes.ok_or_else(|| Complaint::failed("its mesh is too large to stand in it"))?;
    // The trace has one name for both.
    Ok((if bytes.starts_with(b"glTF") { "mesh.glb" } else { "mesh.obj" }, bytes))
}

/// The condition of a trace, as a person would write it.
fn condition_of(reading: &Reading) -> Result<Condition, Complaint> {
    let made = trace::verify::made(reading).filter(|(event, _)| event.stage == "propose-condition");
    let (_, made) = made.last().ok_or_else(|| Complaint::failed("it has no condition"))?;
    let bytes = in_trace(reading, &made.digest);
    let bytes = bytes.ok_or_else(|| Complaint::failed("its condition does not stand in it"))?;
    let mut condition: Condition = serde_json::from_slice(&bytes)
        .map_err(|e| Complaint::failed(format!("its condition cannot be read: {e}")))?;
    // The mesh that a trace keeps has y up, whatever the file had that was given.
    condition.frame = FileFrame::default();
    Ok(condition)
}

/// A condition as the text of a file.
pub(super) fn text_of(condition: &Condition) -> String {
    let file = object::ConditionFile::from(condition);
    serde_json::to_string_pretty(&file).unwrap_or_default() + "\n"
}

/// What `make` would be asked with.
fn asked(args: &StudioArgs, files: &Files) -> Result<MakeArgs, Complaint> {
    let mut words: Vec<OsString> =
        ["kinfold", "make", "--json", "--quiet", "--no-wait"].map(OsString::from).into();
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
    words.extend(files.photo.clone().map(OsString::from));
    let cli = <Cli as clap::Parser>::try_parse_from(words);
    let Ok(Cli { command: Command::Make(mut make) }) = cli else {
        return Err(Complaint::failed("the words for `make` are not understood"));
    };
    make.up = args.up;
    Ok(make)
}
