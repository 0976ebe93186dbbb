//! What a command line asks of `kinfold mutate`: how the model is judged.

use sim_check::{Asked, CheckOptions, Outside, Places, Subject, Tier};

use crate::cli::args::{Kind, MutateArgs};

/// How the model is read, and the original judged.
pub(super) fn options(args: &MutateArgs) -> CheckOptions {
    CheckOptions {
        up_to: Tier::Dynamic,
        outside: if args.allow_outside { Outside::Allowed } else { Outside::Refused },
        subject: args.subject.map_or(Asked::Found, |kind| {
            Asked::As(match kind {
                Kind::Object => Subject::Object,
                Kind::Robot => Subject::Robot,
            })
        }),
        places: Places { packages: args.packages.iter().cloned().collect(), ..Places::default() },
        ..CheckOptions::default()
    }
}
