//! What the page's address carries, so that nobody else is answered.

/// A secret that the page's address carries.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// A new one of 128 random bits.
    ///
    /// # Errors
    /// What the operating system says when it has no randomness.
    pub fn new() -> std::io::Result<Self> {
        let mut bytes = [0u8; 16];
        getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
        Ok(Self(bytes.iter().map(|b| format!("{b:02x}")).collect()))
    }

    /// One that somebody chose.
    pub fn of(secret: impl Into<String>) -> Self {
        Self(secret.into())
    }

    /// As it stands in an address.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether it was said; how much of it is right takes no time to tell.
    pub(crate) fn is(&self, said: &str) -> bool {
        blake3::hash(said.as_bytes()) == blake3::hash(self.0.as_bytes())
    }
}
