//! What the files of an asset's folder are called, of a run and of an item of a batch.

/// The trace.
pub(crate) const TRACE: &str = "trace.mcap";
/// Its signature.
pub(crate) const SIGNATURE: &str = "trace.mcap.minisig";
/// What was found about the asset.
pub(crate) const VERDICT: &str = "verdict.json";
/// The statement about an item of a batch.
pub(crate) const STATEMENT: &str = "attestation.json";
/// The statement, signed.
pub(crate) const ENVELOPE: &str = "attestation.dsse.json";
/// Why an item of a batch was not accepted.
pub(crate) const REASON: &str = "reason.json";
