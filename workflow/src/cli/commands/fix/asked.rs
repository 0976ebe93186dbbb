//! What a command line asks of `kinfold fix`: what is mended, and how the model is judged.

use sim_check::{Asked, Base, CheckOptions, Outside, Places, Subject, Tier};

use crate::cli::args::{FixArgs, Kind, Standing};
use crate::cli::commands::check::shelves;
use crate::fix::remedies::Wanted;

/// What is to be mended.
pub(super) fn wanted(args: &FixArgs) -> Wanted {
    Wanted { only: args.only.clone(), flags: args.flags }
}

/// How the model is judged.
pub(super) fn options(args: &FixArgs) -> CheckOptions {
    CheckOptions {
        seed: args.seed,
        up_to: Tier::Dynamic,
        outside: if args.allow_outside { Outside::Allowed } else { Outside::Refused },
        subject: args.subject.map_or(Asked::Found, |kind| {
            Asked::As(match kind {
                Kind::Object => Subject::Object,
                Kind::Robot => Subject::Robot,
            })
        }),
        base: args.base.map(|base| match base {
            Standing::Fixed => Base::Fixed,
            Standing::Free => Base::Free,
        }),
        places: Places {
            packages: args.packages.iter().cloned().collect(),
            shelves: if args.ros { shelves() } else { Vec::new() },
            env: args.env.iter().cloned().collect(),
            args: args.args.iter().cloned().collect(),
            srdf: args.srdf.clone(),
        },
        ..CheckOptions::default()
    }
}
