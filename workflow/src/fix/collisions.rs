//! Collision geometry that is missing, concave or off: G2, G3.

use guard::text::markup;
use sim_check::profile::bounds::COVER;
use sim_check::read::source::{At, Edit};
use sim_check::robot::{Geometry, Link, Shape};

use super::lines::obj;
use super::offer::{Change, Job, NewFile, Offer, State, names, quoted};
use super::remedies::Way;

/// Most pieces that are put in for one shape; more than a link may have is of no use to G2.
const MOST: usize = sim_check::profile::bounds::PIECES;
/// How many times further off pieces may lie where the closest ones are not approved of; a guess.
const COARSER: f64 = 3.0;
/// The group of geoms that MuJoCo's viewer leaves out, by its convention for collision geometry.
const UNSEEN: &str = "3";

/// What a way offers for each link that is named in the findings.
pub(super) fn offers(
    (state, job): (&State, &Job),
    way: Way,
    findings: &[(&str, &str)],
) -> Vec<Offer> {
    match way {
        Way::Split => split(state, job, findings),
        Way::Touch | Way::Cover => {
            let all = findings.iter().any(|(_, f)| quoted(f, "link").is_none());
            let named = names(findings, "link");
            let bare = |l: &&Link| l.collisions.is_empty() && !l.visuals.is_empty();
            let links = state.robot.links.iter();
            let due: Vec<&Link> = match way {
                Way::Touch => {
                    links.filter(bare).filter(|l| all || named.contains(&l.name.as_str())).collect()
                }
                _ => links
                    .filter(|l| named.contains(&l.name.as_str()) && !l.visuals.is_empty())
                    .filter(|l| !l.collisions.is_empty())
                    .collect(),
            };
            due.into_iter().map(|link| covered(state, job, link, way)).collect()
        }
        _ => Vec::new(),
    }
}

/// The element of a link or body.
fn link_at(state: &State, link: &Link) -> Result<At, String> {
    let tag = if state.is_urdf() { "link" } else { "body" };
    state.element(tag, &link.name, link.line)
}

/// Where new meshes are to stand, and how the model names that place.
pub(super) struct Place {
    /// Before the name of a file, as it is written in the model.
    written: String,
    /// Before the name of a file, as it is read.
    read: String,
    folder: std::path::PathBuf,
    stem: String,
}

impl Place {
    /// Beside a mesh that the model names; beside the model itself where that lies outside.
    pub(super) fn beside(state: &State, job: &Job, source: &str) -> Result<Self, String> {
        let strips = meshes(state);
        let name = source.rsplit('/').next().unwrap_or(source);
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        let stem: String = stem
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' })
            .collect();
        let (path, _) = state.mesh_file(job, source)?;
        let is_far = source.starts_with('/') || source.starts_with("file:");
        let folder = path.parent().filter(|_| !is_far);
        let home = job.file.parent().unwrap_or(std::path::Path::new("")).to_path_buf();
        let read = match (source.rfind('/'), is_far) {
            (Some(end), false) => source[..=end].to_owned(),
            _ => strips.clone(),
        };
        let written = read.strip_prefix(strips.as_str()).unwrap_or(&read).to_owned();
        let folder = folder.map_or(home, std::path::Path::to_path_buf);
        Ok(Self { written, read, folder, stem })
    }

    /// A file that stands nowhere yet, and the name that the model gives it.
    pub(super) fn file(
        &self,
        (state, taken): (&State, &[NewFile]),
        (what, ending): (&str, &str),
        bytes: Vec<u8>,
    ) -> (NewFile, String) {
        let mut number = 1;
        loop {
            let more = if number == 1 { String::new() } else { format!("_{number}") };
            let name = format!("{}_{what}{more}.{ending}", self.stem);
            let (read, path) = (format!("{}{name}", self.read), self.folder.join(&name));
            let is_taken = state.edition.added.contains_key(&read)
                || taken.iter().any(|f| f.name == read)
                || path.symlink_metadata().is_ok();
            if !is_taken {
                let written = format!("{}{name}", self.written);
                return (NewFile { name: read, path, bytes }, written);
            }
            number += 1;
        }
    }
}

/// The folder that an MJCF model's compiler takes meshes from, with its slash.
pub(super) fn meshes(state: &State) -> String {
    let source = &state.source;
    let compilers = source.children(source.root(), "compiler");
    let told = compilers.iter().rev().find_map(|c| {
        let told = source.get(*c, "meshdir").or(source.get(*c, "assetdir"))?;
        Some(told.trim().trim_end_matches('/')).filter(|t| !t.is_empty())
    });
    told.filter(|_| !state.is_urdf()).map_or(String::new(), |t| format!("{t}/"))
}

/// Convex pieces of a mesh and how they are to be called in evidence.
fn pieces(job: &Job, mesh: &object::Mesh, tolerance: f64) -> Result<Vec<object::Mesh>, String> {
    let made = (job.split)(mesh, tolerance)?;
    match made.len() {
        0 => Err("it gives no convex pieces".into()),
        n if n > MOST => {
            Err(format!("it takes {n} convex pieces, more than the {MOST} a link may have"))
        }
        _ => Ok(made),
    }
}

/// New files of pieces, and their names as the model writes them.
fn written(
    (state, job): (&State, &Job),
    source: &str,
    pieces: &[object::Mesh],
    files: &mut Vec<NewFile>,
) -> Result<Vec<String>, String> {
    let place = Place::beside(state, job, source)?;
    let mut names = Vec::new();
    for piece in pieces {
        let (file, name) = place.file((state, files), ("convex", "obj"), obj(piece));
        files.push(file);
        names.push(name);
    }
    Ok(names)
}

/// For each collision shape that is named: convex pieces of its mesh in its place.
fn split(state: &State, job: &Job, findings: &[(&str, &str)]) -> Vec<Offer> {
    let mut offers = Vec::new();
    let mut seen = Vec::new();
    for (_, finding) in findings {
        let Some(name) = quoted(finding, "link") else { continue };
        let after = finding.find("`: ").map_or("", |at| &finding[at + 2..]);
        let Some(label) = quoted(after, "") else { continue };
        let Some(line) = line_of(after) else { continue };
        let Some(link) = state.robot.links.iter().find(|l| l.name == name) else { continue };
        let is_it = |s: &&Shape| s.line == line && s.source == label;
        for shape in link.collisions.iter().filter(is_it) {
            let key = (name.to_owned(), line, std::ptr::from_ref(shape) as usize);
            if seen.contains(&key) {
                continue;
            }
            seen.push(key);
            let is_this = |f: &str| f.contains(&format!("`{label}` (line {line})"));
            let is_dented = findings.iter().any(|(_, f)| is_this(f) && f.contains("not convex"));
            let pieces = split_one((state, job), link, shape, false);
            // What is convex but for its holes is smallest as one hull.
            let whole = split_one((state, job), link, shape, true).ok().filter(|_| !is_dented);
            let changes = match (whole, pieces) {
                (whole, Ok(pieces)) => Ok(whole.into_iter().chain([pieces]).collect()),
                (Some(whole), Err(_)) => Ok(vec![whole]),
                (None, Err(why)) => Err(why),
            };
            let subject = format!("link `{name}`, `{label}`");
            offers.push(Offer { way: Way::Split, subject, line, changes });
        }
    }
    offers
}

/// The line in "(line 12)".
fn line_of(text: &str) -> Option<u32> {
    let from = text.find("(line ")? + 6;
    text[from..].split(')').next()?.parse().ok()
}

/// `whole`: by its one hull.
fn split_one(
    (state, job): (&State, &Job),
    link: &Link,
    shape: &Shape,
    whole: bool,
) -> Result<Change, String> {
    let Geometry::Mesh(mesh) = &shape.geometry else {
        return Err("it is no mesh: give it another size".into());
    };
    let source = &state.source;
    let made = match whole {
        true => vec![super::lines::hull(mesh)?],
        false => pieces(job, mesh, COVER.of(state.diagonal()))?,
    };
    let mut files = Vec::new();
    let names = written((state, job), &shape.source, &made, &mut files)?;
    let words = format!("{} in place of `{}`", counted(made.len()), shape.source);
    let at = link_at(state, link)?;
    if !state.is_urdf() {
        let geom = source.on_line("geom", shape.line).filter(|g| source.parent(*g) == Some(at));
        let geom = geom.ok_or_else(|| state.elsewhere("geom", shape.line))?;
        let mut edits = ["contype", "conaffinity"].map(|bit| source.set(geom, bit, "0")).to_vec();
        edits.extend(geoms((state, at, geom), &names, &files)?);
        return Ok(Change { words, edits, files });
    }
    let elements = source.children(at, "collision");
    let index = link.collisions.iter().position(|s| std::ptr::eq(s, shape));
    let element =
        index.and_then(|i| elements.get(i)).filter(|_| elements.len() == link.collisions.len());
    let element = *element
        .filter(|e| source.line(**e) == shape.line)
        .ok_or_else(|| state.elsewhere("collision", shape.line))?;
    let inner = source.child(element, "geometry").and_then(|g| source.child(g, "mesh"));
    let inner = inner.ok_or("it has no <mesh> to replace")?;
    let whole = source.written(element);
    let (before, after) = whole.split_once(source.written(inner)).ok_or("it is told twice")?;
    let own_name = source.get(element, "name");
    let one = |(i, name): (usize, &String)| {
        let begin = match own_name.filter(|_| i > 0) {
            Some(own) => before.replacen(own, &format!("{own}_{}", i + 1), 1),
            None => before.to_owned(),
        };
        format!("{begin}{}{after}", mesh_element(name))
    };
    let between =
        source.indent(element).map_or(String::new(), |i| format!("{}{i}", source.line_end()));
    let all: Vec<String> = names.iter().enumerate().map(one).collect();
    Ok(Change { words, edits: vec![source.replace(element, all.join(&between))], files })
}

/// The element of a URDF that names a mesh.
fn mesh_element(name: &str) -> String {
    format!("<mesh filename=\"{}\"/>", markup(name))
}

fn counted(count: usize) -> String {
    if count == 1 { "1 convex piece".into() } else { format!("{count} convex pieces") }
}

/// The assets and geoms of pieces that stand where another geom does; they weigh nothing.
fn geoms(
    (state, body, geom): (&State, At, At),
    names: &[String],
    files: &[NewFile],
) -> Result<Vec<Edit>, String> {
    let source = &state.source;
    let asset = source.child(source.root(), "asset").ok_or("it has no <asset> of its own")?;
    let told = ["pos", "quat", "euler", "axisangle", "xyaxes", "zaxis"];
    let placed: String = told
        .iter()
        .filter_map(|name| Some(format!(" {name}=\"{}\"", markup(source.get(geom, name)?))))
        .collect();
    let called = |file: &NewFile| {
        let name = file.name.rsplit('/').next().unwrap_or_default();
        name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
    };
    let assets: Vec<String> = names
        .iter()
        .zip(files)
        .map(|(name, file)| format!("<mesh name=\"{}\" file=\"{}\"/>", called(file), markup(name)))
        .collect();
    let pieces: Vec<String> = files
        .iter()
        .map(|file| {
            let mesh = called(file);
            format!("<geom type=\"mesh\" mesh=\"{mesh}\"{placed} mass=\"0\" group=\"{UNSEEN}\"/>")
        })
        .collect();
    Ok(vec![
        source.insert_last(asset, &assets.join("\n")),
        source.insert_after(body, geom, &pieces.join("\n")),
    ])
}

/// Collision geometry made of what is seen, in the place of what there is.
fn covered(state: &State, job: &Job, link: &Link, way: Way) -> Offer {
    let changes = covering((state, job), link, way);
    Offer { way, subject: format!("link `{}`", link.name), line: link.line, changes }
}

fn covering((state, job): (&State, &Job), link: &Link, way: Way) -> Result<Vec<Change>, String> {
    let at = link_at(state, link)?;
    if !state.is_urdf() {
        return match way {
            Way::Touch => touched(state, link, at).map(|change| vec![change]),
            _ => Err("of an MJCF body's geoms it is not known which stands for which".into()),
        };
    }
    let source = &state.source;
    let (seen, touched) = (source.children(at, "visual"), source.children(at, "collision"));
    if seen.len() != link.visuals.len() || touched.len() != link.collisions.len() {
        return Err(state.elsewhere("link", link.line));
    }
    let last = touched.last().or(seen.last()).copied().ok_or("it shows nothing")?;
    let made = |tolerance: Option<f64>| -> Result<Change, String> {
        let (mut files, mut elements, mut count) = (Vec::new(), Vec::new(), 0);
        for (shape, &visual) in link.visuals.iter().zip(&seen) {
            let origin =
                source.child(visual, "origin").map(|o| format!("\n\t{}", source.written(o)));
            let origin = origin.unwrap_or_default();
            let geometry = source.child(visual, "geometry").ok_or("it has no <geometry>")?;
            let (told, fresh) = of_shape((state, job), (shape, geometry), tolerance, &mut files)?;
            count += fresh;
            elements.extend(told.into_iter().map(|inner| {
                format!(
                    "<collision>{origin}\n\t<geometry>\n\t\t{inner}\n\t</geometry>\n</collision>"
                )
            }));
        }
        let mut edits: Vec<Edit> = Vec::new();
        match (way, &touched[..]) {
            (Way::Cover, [.., _]) => {
                let text = elements.join("\n");
                edits.extend(touched[..touched.len() - 1].iter().map(|t| source.remove(*t)));
                edits.push(source.replace(last, laid_out(state, last, &text)));
            }
            _ => edits.push(source.insert_after(at, last, &elements.join("\n"))),
        }
        let words = match count {
            0 => format!(
                "{} like what is seen",
                if elements.len() == 1 { "<collision>" } else { "<collision>s" }
            ),
            n => format!("{} of what is seen", counted(n)),
        };
        Ok(Change { words, edits, files })
    };
    let close = COVER.of(state.diagonal());
    let mut all = Vec::new();
    let mut why = None;
    for tolerance in [Some(close), Some(close * COARSER), None] {
        match made(tolerance) {
            Ok(change) => all.push(change),
            Err(reason) => why = why.or(Some(reason)),
        }
    }
    match why.filter(|_| all.is_empty()) {
        Some(why) => Err(why),
        None => Ok(all),
    }
}

/// A text with tabs and line feeds, indented as an element is.
fn laid_out(state: &State, at: At, text: &str) -> String {
    match state.source.indent(at) {
        Some(indent) => {
            let step = if indent.contains('\t') { "\t" } else { "  " };
            let text = text.replace('\t', step);
            text.replace('\n', &format!("{}{indent}", state.source.line_end()))
        }
        None => text.replace(['\n', '\t'], ""),
    }
}

/// What stands in `<geometry>` for a shape that is seen, and how many pieces of a mesh that is: the
/// same primitive, its convex pieces, or its one hull where no tolerance is given.
fn of_shape(
    (state, job): (&State, &Job),
    (shape, geometry): (&Shape, At),
    tolerance: Option<f64>,
    files: &mut Vec<NewFile>,
) -> Result<(Vec<String>, usize), String> {
    let source = &state.source;
    let mesh = match &shape.geometry {
        Geometry::Mesh(mesh) => mesh,
        Geometry::Unread { reason } => return Err(reason.clone()),
        _ => {
            let inner = source.first_child(geometry).ok_or("it has no shape")?;
            return Ok((vec![source.written(inner).to_owned()], 0));
        }
    };
    let made = match tolerance {
        Some(tolerance) => pieces(job, mesh, tolerance)?,
        None => vec![super::lines::hull(mesh)?],
    };
    let names = written((state, job), &shape.source, &made, files)?;
    let count = names.len();
    Ok((names.iter().map(|n| mesh_element(n)).collect(), count))
}

/// Of an MJCF body whose geoms touch nothing: copies of its primitives that do.
fn touched(state: &State, link: &Link, body: At) -> Result<Change, String> {
    let source = &state.source;
    let geoms = source.children(body, "geom");
    let mut copies = Vec::new();
    for geom in &geoms {
        let told = [
            "type",
            "size",
            "fromto",
            "mesh",
            "pos",
            "quat",
            "euler",
            "axisangle",
            "xyaxes",
            "zaxis",
        ];
        let told: String = told
            .iter()
            .filter_map(|name| Some(format!(" {name}=\"{}\"", markup(source.get(*geom, name)?))))
            .collect();
        copies.push(format!(
            "<geom{told} contype=\"1\" conaffinity=\"1\" mass=\"0\" group=\"{UNSEEN}\"/>"
        ));
    }
    let last = geoms.last().filter(|_| geoms.len() == link.visuals.len());
    let last = *last.ok_or("its geoms do not all stand in it")?;
    let edits = vec![source.insert_after(body, last, &copies.join("\n"))];
    Ok(Change { words: "geoms like what is seen, which touch".into(), edits, files: vec![] })
}
