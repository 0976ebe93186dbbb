//! A batch from its manifest to its end: takes the plan in, has the engine work, and counts.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::sync::mpsc::{self, RecvTimeoutError};

use runner::ours::Turns;
use runner::{Cancel, Depot, StateDir, Wish, Workers};
use trace::{Clock, Digest};

use super::allowance::Allowance;
use super::class::Class;
use super::engine::Engine;
use super::error::BatchError;
use super::feed::Pending;
use super::folder::BatchFolder;
use super::gate::{AtOnce, Places};
use super::item::{Bench, Onlooker, Settings};
use super::ledger::{Ledger, Standing};
use super::plan::plan;
use super::progress::{Board, PAUSE, Tally};
use super::purse::{Purse, Spent};
use crate::recording::VERSION;

/// What a batch is asked to do.
pub struct Order {
    /// The manifest.
    pub manifest: PathBuf,
    /// Where assets go.
    pub out: PathBuf,
    /// Where finished stages are kept.
    pub state: PathBuf,
    /// Where other machines find them, too.
    pub depot: Option<Arc<dyn Depot>>,
    /// What every item is made with.
    pub settings: Settings,
    /// Most stages at once.
    pub at_once: AtOnce,
    /// What may be spent.
    pub allowance: Allowance,
    /// Classes of failures that are tried again.
    pub retry: Vec<Class>,
    /// Who else is told how items go, if anybody.
    pub onlooker: Option<Arc<dyn Onlooker + Send + Sync>>,
    /// Say nothing on the way.
    pub quiet: bool,
}

/// What a run of a batch came to.
#[derive(Clone, Debug)]
pub struct Summary {
    /// What this run did.
    pub tally: Tally,
    /// How the whole batch stands.
    pub standing: Standing,
    /// The first bad lines of the manifest.
    pub bad_lines: Vec<(u64, String)>,
    /// What was spent, over all runs.
    pub spent: Spent,
    /// Whether somebody wanted it to stop.
    pub interrupted: bool,
    /// Whether the manifest was in the ledger already.
    pub resumed: bool,
}

impl Summary {
    /// Items without an outcome that stands.
    pub fn left(&self) -> u64 {
        let Standing { planned, accepted, rejected, failed, .. } = self.standing;
        planned.saturating_sub(accepted + rejected + failed)
    }
}

/// Bad lines that are told one by one.
pub const TOLD: u32 = 20;

/// The folders of a batch, held alone.
pub struct Opened {
    folder: BatchFolder,
    ledger: Arc<Ledger>,
    state: StateDir,
}

/// Which run items are made in, with whose hands, and who looks on.
pub(super) struct Under<'a> {
    pub(super) run: i64,
    pub(super) digest: Digest,
    pub(super) workers: Option<Arc<dyn Workers>>,
    pub(super) onlooker: Option<&'a dyn Onlooker>,
}

/// What is around a run's bench.
pub(super) struct Hall<'a> {
    pub(super) feed: &'a Pending<'a>,
    pub(super) purse: &'a Arc<Purse>,
    pub(super) board: &'a Board,
    pub(super) cancel: &'a Cancel,
    pub(super) clock: Arc<dyn Clock>,
}

impl Order {
    /// Refuses folders that are somebody else's. Changes nothing.
    ///
    /// # Errors
    /// [`BatchError`] with what was found.
    pub fn look(&self) -> Result<(), BatchError> {
        BatchFolder::look(&self.out)?;
        StateDir::open_to_read(&self.state)?;
        Ok(())
    }
}

impl Opened {
    /// Opens the batch's folder, then its state directory, when it is our turn.
    ///
    /// # Errors
    /// [`BatchError`] when one is somebody else's, or in use and nobody is to wait.
    pub fn of(order: &Order, turns: Turns) -> Result<Self, BatchError> {
        let (folder, ledger) = BatchFolder::open(&order.out, turns)?;
        let mut state = StateDir::open_in_turn(&order.state, turns)?;
        if let Some(depot) = &order.depot {
            state = state.sharing(Arc::clone(depot));
        }
        Ok(Self { folder, ledger: Arc::new(ledger), state })
    }

    /// What became of items so far.
    pub(super) fn ledger(&self) -> Arc<Ledger> {
        Arc::clone(&self.ledger)
    }

    /// Where the items of a run are made.
    pub(super) fn bench<'a>(
        &'a self,
        order: &'a Order,
        under: Under<'a>,
        hall: Hall<'a>,
    ) -> Bench<'a> {
        let Under { run, digest, workers, onlooker } = under;
        let Hall { feed, purse, board, cancel, clock } = hall;
        Bench {
            run,
            settings: &order.settings,
            digest,
            state: &self.state,
            ledger: Arc::clone(&self.ledger),
            feed,
            workers,
            folder: &self.folder,
            places: Places::new(order.at_once),
            purse: Arc::clone(purse),
            allowance: order.allowance,
            cancel: cancel.clone(),
            clock,
            board,
            onlooker,
            troubles: AtomicU32::new(0),
        }
    }
}

/// Runs a batch as far as it goes.
///
/// # Errors
/// [`BatchError`] when it cannot go on at all; everything that has an outcome keeps it.
pub fn run(
    order: &Order,
    opened: &Opened,
    engine: &dyn Engine,
    cancel: &Cancel,
    clock: Arc<dyn Clock>,
) -> Result<Summary, BatchError> {
    let ledger = Arc::clone(&opened.ledger);
    let words = order.settings.words();
    let digest = Digest::of(words.as_bytes());
    let run = ledger.begin(VERSION, &words, clock.now())?;
    let plan = plan(&order.manifest, engine.share(), &ledger)?;
    somebody_to_ask(order, &ledger, plan.number)?;
    let before = ledger.standing(plan.number, &digest)?;
    let bad_lines = ledger.bad_lines(plan.number, TOLD)?;
    let settled = before.accepted + before.rejected + before.failed;
    let board = Board::new(before.planned, settled, order.quiet);
    tell_bad_lines(&board, &bad_lines, before.bad);
    let purse = Purse::open(order.allowance, run, Arc::clone(&ledger), Arc::clone(&clock))?;
    let again = order.retry.iter().map(|c| c.name()).collect();
    let feed = Pending::new((&ledger, plan.number, run), &digest, again, cancel);
    let onlooker = order.onlooker.as_deref().map(|onlooker| onlooker as &dyn Onlooker);
    let under = Under { run, digest: digest.clone(), workers: engine.workers(), onlooker };
    let hall = Hall { feed: &feed, purse: &purse, board: &board, cancel, clock };
    let bench = opened.bench(order, under, hall);
    let ran = told_of(&board, (&*bench.places, &*purse), || engine.run(&feed, &bench));
    let tally = board.finish();
    ran?;
    Ok(Summary {
        tally,
        standing: ledger.standing(plan.number, &digest)?,
        bad_lines,
        spent: purse.spent(),
        interrupted: cancel.wish() != Wish::Go,
        resumed: plan.known,
    })
}

/// Does some work while every now and then a line says how it goes.
fn told_of<T>(board: &Board, (places, purse): (&Places, &Purse), work: impl FnOnce() -> T) -> T {
    let (ended, end) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let tell = move || {
            while end.recv_timeout(PAUSE / 10) == Err(RecvTimeoutError::Timeout) {
                board.tick(places, purse.spent());
            }
        };
        // Without that thread nothing is told on the way, and everything is done.
        let teller = std::thread::Builder::new().name("progress".into()).spawn_scoped(scope, tell);
        let done = work();
        drop((ended, teller));
        done
    })
}

fn somebody_to_ask(order: &Order, ledger: &Ledger, plan: i64) -> Result<(), BatchError> {
    let (meshes, conditions) = ledger.to_ask_for(plan)?;
    let needs = [
        ("a mesh", meshes, order.settings.image_to_3d.is_none()),
        ("a condition", conditions, order.settings.vlm.is_none()),
    ];
    let unmet = needs.into_iter().find(|(_, items, nobody)| *items > 0 && *nobody);
    unmet.map_or(Ok(()), |(what, items, _)| Err(BatchError::Nobody { what, items }))
}

fn tell_bad_lines(board: &Board, bad: &[(u64, String)], all: u64) {
    for (line, why) in bad {
        board.say(&format!("line {line}: {why}"));
    }
    let more = all.saturating_sub(bad.len() as u64);
    if more > 0 {
        board.say(&format!("and {more} more bad lines"));
    }
}
