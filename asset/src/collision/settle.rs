//! Makes the collision pieces of all parts and clears them of each other, at rest and along every
//! range. A part's visible surface gives way where its pieces had to.

use object::condition::GivenJoints;
use object::{ArticulatedObject, Mesh};
use rayon::prelude::*;

use crate::change::Change;
use crate::collision::clearance::{ClearanceOptions, Cleared, clear_keeping};
use crate::collision::hinges;
use crate::collision::hulls::{COARSE, Decomposer, FINE, Fineness, SMALL};
use crate::collision::piece::{ConvexPiece, MAX_PIECES, held};
use crate::collision::sockets::{self, Seen};
use crate::collision::whole::Whole;
use crate::error::{AssetError, HullError, whole_surface};
use crate::surface::repaired::Surface;

/// A part that fits within this, in tolerances, is not worth another attempt.
const WORTH: f64 = 0.99;

/// Pieces together larger than the space a part fills by more than this are made anew, closer to
/// its surface.
const TIGHT: f64 = 1.15;
/// Wires and foil cannot be filled so well with so few pieces: beyond this they stay as they are.
const HOPELESS: f64 = 4.0;
/// How much closer, as shares of the usual distance.
const CLOSER: [f64; 4] = [0.5, 0.2, 0.1, 0.05];
/// Pieces that fill less than this share of a part's space have lost some of it.
const LOST: f64 = 0.85;
/// Parts of more faces take long: they are spared the last, and from the second number on the first,
/// too, and what comes after pieces have run out.
const MANY_FACES: [usize; 2] = [1000, 2500];

/// The further attempts, one after another while a part does not fit.
const FURTHER: [Further; 11] = [
    Further { way: FINE, share: 0.3, reach: Reach::Ill, close: None },
    Further { way: FINE, share: 0.3, reach: Reach::Crowded, close: Some(1.0) },
    Further { way: SMALL, share: 0.1, reach: Reach::Beside, close: None },
    Further { way: FINE, share: 0.3, reach: Reach::Ill, close: Some(0.6) },
    Further { way: SMALL, share: 0.1, reach: Reach::Ill, close: Some(1.0) },
    Further { way: SMALL, share: 0.1, reach: Reach::All, close: Some(0.6) },
    Further { way: FINE, share: 0.1, reach: Reach::All, close: Some(0.4) },
    Further { way: FINE, share: 0.05, reach: Reach::Ill, close: Some(0.8) },
    Further { way: FINE, share: 0.1, reach: Reach::All, close: Some(0.25) },
    Further { way: SMALL, share: 0.05, reach: Reach::Ill, close: Some(0.8) },
    Further { way: FINE, share: 0.3, reach: Reach::All, close: Some(0.8) },
];

/// Another attempt.
struct Further {
    /// How finely parts are decomposed.
    way: Fineness,
    /// What share of the usual worth a piece left over from clearing must have.
    share: f64,
    /// Which parts are meant.
    reach: Reach,
    /// How close they keep to their surface this once, in tolerances; otherwise as found at first, and
    /// for all attempts to come.
    close: Option<f64>,
}

/// Pieces per part, and the object with ranges that are free of contact.
pub(crate) struct Collision {
    pub(crate) object: ArticulatedObject,
    pub(crate) pieces: Vec<Vec<ConvexPiece>>,
    /// What is to be seen of each part.
    pub(crate) seen: Vec<Mesh>,
    pub(crate) changes: Vec<Change>,
}

/// Decomposes every part and clears the pieces of each other; parts whose surface and pieces do
/// not fit afterwards are decomposed more finely, at last with those beside them, and cleared with
/// less regard to the number of pieces. Metres, asset frame.
///
/// `spaces` holds what each part's surface encloses, m³, where it is mostly closed.
pub(crate) fn collision(
    object: &ArticulatedObject,
    (surfaces, spaces): (&[Surface], &[Option<f64>]),
    given: &GivenJoints,
    seed: u64,
) -> Result<Collision, AssetError> {
    let diagonal = object.mesh().bounds().diagonal();
    let room = ClearanceOptions { seed, ..ClearanceOptions::for_diagonal(diagonal) };
    let wholes = surfaces.iter().map(|s| Whole::new(&s.mesh)).collect();
    let task = Task { object, surfaces, wholes, spaces, given, room };
    let (decomposers, mut whole) = task.first()?;
    let mut best = task.attempt(&whole, 1.0)?;
    for Further { way, share, reach, close } in FURTHER {
        let ill: Vec<bool> = best.gaps.iter().map(|&gap| gap > WORTH).collect();
        if !ill.contains(&true) {
            break;
        }
        let marked = task.meant(&ill, reach, &decomposers);
        if !marked.contains(&true) {
            continue;
        }
        let next = if let Some(close) = close {
            let mut once = whole.clone();
            task.decompose(
                &task.keeping(&decomposers, (close, &marked)),
                (way, &marked),
                &mut once,
            )?;
            task.attempt(&once, share)
        } else {
            task.decompose(&decomposers, (way, &marked), &mut whole)?;
            task.attempt(&whole, share)
        };
        if let Ok(next) = next
            && next.misfit() < best.misfit()
        {
            best = next;
        }
    }
    Ok(best.collision)
}

/// Which parts are decomposed anew.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// Those that do not fit.
    Ill,
    /// Those of them that keep closer to their surface than they must: fewer pieces leave more for
    /// clearing to cut.
    Crowded,
    /// Those beside them, too, save what fits and keeps closer than it must.
    Beside,
    /// All those beside them, too.
    All,
}

/// What is to be done.
struct Task<'a> {
    object: &'a ArticulatedObject,
    surfaces: &'a [Surface],
    wholes: Vec<Whole<'a>>,
    spaces: &'a [Option<f64>],
    given: &'a GivenJoints,
    room: ClearanceOptions,
}

/// One way through, and how far surface and pieces of each part lie apart, in tolerances.
struct Attempt {
    collision: Collision,
    gaps: Vec<f64>,
}

impl Attempt {
    /// How many parts do not fit, and by how much.
    fn misfit(&self) -> (usize, f64) {
        let over = self.gaps.iter().map(|g| g - WORTH).filter(|g| *g > 0.0);
        (over.clone().count(), over.sum())
    }
}

impl Task<'_> {
    fn name(&self, part: usize) -> &str {
        &self.object.tree().parts()[part].name
    }

    /// Few pieces of every part, as close to its surface as its space asks for, and what finds more.
    fn first(&self) -> Result<(Vec<Decomposer<'_>>, Vec<Vec<ConvexPiece>>), AssetError> {
        let one = |part: usize| self.tight(part).map_err(|e| self.error(part, e));
        let parts: Vec<usize> = (0..self.surfaces.len()).collect();
        let found = parts.into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
        Ok(found.into_iter().unzip())
    }

    fn tight(&self, part: usize) -> Result<(Decomposer<'_>, Vec<ConvexPiece>), HullError> {
        let surface = &self.surfaces[part];
        let usual = Decomposer::new(&surface.mesh, self.room.tolerance)?;
        let pieces = usual.pieces(COARSE)?;
        let ratio = |pieces: &[ConvexPiece], space: f64| held(pieces) / space;
        let is_loose = |space: &f64| (TIGHT..HOPELESS).contains(&ratio(&pieces, *space));
        let Some(space) = self.spaces[part].filter(is_loose) else { return Ok((usual, pieces)) };
        let faces = surface.mesh.faces().len();
        let is_heavy = faces > MANY_FACES[1];
        let last = CLOSER.len() - usize::from(faces > MANY_FACES[0]);
        let bare = usual.bare(&pieces);
        let mut best = (usual, pieces);
        for share in &CLOSER[usize::from(is_heavy)..last] {
            let closer = best.0.keeping(share * self.room.tolerance);
            let pieces = closer.pieces(COARSE)?;
            let is_crowded = pieces.len() + 1 >= MAX_PIECES;
            let is_better = (LOST * space..held(&best.1)).contains(&held(&pieces));
            if is_better && closer.bare(&pieces) <= bare {
                best = (closer, pieces);
            }
            if ratio(&best.1, space) < TIGHT || is_crowded && is_heavy {
                break;
            }
        }
        let (decomposer, pieces) = best;
        let pieces = decomposer.thinned(pieces, (LOST * space, TIGHT * space));
        Ok((decomposer, pieces))
    }

    fn error(&self, part: usize, source: HullError) -> AssetError {
        AssetError::Collision { part: self.name(part).into(), source }
    }

    /// Which parts are decomposed anew where some are ill.
    fn meant(&self, ill: &[bool], reach: Reach, decomposers: &[Decomposer]) -> Vec<bool> {
        let closer = decomposers.iter().map(Decomposer::is_closer);
        match reach {
            Reach::Ill => ill.to_vec(),
            Reach::Crowded => ill.iter().zip(closer).map(|(ill, closer)| *ill && closer).collect(),
            Reach::Beside => {
                let fine = closer.zip(ill).map(|(closer, ill)| closer && !ill);
                self.with_neighbours(ill).into_iter().zip(fine).map(|(m, f)| m && !f).collect()
            }
            Reach::All => self.with_neighbours(ill),
        }
    }

    /// Those marked keep so close to their surface, in tolerances.
    fn keeping<'a>(
        &self,
        decomposers: &[Decomposer<'a>],
        (close, marked): (f64, &[bool]),
    ) -> Vec<Decomposer<'a>> {
        let one = |(d, marked): (&Decomposer<'a>, &bool)| match marked {
            true => d.keeping(close * self.room.tolerance),
            false => d.clone(),
        };
        decomposers.iter().zip(marked).map(one).collect()
    }

    /// The parts marked and those whose box theirs touches: what they give way to may be too large.
    fn with_neighbours(&self, marked: &[bool]) -> Vec<bool> {
        let boxes: Vec<_> = self.surfaces.iter().map(|s| s.mesh.bounds()).collect();
        let is_beside = |part: usize| {
            let near = boxes[part].grown(self.room.tolerance);
            (0..boxes.len()).any(|ill| marked[ill] && near.intersects(&boxes[ill]))
        };
        (0..boxes.len()).map(is_beside).collect()
    }

    /// Puts new pieces of the parts that are marked into `whole`.
    fn decompose(
        &self,
        decomposers: &[Decomposer],
        (way, marked): (Fineness, &[bool]),
        whole: &mut [Vec<ConvexPiece>],
    ) -> Result<(), AssetError> {
        let all = decomposers.par_iter().zip(whole).enumerate();
        all.filter(|(part, _)| marked[*part]).try_for_each(|(part, (decomposer, pieces))| {
            *pieces = decomposer.pieces(way).map_err(|e| self.error(part, e))?;
            Ok(())
        })
    }

    fn attempt(&self, whole: &[Vec<ConvexPiece>], share: f64) -> Result<Attempt, AssetError> {
        let (joints, mut changes) = hinges::settle(self.object, whole, self.given);
        let object = self.object.clone().with_joints(joints)?;
        let Cleared { pieces, joints, changes: cleared } = clear_keeping(
            &object,
            whole.to_vec(),
            self.given,
            &ClearanceOptions { share, ..self.room },
        );
        changes.extend(cleared);
        if let Some(part) = pieces.iter().position(Vec::is_empty) {
            return Err(AssetError::NoPieceLeft(self.name(part).into()));
        }
        let seen = self.seen([whole, &pieces])?;
        changes.extend(seen.iter().filter_map(|s| s.change.clone()));
        let gaps = seen.iter().map(|s| s.gap).collect();
        let seen = seen.into_iter().map(|s| s.mesh).collect();
        let object = object.with_joints(joints)?;
        Ok(Attempt { collision: Collision { object, pieces, seen, changes }, gaps })
    }

    fn seen(&self, pieces: [&[Vec<ConvexPiece>]; 2]) -> Result<Vec<Seen>, AssetError> {
        let names: Vec<&str> = (0..self.wholes.len()).map(|part| self.name(part)).collect();
        sockets::cut(&self.wholes, pieces, &names, self.room.tolerance).map_err(whole_surface)
    }
}
