//! Versions of the code behind a stage: digests of the sources of the rooms it calls.

/// What every stage's code rests on: how files are read, the shared types and the stages themselves.
const GROUND: [&str; 4] = [
    env!("CARGO_PKG_VERSION"),
    env!("KINFOLD_CODE_GUARD"),
    env!("KINFOLD_CODE_OBJECT"),
    env!("KINFOLD_CODE_STAGES"),
];

/// Sources of the adapters.
pub(super) const ADAPTERS: &str = env!("KINFOLD_CODE_ADAPTERS");
/// Sources of the renderer.
pub(super) const VIEW: &str = env!("KINFOLD_CODE_VIEW");
/// Sources of the articulators.
pub(super) const MODEL: &str = env!("KINFOLD_CODE_MODEL");
/// Sources of the asset builder.
pub(super) const ASSET: &str = env!("KINFOLD_CODE_ASSET");
/// Sources of the checker.
pub(super) const SIM_CHECK: &str = env!("KINFOLD_CODE_SIM_CHECK");

/// Sources of the page.
pub(super) const PAGE: &str = env!("KINFOLD_CODE_PAGE");

/// The version of a stage that calls these rooms.
pub(super) fn version(rooms: &[&str]) -> String {
    [&GROUND, rooms].concat().join("+")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_names_the_program_and_every_room_it_rests_on() {
        let text = version(&[VIEW]);
        assert!(text.starts_with(env!("CARGO_PKG_VERSION")) && text.ends_with(VIEW), "{text}");
        assert_eq!(text.split('+').count(), 5);
    }
}
