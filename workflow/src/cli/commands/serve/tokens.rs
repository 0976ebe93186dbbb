//! Who may ask a service, and what each may spend.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use adapters::budget::Budget;
use serde::Deserialize;
use studio::Token;

use crate::batch::purse::Shares;
use crate::cli::speech::Complaint;

/// The variable that holds the one token where no file names several; `kinfold.connect` reads it, too.
const VARIABLE: &str = "KINFOLD_TOKEN";
/// Whose the one token is.
const OWNER: &str = "owner";
/// Where it is kept, in the service's folder.
const KEPT: &str = "token";
/// Fewest characters of a token: fewer can be guessed at over a network.
const FEWEST: usize = 20;
/// Most characters of a token, and of the name of whose it is: guesses; both are compared and become names.
const MOST: usize = 200;
const MOST_NAME: usize = 32;
/// Most bytes of a file of tokens: some thousand of them.
const MOST_BYTES: u64 = 1 << 20;

/// Who may ask.
pub(super) struct Tokens {
    /// Each token, by whose it is.
    pub tokens: Vec<(String, Token)>,
    /// What each may spend.
    pub shares: Shares,
    /// How many jobs of each may wait.
    pub waiting: BTreeMap<String, u64>,
    /// The one token that is to be printed: nobody chose it.
    pub made: Option<Token>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    tokens: BTreeMap<String, Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    env: String,
    max_calls: Option<u64>,
    max_cost: Option<f64>,
    max_waiting: Option<u64>,
}

/// The tokens that a file names, else the one of the environment; none where nobody chose any.
pub(super) fn chosen(file: Option<&Path>, most_waiting: u64) -> Result<Option<Tokens>, Complaint> {
    let Some(file) = file else {
        let said = std::env::var(VARIABLE).ok().filter(|said| !said.is_empty());
        let token = said.map(|said| checked(VARIABLE, &said)).transpose()?;
        return Ok(token.map(|token| Tokens::of_one(token, most_waiting)));
    };
    let named = runner::ours::name(file);
    let read = guard::files::read(file, MOST_BYTES);
    let read = read.map_err(|e| {
        Complaint::misused(format!("{named}: {e}"))
            .hint("name a file of tokens; `kinfold serve --help` shows one")
    })?;
    let text = String::from_utf8_lossy(&read);
    let File { tokens } = toml::from_str(&text).map_err(|e| {
        let complaint = Complaint::misused(format!("{named}: {}", e.message()));
        complaint.hint("`kinfold serve --help` shows such a file")
    })?;
    of(tokens, most_waiting)
        .map(Some)
        .map_err(|(what, hint)| Complaint::misused(format!("{named}: {what}")).hint(hint))
}

/// The one token that is kept in a folder, where it is made the first time.
pub(super) fn own(folder: &Path, most_waiting: u64) -> Result<Tokens, Complaint> {
    let token = kept(&folder.join(KEPT))?;
    Ok(Tokens { made: Some(token.clone()), ..Tokens::of_one(token, most_waiting) })
}

impl Tokens {
    fn of_one(token: Token, most_waiting: u64) -> Self {
        let owner = || OWNER.to_owned();
        Self {
            tokens: vec![(owner(), token)],
            shares: [(owner(), Budget::default())].into(),
            waiting: [(owner(), most_waiting)].into(),
            made: None,
        }
    }
}

/// What is wrong, and what to do.
type Wrong = (String, String);

fn of(entries: BTreeMap<String, Entry>, most_waiting: u64) -> Result<Tokens, Wrong> {
    let (mut tokens, made) = (Vec::new(), None);
    let (mut shares, mut waiting) = (Shares::new(), BTreeMap::new());
    if entries.is_empty() {
        let found = "expected a table [tokens.NAME] for whoever may ask, found none".to_owned();
        return Err((found, "`kinfold serve --help` shows such a file".into()));
    }
    let mut said = BTreeMap::new();
    for (name, Entry { env, max_calls, max_cost, max_waiting }) in entries {
        let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c);
        if name.is_empty() || name.len() > MOST_NAME || !name.chars().all(fits) {
            let rule = format!(
                "[tokens.{name}]: a name has 1 to {MOST_NAME} small letters, digits, `_` or `-`"
            );
            return Err((rule, "call it otherwise".into()));
        }
        if max_cost.is_some_and(|cost| !(cost >= 0.0 && cost.is_finite())) {
            let found = format!("[tokens.{name}]: max_cost is an amount of at least 0");
            return Err((found, "leave it out where nothing limits it".into()));
        }
        let secret = std::env::var(&env).map_err(|_| {
            let found = format!("[tokens.{name}]: the environment has no `{env}`");
            (found, format!("set {env} to the token, such as `openssl rand -hex 16` makes one"))
        })?;
        let token = checked(&env, &secret).map_err(|c| (c.message, c.hints.join("; ")))?;
        if let Some(other) = said.insert(secret, name.clone()) {
            let found = format!("[tokens.{name}]: its token is that of [tokens.{other}]");
            return Err((found, format!("set {env} to another one")));
        }
        let share = Budget { calls: max_calls, money: max_cost, ..Budget::default() };
        shares.insert(name.clone(), share);
        waiting.insert(name.clone(), max_waiting.unwrap_or(most_waiting));
        tokens.push((name, token));
    }
    Ok(Tokens { tokens, shares, waiting, made })
}

fn checked(name: &str, secret: &str) -> Result<Token, Complaint> {
    let fits =
        (FEWEST..=MOST).contains(&secret.len()) && secret.bytes().all(|b| b.is_ascii_graphic());
    if fits {
        return Ok(Token::of(secret));
    }
    // What was found is a secret.
    let rule =
        format!("{name}: a token has {FEWEST} to {MOST} visible ASCII characters, found another");
    Err(Complaint::misused(rule).hint("`openssl rand -hex 16` makes one"))
}

/// The token that a file holds, which only its owner reads; it is made where there is none.
fn kept(path: &PathBuf) -> Result<Token, Complaint> {
    let named = runner::ours::name(path);
    let failed = |e: String| {
        Complaint::failed(format!("{named}: {e}"))
            .hint("remove the file, and another token is made; or set KINFOLD_TOKEN")
    };
    if path.exists() {
        let read = guard::files::read(path, 1 << 10).map_err(|e| failed(e.to_string()))?;
        let text = String::from_utf8_lossy(&read);
        return checked(&named, text.trim()).map_err(|_| failed("it holds no token".into()));
    }
    let token = Token::new().map_err(|e| failed(format!("no random token: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    // A temporary file is its owner's alone, and stands there whole or not at all.
    let written = tempfile::NamedTempFile::new_in(folder).and_then(|mut file| {
        writeln!(file, "{}", token.as_str())?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|e| e.error)
    });
    written.map_err(|e| failed(e.to_string()))?;
    Ok(token)
}
