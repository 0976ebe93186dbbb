use super::*;

fn entry(step: &str, fate: Fate) -> Entry {
    let (question, usage) = (Digest::of(b"q"), Usage::default());
    Entry { question, step: step.into(), work: true, fate, usage, money: None }
}

fn go(_: &[Entry], _: &BTreeSet<u64>) -> Leave {
    Leave::Go
}

/// A book of some requests of which the first came back.
fn book(requests: usize) -> (tempfile::TempDir, FileBook) {
    let dir = tempfile::tempdir().unwrap();
    let book = FileBook::new(dir.path().join("deep/spent.jsonl"));
    assert!(book.entries().unwrap().is_empty());
    for n in 0..requests {
        let number = book.ask(&entry(&format!("s{n}"), Fate::Asked), &go).unwrap();
        assert_eq!(number, n as u64);
    }
    book.settle(0, &entry("s0", Fate::Answered)).unwrap();
    (dir, book)
}

/// What a fresh program finds in the book.
fn found(book: &FileBook) -> Result<Vec<Fate>, String> {
    let entries = FileBook::new(book.path.clone()).entries();
    Ok(entries.map_err(|e| e.to_string())?.iter().map(|e| e.fate).collect())
}

#[test]
fn what_was_asked_stands_in_the_book_and_what_came_of_it_replaces_that() {
    let (_dir, book) = book(3);
    assert_eq!(found(&book).unwrap(), [Fate::Answered, Fate::Asked, Fate::Asked]);
    book.settle(2, &entry("s2", Fate::Lost)).unwrap();
    assert_eq!(found(&book).unwrap(), [Fate::Answered, Fate::Asked, Fate::Lost]);
}

#[test]
fn a_line_cut_short_by_a_crash_was_never_acted_upon() {
    let (_dir, book) = book(1);
    let mut bytes = std::fs::read(&book.path).unwrap();
    bytes.extend_from_slice(b"{\"question\": \"ab");
    std::fs::write(&book.path, bytes).unwrap();
    assert_eq!(found(&book).unwrap(), [Fate::Answered]);
    book.ask(&entry("s1", Fate::Asked), &go).unwrap();
    assert_eq!(found(&book).unwrap(), [Fate::Answered, Fate::Asked]);
}

#[test]
fn lines_that_were_deleted_changed_moved_or_added_are_found() {
    let (_dir, book) = book(3);
    let whole = std::fs::read_to_string(&book.path).unwrap();
    let lines: Vec<_> = whole.split_inclusive('\n').collect();
    assert_eq!(lines.len(), 4);
    let without = |n: usize| {
        lines.iter().enumerate().filter(|(i, _)| *i != n).map(|(_, l)| *l).collect::<String>()
    };
    let forgeries = [
        (without(0), "does not follow"),
        (without(2), "does not follow"),
        (without(3), "missing at its end"),
        (String::new(), "missing at its end"),
        (whole.replacen("s1", "s9", 1), "line 2: it was changed"),
        (format!("{}{}{}{}", lines[1], lines[0], lines[2], lines[3]), "does not follow"),
        (format!("{whole}{}", lines[3]), "does not follow"),
        (
            format!(
                "{whole}{{\"question\":\"{}\",\"step\":\"s\",\"work\":true,\"usage\":{{}}}}\n",
                Digest::of(b"q")
            ),
            "not chained",
        ),
    ];
    for (text, told) in forgeries {
        std::fs::write(&book.path, &text).unwrap();
        let error = found(&book).unwrap_err();
        assert!(error.contains(told), "{error} is not: {told}");
        let error = FileBook::new(book.path.clone()).ask(&entry("s", Fate::Asked), &go);
        assert!(matches!(error, Err(Unbooked::Book(_))), "nothing is spent on it");
    }
    std::fs::remove_file(&book.path).unwrap();
    assert!(found(&book).unwrap_err().contains("missing at its end"), "the whole book");
    std::fs::write(&book.path, &whole).unwrap();
    assert_eq!(found(&book).unwrap().len(), 3);
    std::fs::remove_file(book.head_path()).unwrap();
    assert!(found(&book).unwrap_err().contains("is gone"));
}

#[test]
fn the_end_of_the_chain_may_be_one_line_behind_after_a_crash() {
    let (_dir, book) = book(2);
    let head = std::fs::read(book.head_path()).unwrap();
    book.settle(1, &entry("s1", Fate::Lost)).unwrap();
    std::fs::write(book.head_path(), head).unwrap();
    assert_eq!(found(&book).unwrap(), [Fate::Answered, Fate::Lost]);
}

#[test]
fn a_book_of_the_first_release_is_gone_on_with_and_told_to_be_unchained() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("spent.jsonl");
    let old = format!(
        "{{\"question\":\"{}\",\"step\":\"vlm.points/0\",\"work\":true,\"usage\":{{\"input\":3,\"output\":4}}}}\n",
        Digest::of(b"q")
    );
    std::fs::write(&path, old.repeat(2)).unwrap();
    let book = FileBook::new(path.clone());
    assert_eq!((book.entries().unwrap().len(), book.unchained().unwrap()), (2, 2));
    assert_eq!(book.entries().unwrap()[0].usage.input, Some(3));
    book.ask(&entry("s", Fate::Asked), &go).unwrap();
    assert_eq!(found(&book).unwrap(), [Fate::Answered, Fate::Answered, Fate::Asked]);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("\"input\":3", "\"input\":1", 1)).unwrap();
    assert!(
        found(&book).unwrap_err().contains("does not follow"),
        "old lines are held from now on"
    );
}

#[test]
fn what_waits_for_a_request_under_way_goes_on_when_that_is_back() {
    let (_dir, book) = book(1);
    let number = book.ask(&entry("first", Fate::Asked), &go).unwrap();
    let alone = |_: &[Entry], under_way: &BTreeSet<u64>| {
        if under_way.is_empty() { Leave::Go } else { Leave::Wait }
    };
    std::thread::scope(|scope| {
        let second = scope.spawn(|| book.ask(&entry("second", Fate::Asked), &alone).unwrap());
        book.settle(number, &entry("first", Fate::Answered)).unwrap();
        assert_eq!(second.join().unwrap(), number + 1);
    });
}

#[test]
fn two_books_on_one_file_see_each_others_lines() {
    let (_dir, book) = book(1);
    let other = FileBook::new(book.path.clone());
    assert_eq!(other.ask(&entry("s1", Fate::Asked), &go).unwrap(), 1);
    assert_eq!(book.ask(&entry("s2", Fate::Asked), &go).unwrap(), 2);
    other.settle(1, &entry("s1", Fate::Refused)).unwrap();
    assert_eq!(found(&book).unwrap(), [Fate::Answered, Fate::Refused, Fate::Asked]);
}

#[test]
fn what_is_no_book_is_told() {
    let (_dir, book) = book(1);
    std::fs::write(&book.path, b"nonsense\n").unwrap();
    assert!(found(&book).unwrap_err().contains("expected an account book"));
}
