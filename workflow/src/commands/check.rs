//! `kinfold check`: how far does a URDF get?

use sim_check::{CheckOptions, Tier, Verdict};

use crate::cli::CheckArgs;
use crate::speech::{Answer, Complaint, Exit};

/// Checks a URDF; the exit code compares the tier it reaches with the tier asked for.
///
/// # Errors
/// [`Complaint`] when there is no such file.
pub fn check(args: &CheckArgs) -> Result<Answer, Complaint> {
    let name = args.urdf.display();
    std::fs::File::open(&args.urdf).map_err(|e| Complaint::failed(format!("{name}: {e}")))?;
    let up_to = args.tier.max(Tier::Dynamic);
    let options = CheckOptions { seed: args.seed, up_to, ..CheckOptions::default() };
    let verdict = sim_check::check(&args.urdf, &options);
    let result = if args.json { verdict.to_json() } else { verdict.table() };
    let exit = exit(&verdict, args.tier);
    let remarks = remark(&verdict, args.tier, &name.to_string()).into_iter().collect();
    Ok(Answer { result, remarks, exit })
}

fn exit(verdict: &Verdict, asked: Tier) -> Exit {
    match verdict.tier {
        tier if tier >= asked => Exit::Done,
        Tier::None => Exit::Failed,
        _ => Exit::Losses,
    }
}

fn remark(verdict: &Verdict, asked: Tier, name: &str) -> Option<String> {
    let (reached, asked_name) = (verdict.tier.name(), asked.name());
    (verdict.tier < asked).then(|| format!("{name}: tier {reached}, asked for {asked_name}"))
}
