//! Verbs that only look: how long they may take, and how much memory.

use std::time::Duration;

use super::args::{
    AuditArgs, AuditCommand, BoundsArgs, Command, StoreCommand, TraceCommand, WeightsCommand,
};
use super::watch::{Bounds, Watch};

/// The longest time to look at one trace, seconds: a guess, a hundred times the longest measured.
const TRACE: u64 = 600;
/// The longest time to run a trace again: as a run of its own.
const REPLAY: u64 = 3600;
/// The longest time to look through a batch or a store: a million items take under an hour.
const BULK: u64 = 6 * 3600;
/// What a question's own deadline does not hold is stopped so much later.
const LATER: Duration = Duration::from_secs(30);

/// Watches over a command that only looks.
pub(super) fn watch(command: &Command) -> Option<Watch> {
    let none = BoundsArgs::default();
    let (what, bounds) = match command {
        Command::Trace(command) => return watch_trace(command),
        Command::Audit(AuditArgs {
            command: Some(AuditCommand::Query { deadline, .. }), ..
        }) => {
            let deadline = deadline.saturating_add(LATER);
            ("the question", Bounds { deadline, ..none.or(BULK) })
        }
        Command::Weights(WeightsCommand::Show { .. }) => ("looking at the pack", none.or(TRACE)),
        Command::Audit(AuditArgs { command: Some(AuditCommand::Sign { .. }), .. }) => return None,
        Command::Audit(args) => ("the audit", args.bounds.or(BULK)),
        Command::Store(StoreCommand::Verify { bounds, repair: false, .. }) => {
            ("looking through the store", bounds.or(BULK))
        }
        Command::Store(StoreCommand::Gc { bounds, dry_run: true, .. }) => {
            ("looking through the store", bounds.or(BULK))
        }
        Command::Points(_) => ("looking at the mesh", none.or(TRACE)),
        Command::Make(args) if args.dry_run => ("looking at the run", none.or(TRACE)),
        Command::Batch(args) if args.dry_run => ("looking at the batch", none.or(BULK)),
        Command::Doctor(args) if args.offline => ("the doctor", none.or(TRACE)),
        _ => return None,
    };
    Some(Watch::begin(what.to_owned(), bounds))
}

/// Watches over a command that only looks into a trace.
pub(super) fn watch_trace(command: &TraceCommand) -> Option<Watch> {
    let (what, bounds) = of_trace(command)?;
    Some(Watch::begin(what.to_owned(), bounds))
}

fn of_trace(command: &TraceCommand) -> Option<(&'static str, Bounds)> {
    Some(match command {
        TraceCommand::Show { bounds, .. } => ("showing the trace", bounds.or(TRACE)),
        TraceCommand::Verify { bounds, .. } => ("verifying the trace", bounds.or(TRACE)),
        TraceCommand::Diff { bounds, .. } => ("comparing the traces", bounds.or(TRACE)),
        TraceCommand::Replay { bounds, .. } => ("replaying the trace", bounds.or(REPLAY)),
        TraceCommand::Extract { bounds, .. } => ("extracting from the trace", bounds.or(REPLAY)),
        TraceCommand::Sign { .. } | TraceCommand::Keygen { .. } => return None,
    })
}
