//! The page itself: one file that loads nothing, in light and in dark.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use indicatif::HumanCount;

use super::charts;
use super::figures::{Figures, ROWS, Shown, Yield};
use super::gallery::Look;
use super::markup::{escaped, linked, more, section};
use super::refusals::{bad_lines, checks, failures};

const STYLE: &str = include_str!("style.css");
/// Nothing is loaded from anywhere, whatever an id or a reason holds.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The page about a batch of that name.
pub(super) fn page(name: &str, figures: &Figures, looks: &BTreeMap<String, Look>) -> String {
    let name = escaped(name);
    let mut out = format!(
        "<!doctype html>\n<html lang=en>\n<head>\n<meta charset=utf-8>\n\
         <meta http-equiv=Content-Security-Policy content=\"{POLICY}\">\n\
         <meta name=viewport content=\"width=device-width\">\n<title>{name} · kinfold batch</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{name}</h1>\n"
    );
    out.push_str(&tiles(figures));
    out.push_str(&yields("Yield by category", "category", &figures.categories));
    out.push_str(&yields("Yield by provider", "mesh + condition", &figures.providers));
    out.push_str(&failures(figures, looks));
    out.push_str(&checks(figures));
    out.push_str(&bad_lines(figures));
    let times = charts::times(&figures.times, &figures.ran);
    out.push_str(&section("Time of each stage", &format!(
        "<p class=dim>Least to most, the middle 80 %, and the median of the items whose stage ran; what was recalled from the store took no time.</p>{times}"
    )));
    out.push_str(&gallery("Accepted assets", &figures.gallery, figures.total.accepted, looks));
    out.push_str(&gallery(
        "Rejected, in quarantine",
        &figures.refused,
        figures.total.rejected,
        looks,
    ));
    out.push_str(&twins(figures));
    out.push_str("</main>\n</body>\n</html>\n");
    out
}

fn tiles(figures: &Figures) -> String {
    let Yield { accepted, rejected, failed } = figures.total;
    let count = |n: u64| HumanCount(n).to_string();
    let mut tiles = vec![
        ("items", count(figures.total.all()), ""),
        ("accepted", count(accepted), "ok"),
        ("yield", format!("{:.1} %", 100.0 * figures.total.share()), "ok"),
        ("rejected", count(rejected), "no"),
        ("failed", count(failed), "bad"),
        ("provider calls", count(figures.calls), ""),
    ];
    if figures.cost > 0.0 {
        let each = figures.cost_per_accepted().map_or("–".into(), |c| format!("{c:.3}"));
        tiles.extend([
            ("cost", format!("{:.2}", figures.cost), ""),
            ("cost per accepted", each, ""),
        ]);
    }
    tiles.push(("near-duplicates", count(figures.twin_count), ""));
    let tile = |(name, value, class): &(&str, String, &str)| {
        let id = name.replace(' ', "-");
        format!("<div class=\"tile {class}\"><b id=\"{id}\">{value}</b><span>{name}</span></div>\n")
    };
    let tiers: Vec<_> = figures.tiers.iter().map(|(t, n)| format!("{t} {}", count(*n))).collect();
    let tiers = if tiers.is_empty() {
        String::new()
    } else {
        format!("<p class=dim>Tiers reached: {}</p>\n", tiers.join(", "))
    };
    format!("<div class=tiles>\n{}</div>\n{tiers}", tiles.iter().map(tile).collect::<String>())
}

fn yields(title: &str, what: &str, rows: &BTreeMap<String, Yield>) -> String {
    let mut sorted: Vec<_> = rows.iter().collect();
    sorted.sort_by_key(|(_, y)| std::cmp::Reverse(y.all()));
    let mut body = format!(
        "<table>\n<tr><th>{what}<th>items<th>yield<th class=wide><span class=key><i class=ok></i>accepted \
         <i class=no></i>rejected <i class=bad></i>failed</span></tr>\n"
    );
    for (name, of) in sorted.iter().take(ROWS) {
        let _ = writeln!(
            body,
            "<tr><td>{}<td class=n>{}<td class=n>{:.1} %<td>{}</tr>",
            escaped(name),
            HumanCount(of.all()),
            100.0 * of.share(),
            charts::bar(**of),
        );
    }
    section(title, &(body + "</table>" + &more(sorted.len(), ROWS, "rows")))
}

fn gallery(title: &str, shown: &[Shown], all: u64, looks: &BTreeMap<String, Look>) -> String {
    if shown.is_empty() {
        return String::new();
    }
    let mut body = String::from("<div class=gallery>\n");
    for item in shown {
        let twin = item
            .twin
            .as_ref()
            .map_or(String::new(), |t| format!("<em>looks like {}</em>", escaped(t)));
        let look = looks.get(&item.id);
        let page = look.and_then(|look| look.page.as_deref());
        let card = format!(
            "{}<figcaption><b>{}</b><span>{}</span>{twin}</figcaption>",
            pictures(look),
            escaped(&item.id),
            escaped(&item.words),
        );
        let _ = writeln!(body, "<figure>{}</figure>", linked(&card, page));
    }
    let of = if all > shown.len() as u64 {
        format!("<p class=dim>{} of {}</p>", shown.len(), HumanCount(all))
    } else {
        String::new()
    };
    section(title, &format!("{of}{body}</div>"))
}

/// The picture of an item; one that moves lies over it and is seen while somebody points at it.
fn pictures(look: Option<&Look>) -> String {
    let image = |kind: &str, class: &str, bytes: &Option<Vec<u8>>| {
        let bytes = bytes.as_ref().map(|bytes| STANDARD.encode(bytes));
        bytes.map(|b| format!("<img{class} alt=\"\" src=\"data:image/{kind};base64,{b}\">"))
    };
    let still = look.and_then(|look| image("jpeg", "", &look.still));
    let motion = look.and_then(|look| image("webp", " class=motion", &look.motion));
    let still = still.unwrap_or_else(|| "<div class=none>no picture</div>".into());
    format!("<div class=look>{still}{}</div>", motion.unwrap_or_default())
}

fn twins(figures: &Figures) -> String {
    if figures.twins.is_empty() {
        return String::new();
    }
    let pair = |(one, first): &(String, String)| {
        format!("<span class=chip>{} ≈ {}</span> ", escaped(one), escaped(first))
    };
    let rest = figures.twin_count.saturating_sub(figures.twins.len() as u64);
    let more = if rest == 0 {
        String::new()
    } else {
        format!(
            "<p class=dim>and {} more: column duplicate_of of index.parquet</p>",
            HumanCount(rest)
        )
    };
    let pairs: String = figures.twins.iter().map(pair).collect();
    section("Near-duplicates", &format!("<p class=pairs>{pairs}</p>{more}"))
}

#[cfg(test)]
mod tests {
    use super::super::figures::Reason;
    use super::*;

    #[test]
    fn what_comes_from_outside_is_text_and_never_markup() {
        let mut figures = Figures::default();
        let evil = "<script>alert(1)</script>\"onload=\"x\u{202e}\u{9b}\nb";
        figures.categories.insert(evil.into(), Yield { accepted: 1, ..Yield::default() });
        let reason = Reason { items: 9, ids: vec![evil.into()] };
        figures.reasons.insert((evil.into(), evil.into()), reason);
        figures.checks.insert(evil.into(), Yield { rejected: 2, ..Yield::default() });
        figures.bad_lines = (vec![(3, evil.into())], 1);
        let shown = Shown { id: evil.into(), words: evil.into(), twin: Some(evil.into()) };
        figures.gallery.push(shown);
        figures.twins.push((evil.into(), evil.into()));
        let page = page(evil, &figures, &BTreeMap::new());
        assert!(!page.contains("<script") && !page.contains("\"onload"), "{page}");
        assert!(page.contains("&lt;script&gt;") && page.contains("\\u{202e}\\u{9b}\\u{a}b"));
        assert!(!page.contains(['\u{202e}', '\u{9b}']));
        assert!(page.contains("and 8 more") && page.contains("not a rule of this profile"));
    }

    #[test]
    fn a_page_about_nothing_is_a_page() {
        let page = page("empty", &Figures::default(), &BTreeMap::new());
        assert!(page.contains("everything was accepted") && page.ends_with("</html>\n"));
        assert!(!page.contains("http://") && !page.contains("https://"));
    }
}
