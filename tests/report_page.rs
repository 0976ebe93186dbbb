//! The batch report as a person opens it: in a browser, from the file alone.
//!
//! `KINFOLD_CHROMIUM` names a Chromium where it is not called `chromium`.

use std::path::Path;
use std::process::Command;

use trace::Digest;
use workflow::batch::record::Ended;
use workflow::batch::{Ledger, Record};

use crate::batch::Batch;

/// What Chromium is told so that it shows one page and asks nobody on its own account.
const QUIET: &[&str] = &[
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-logging=stderr",
    "--window-size=1280,1600",
];

/// A browser, if there is one; said loudly where there is none.
fn chromium() -> Option<String> {
    let name = std::env::var("KINFOLD_CHROMIUM").unwrap_or_else(|_| "chromium".into());
    if Command::new(&name).arg("--version").output().is_ok_and(|o| o.status.success()) {
        return Some(name);
    }
    eprintln!("SKIPPED: no {name}");
    None
}

/// Opens a page and takes a picture of it; what its console says.
fn opened(browser: &str, page: &Path, picture: &Path) -> Vec<String> {
    let own = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(QUIET)
        .arg(format!("--user-data-dir={}", own.path().display()))
        .arg(format!("--screenshot={}", picture.display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && picture.is_file(), "{said}");
    said.lines().filter(|l| l.contains(":CONSOLE")).map(str::to_owned).collect()
}

#[test]
fn the_report_opens_in_a_browser_without_an_error_and_asks_nobody() {
    let Some(browser) = chromium() else { return };
    let batch = Batch::of(2);
    batch.ran(&[]);
    batch.say(&["batch", "report", "out"]);
    let (page, picture) = (batch.path("out/report.html"), batch.path("report.png"));
    assert_eq!(opened(&browser, &page, &picture), [""; 0]);

    // The page forbids itself the network, so that a page that asks somebody complains of it.
    let asks = std::fs::read_to_string(&page).unwrap();
    let asks = asks.replacen("<main>", "<main><img src=\"http://127.0.0.1:9/x.png\">", 1);
    batch.write("asks.html", asks);
    let said = opened(&browser, &batch.path("asks.html"), &batch.path("asks.png"));
    assert!(said.len() == 1 && said[0].contains("Content Security Policy"), "{said:?}");

    let shown = image::open(&picture).unwrap().to_rgb8();
    assert_eq!(shown.dimensions(), (1280, 1600));
    let count = |is: &dyn Fn([u8; 3]) -> bool| shown.pixels().filter(|p| is(p.0)).count();
    let cards = count(&|p| p == [255; 3]);
    let bars = count(&|[r, g, b]| g > 100 && g - 40 > r && g - 30 > b);
    assert!(cards > 500_000, "{cards} white pixels: no cards");
    assert!(bars > 5_000, "{bars} green pixels: no bars of what was accepted");

    // The same page without its pictures looks otherwise where they were.
    let bare = std::fs::read_to_string(&page).unwrap().replace("<img ", "<span ");
    batch.write("bare.html", bare);
    let picture = batch.path("bare.png");
    opened(&browser, &batch.path("bare.html"), &picture);
    let bare = image::open(&picture).unwrap().to_rgb8();
    let thumbnails = shown.pixels().zip(bare.pixels()).filter(|(a, b)| a != b).count();
    assert!(thumbnails > 10_000, "{thumbnails} pixels differ: no thumbnails");
}

#[test]
fn the_report_names_what_failed_lists_bad_lines_and_leads_to_the_pages() {
    let batch = Batch::of(2);
    batch.write("no.png", "no picture");
    let mut text = std::fs::read_to_string(batch.path("items.jsonl")).unwrap();
    let mut blind = Batch::given("blind", 1);
    blind["photo"] = "no.png".into();
    text.push_str(&format!("{blind}\n{{\"id\": \"nothing\"}}\nno item at all\n"));
    batch.write("items.jsonl", text);
    batch.ran(&["--pages"]);
    batch.say(&["batch", "report", "out"]);
    let page = std::fs::read_to_string(batch.path("out/report.html")).unwrap();
    for id in ["k000", "k001"] {
        assert!(page.contains(&format!("<a href=\"assets/{id}/viewer.html\">")), "{id}");
        assert!(batch.path("out/assets").join(id).join("viewer.html").is_file());
    }
    let count = |what: &str| page.matches(what).count();
    assert_eq!([count("data:image/jpeg;base64,"), count("data:image/webp;base64,")], [2, 2]);
    assert!(page.len() < 1 << 20, "{} bytes", page.len());
    let (_, reasons) = page.split_once("What was not accepted").unwrap();
    let (reasons, lines) = reasons.split_once("Lines of the manifest that are no items").unwrap();
    assert!(reasons.contains("<td class=why>blind</tr>"), "{reasons}");
    for line in
        ["<td class=n>4<td class=why>", "<td class=n>5<td class=why>expected an item as JSON"]
    {
        assert!(lines.contains(line), "{line}: {lines}");
    }
}

#[test]
fn the_report_counts_the_checks_that_fail() {
    let folder = tempfile::tempdir().unwrap();
    let ledger = Ledger::open(&folder.path().join(workflow::batch::ledger::FILE)).unwrap();
    let question = Digest::of(b"q");
    let ended = [(Ended::Accepted, "J7"), (Ended::Rejected, "M6 J7"), (Ended::Failed, "")];
    for (n, (outcome, checks)) in ended.into_iter().enumerate() {
        let mut record = Record::new(format!("k{n}"), outcome);
        record.failed_checks = Some(checks.into());
        ledger.add(1, &question, &[(question.clone(), record)]).unwrap();
    }
    drop(ledger);
    let (page, _) = workflow::batch::report::write(folder.path()).unwrap();
    let page = std::fs::read_to_string(page).unwrap();
    let (_, checks) = page.split_once("Checks that fail").unwrap();
    let (j7, m6) = (
        checks.find("<tr><td>J7<td class=n>2<td class=n>1"),
        checks.find("<tr><td>M6<td class=n>1<td class=n>0"),
    );
    assert!(j7.unwrap() < m6.unwrap(), "commonest first: {checks}");
}
