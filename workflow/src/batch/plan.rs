//! Takes a manifest into the ledger, some thousand lines at a time; one that is in it already is not
//! read again.

use std::io::{self, Read};
use std::path::Path;

use trace::Digest;

use super::error::BatchError;
use super::ledger::Ledger;
use super::manifest::{self, Item, Line};

/// Lines that are taken in at once.
const AT_ONCE: usize = 5000;

/// Which of all items are taken in: the K-th of N, by the digest of the id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// From 0 up to `of`.
    pub k: u64,
    /// How many shares there are, at least one.
    pub of: u64,
}

impl Share {
    /// Everything.
    pub const ALL: Self = Self { k: 0, of: 1 };

    /// Whether an item is in this share; the same for every order and length of the manifest.
    pub fn holds(self, id: &str) -> bool {
        let digest = Digest::of(id.as_bytes());
        let head = digest.as_str().get(..15).unwrap_or("0");
        u64::from_str_radix(head, 16).unwrap_or(0) % self.of.max(1) == self.k
    }
}

/// A plan in the ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Its number.
    pub number: i64,
    /// Whether it was in the ledger already.
    pub known: bool,
}

/// The plan of a share of a manifest; lines that are no items stand in it with their reasons.
///
/// # Errors
/// [`BatchError`] when the manifest cannot be read or the ledger not be written.
pub fn plan(manifest: &Path, share: Share, ledger: &Ledger) -> Result<Plan, BatchError> {
    let digest = digest(manifest, share)?;
    if let Some(number) = ledger.plan_of(&digest)? {
        return Ok(Plan { number, known: true });
    }
    let number = ledger.begin_plan(&digest)?;
    let base = manifest::base(manifest);
    let mut lines = manifest::open(manifest)?;
    loop {
        let some: Vec<_> = lines.by_ref().take(AT_ONCE).collect::<Result<_, _>>()?;
        if some.is_empty() {
            break;
        }
        let ours = |line: &Line| line.item.as_ref().map_or(true, |i| share.holds(&i.id));
        let found: Vec<_> = some.into_iter().filter(ours).map(|line| found(line, base)).collect();
        ledger.take(number, &found)?;
    }
    ledger.end_plan(number)?;
    Ok(Plan { number, known: false })
}

/// A line with its files found, or the reason why it is no item.
fn found(line: Line, base: &Path) -> (u64, Result<Item, String>) {
    let whole = line.item.and_then(|item| match item.missing(base) {
        Some(gone) => Err(gone),
        None => Ok(item.found_from(base)),
    });
    (line.number, whole)
}

/// Digest of a manifest: of its bytes and its place, or of a folder's names.
fn digest(manifest: &Path, share: Share) -> Result<Digest, BatchError> {
    let failed =
        |source: io::Error| BatchError::Io { doing: "read", path: manifest.to_path_buf(), source };
    let place = format!("{} {}/{}", manifest.display(), share.k, share.of);
    if !manifest.is_dir() {
        let file = guard::files::open_file(manifest, manifest::MOST).map_err(|refused| {
            BatchError::Folder { path: manifest.to_path_buf(), found: refused.to_string() }
        })?;
        return Digest::of_reader(place.as_bytes().chain(file)).map_err(failed);
    }
    let mut all = Digest::of(place.as_bytes());
    for line in manifest::open(manifest)? {
        let photo = line?.item.map(|i| i.photo.display().to_string());
        let photo = photo.unwrap_or_else(|why| why);
        all = Digest::of(format!("{all} {photo}").as_bytes());
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_disjoint_and_hold_everything() {
        let shares: Vec<_> = (0..7).map(|k| Share { k, of: 7 }).collect();
        let mut sizes = [0; 7];
        for n in 0..700 {
            let id = format!("item-{n}");
            let held: Vec<_> = (0..7).filter(|&k| shares[k].holds(&id)).collect();
            assert_eq!(held.len(), 1);
            sizes[held[0]] += 1;
        }
        assert!(sizes.iter().all(|&s| s > 60), "{sizes:?}");
        assert!(Share::ALL.holds("anything"));
    }
}
