//! The sizes of the network, and the two presets.

use serde::{Deserialize, Serialize};

/// Every size of the network; stored beside the weights.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// D, width of all tokens; a multiple of `heads`.
    pub width: usize,
    /// Attention heads.
    pub heads: usize,
    /// B, attention blocks.
    pub blocks: usize,
    /// N, points the shape is seen through.
    pub points: usize,
    /// L, shape tokens.
    pub tokens: usize,
    /// M, queries decoded together, in training and in inference.
    pub chunk: usize,
    /// K, queries on the surface in inference.
    pub queries: usize,
    /// Features of a point.
    pub features: usize,
    /// Numbers of a text's embedding.
    pub text: usize,
    /// Most parts of an object.
    pub max_parts: usize,
    /// How the joint head writes positions.
    pub positions: Positions,
}

/// How the joint head writes the axis point and the two limit positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Positions {
    /// As coordinates in the unit cube.
    Absolute,
    /// As offsets from the query point, which the network then need not memorise.
    Offset,
}

/// Sizes that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("network size `{name}` must be {rule}, found {found}")]
pub struct ConfigError {
    /// The size.
    pub name: &'static str,
    /// What it must be.
    pub rule: String,
    /// What it is.
    pub found: usize,
}

impl Config {
    /// The paper's network: 170 million parameters (paper, appendix, training configuration).
    pub fn paper() -> Self {
        Self {
            width: 768,
            heads: 12,
            blocks: 6,
            points: 10_240,
            tokens: 2_048,
            chunk: 4_096,
            queries: 102_400,
            features: 448,
            text: 768,
            max_parts: 64,
            positions: Positions::Absolute,
        }
    }

    /// The network that is shipped: a 40,000-face object in about a second on two cores.
    pub fn small() -> Self {
        Self {
            width: 256,
            heads: 4,
            blocks: 4,
            points: 4_096,
            tokens: 512,
            chunk: 2_048,
            queries: 12_288,
            features: crate::features::geometric::WIDTH,
            text: crate::features::text::NGRAM_WIDTH,
            max_parts: 64,
            positions: Positions::Offset,
        }
    }

    /// Proves that the sizes make a network, and one that fits a memory.
    ///
    /// # Errors
    /// [`ConfigError`], the first size that breaks its rule.
    pub fn check(&self) -> Result<(), ConfigError> {
        let limits = [
            ("width", self.width, 4_096),
            ("heads", self.heads, 256),
            ("blocks", self.blocks, 64),
            ("points", self.points, 1 << 20),
            ("tokens", self.tokens, 1 << 16),
            ("chunk", self.chunk, 1 << 16),
            ("queries", self.queries, 1 << 22),
            ("features", self.features, 4_096),
            ("text", self.text, 1 << 16),
            ("max_parts", self.max_parts, object::kinematics::MAX_PARTS),
        ];
        within(&limits)?;
        if !self.width.is_multiple_of(self.heads) {
            let rule = format!("a multiple of `heads` ({})", self.heads);
            return Err(ConfigError { name: "width", rule, found: self.width });
        }
        Ok(())
    }
}

/// Proves that sizes (name, found, most) are at least 1 and no more than allowed.
pub(super) fn within(limits: &[(&'static str, usize, usize)]) -> Result<(), ConfigError> {
    for &(name, found, most) in limits {
        if found == 0 || found > most {
            return Err(ConfigError { name, rule: format!("between 1 and {most}"), found });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_sound_and_nonsense_is_named() {
        assert_eq!(Config::paper().check(), Ok(()));
        assert_eq!(Config::small().check(), Ok(()));
        let odd = Config { heads: 7, ..Config::small() };
        let told = odd.check().unwrap_err().to_string();
        assert_eq!(told, "network size `width` must be a multiple of `heads` (7), found 256");
        assert!(Config { blocks: 0, ..Config::small() }.check().is_err());
    }
}
