//! `kinfold providers`: who can be asked, what each needs, what its licence is known to allow.

use adapters::config::known::{self, Provider};
use serde_json::json;

use super::providers;
use crate::cli::args::ProvidersArgs;
use crate::cli::speech::{Answer, Complaint};

/// Lists every provider; those that the configuration names are marked. Nothing is asked of anybody,
/// so one that nobody approved is read, and said to be so.
///
/// # Errors
/// [`Complaint`] when the configuration cannot be read.
pub fn list(args: &ProvidersArgs) -> Result<Answer, Complaint> {
    let draft = providers::draft(args.config.as_deref())?;
    let beside = draft.as_ref().filter(|_| args.config.is_none());
    let unapproved = beside.and_then(|draft| providers::check_approved(draft).err());
    let warning = unapproved.map(|c| c.to_string().replacen("error: ", "warning: ", 1));
    let remarks = warning.iter().flat_map(|w| w.lines()).map(String::from).collect();
    let config = draft.map(|draft| draft.config().clone()).unwrap_or_default();
    let generator = config.image_to_3d.as_ref().map(|g| g.name());
    let vlm = config.vlm.as_ref().map(|v| v.name());
    let chosen = |p: &Provider| {
        let whose = if p.section == "vlm" { vlm } else { generator };
        whose == Some(p.name)
    };
    if args.json {
        let one = |p: &Provider| json!({ "provider": p, "configured": chosen(p) });
        let all: Vec<_> = known::PROVIDERS.iter().map(one).collect();
        return Ok(Answer { remarks, ..Answer::done(format!("{:#}\n", json!(all))) });
    }
    let lines = known::PROVIDERS.iter().map(|p| line(p, chosen(p)));
    Ok(Answer { remarks, ..Answer::done(lines.collect::<String>()) })
}

fn line(provider: &Provider, chosen: bool) -> String {
    let Provider { section, name, what, needs, terms } = provider;
    let mark = if chosen { "*" } else { " " };
    let word = |p: &adapters::terms::Purpose| p.name();
    let allows: Vec<_> = terms.allows.iter().map(word).collect();
    let forbids: Vec<_> = terms.forbids.iter().map(word).collect();
    let mut licence = terms.licence.to_owned();
    if !allows.is_empty() {
        licence += &format!("; allows {}", allows.join(" "));
    }
    if !forbids.is_empty() {
        licence += &format!("; forbids {}", forbids.join(" "));
    }
    format!(
        "{mark} {section:<12} {name:<10} {what}\n{:>26}needs {needs}\n{:>26}{licence}\n",
        "", ""
    )
}
