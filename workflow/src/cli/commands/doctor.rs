//! `kinfold doctor`: what is configured, what answers, which model can point, what is missing.

use std::sync::Arc;

use adapters::World;
use adapters::probe::{self, Ask, Finding};
use adapters::transport::Deny;
use guard::text::shown;
use runner::state_dir::claim;
use serde_json::json;

use super::providers::Wanted;
use super::{make, providers};
use crate::cli::args::DoctorArgs;
use crate::cli::speech::{Answer, Complaint, Exit};

/// What is said of a section that is left out.
const NOBODY: &str = "nobody is configured";

/// Looks at everything the configuration names. Exit 1 if something is not well.
///
/// # Errors
/// [`Complaint`] when the configuration cannot be read or there is no state directory.
pub fn doctor(args: &DoctorArgs) -> Result<Answer, Complaint> {
    let (named, trusted) = (args.config.as_deref(), args.trust_config);
    let wanted = Wanted { named, trusted, mesh: true, condition: true };
    let config = providers::configured(&wanted).map_err(|c| refused(c, args.json))?;
    let state = make::state_dir(args.state.as_deref())?;
    let ask = match (args.offline, args.free) {
        (true, _) => Ask::Nobody,
        (false, true) => Ask::Nothing,
        (false, false) => Ask::ThreeDots,
    };
    // What is asked is written down there.
    if ask == Ask::ThreeDots && config.vlm.is_some() {
        claim(&state).map_err(|e| make::state_complaint(&e))?;
    }
    let world = providers::world(&state);
    // Whatever is looked at below, nothing gets out.
    let world = match args.offline {
        true => World { transport: Arc::new(Deny), ..world },
        false => world,
    };
    let mut found = vec![];
    match &config.image_to_3d {
        Some(generator) => found.extend(probe::generator(&config, generator, &world, ask)),
        None => found.push(nobody("image_to_3d", "--mesh FILE")),
    }
    match &config.vlm {
        Some(vlm) => found.extend(probe::vlm(&config, vlm, &world, ask)),
        None => found.push(nobody("vlm", "--condition FILE")),
    }
    let exit = if found.iter().all(|f| f.well) { Exit::Done } else { Exit::Failed };
    let result = if args.json {
        let well = exit == Exit::Done;
        format!("{:#}\n", json!({ "well": well, "offline": args.offline, "findings": found }))
    } else {
        found.iter().map(|finding| line(finding, word(finding))).collect()
    };
    let offline = "offline: nobody was asked, no program was started, no key was sent; whether \
                   anybody answers is not known";
    let remarks = args.offline.then(|| offline.to_owned()).into_iter().collect();
    Ok(Answer { result, remarks, exit })
}

/// A configuration that may not be used, as a finding for machines, too.
fn refused(complaint: Complaint, json: bool) -> Complaint {
    if !json {
        return complaint;
    }
    let hint = Some(complaint.hints.join("; ")).filter(|h| !h.is_empty());
    let finding = Finding { what: "config".into(), well: false, found: complaint.line(), hint };
    let result = format!("{:#}\n", json!({ "well": false, "findings": [finding] }));
    Complaint { result, ..complaint }
}

fn nobody(section: &str, instead: &str) -> Finding {
    Finding {
        what: section.to_owned(),
        well: true,
        found: format!("{NOBODY}; give {instead}"),
        hint: None,
    }
}

/// How a section stands. Nobody is nothing wrong, but not well either.
fn word(finding: &Finding) -> &'static str {
    match finding.well {
        true if finding.found.starts_with(NOBODY) => "none",
        true => "ok",
        false => "ILL",
    }
}

fn line(finding: &Finding, word: &str) -> String {
    let Finding { what, found, hint, .. } = finding;
    let hint = hint.as_ref().map(|h| format!("{:>26}hint: {}\n", "", shown(h)));
    format!("{word:<4} {what:<20} {}\n{}", shown(found), hint.unwrap_or_default())
}
