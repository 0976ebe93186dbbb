//! How an asset looks as files: a description, and its pictures as they are.

use std::collections::BTreeMap;

use object::appearance::Picture;
use serde::{Deserialize, Serialize};

use crate::write::appearance::look::{AssetAppearance, LinkAppearance, TextureFile};

/// The description's name.
const DESCRIPTION: &str = "appearance.json";

#[derive(Serialize, Deserialize)]
struct Description {
    links: Vec<LinkAppearance>,
    /// Path of each PNG, and of the JPEG it was.
    textures: Vec<(String, Option<String>)>,
    notes: Vec<String>,
}

impl AssetAppearance {
    /// All of it as files by name; the same appearance gives the same bytes.
    pub fn to_files(&self) -> BTreeMap<String, Vec<u8>> {
        let original = |t: &TextureFile| t.original.is_some().then(|| format!("{}.jpg", t.path));
        let textures = self.textures.iter().map(|t| (t.path.clone(), original(t))).collect();
        let (links, notes) = (self.links.clone(), self.notes.clone());
        let text = serde_json::to_vec(&Description { links, textures, notes }).unwrap_or_default();
        let pictures = self.textures.iter().flat_map(|t| {
            let as_it_came = original(t).zip(t.original.as_ref());
            std::iter::once((t.path.clone(), &t.picture)).chain(as_it_came)
        });
        let pictures = pictures.map(|(path, picture)| (path, picture.bytes().to_vec()));
        pictures.chain([(DESCRIPTION.to_owned(), text)]).collect()
    }

    /// The appearance behind such files.
    ///
    /// # Errors
    /// What is wrong with them, in words.
    pub fn from_files(mut files: BTreeMap<String, Vec<u8>>) -> Result<Self, String> {
        let missing = |name: &str| format!("expected a file `{name}`");
        let text = files.remove(DESCRIPTION).ok_or_else(|| missing(DESCRIPTION))?;
        let Description { links, textures, notes } =
            serde_json::from_slice(&text).map_err(|e| e.to_string())?;
        let mut picture =
            |path: &str| Picture::new(files.remove(path).ok_or_else(|| missing(path))?);
        let texture = |(path, original): (String, Option<String>)| {
            let original = original.map(|path| picture(&path)).transpose()?;
            Ok::<_, String>(TextureFile { picture: picture(&path)?, path, original })
        };
        let textures = textures.into_iter().map(texture).collect::<Result<Vec<_>, _>>()?;
        let this = Self { links, textures, notes };
        let used =
            |l: &LinkAppearance| l.groups.iter().flat_map(|g| g.material.textures()).collect();
        let used: Vec<_> =
            this.links.iter().flat_map(|l| -> Vec<_> { used(l) }).flatten().collect();
        match used.iter().find(|t| t.picture >= this.textures.len()) {
            Some(t) => {
                Err(format!("expected a picture {}, found {}", t.picture, this.textures.len()))
            }
            None => Ok(this),
        }
    }
}
