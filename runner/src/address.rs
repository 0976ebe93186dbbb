//! Where a shared store is: a folder, or a bucket of somebody's.
//!
//! ```
//! use runner::Address;
//!
//! let address: Address = "s3://ours/stages/".parse()?;
//! assert_eq!(address.to_string(), "s3://ours/stages");
//! assert!("s3:/ours".parse::<Address>().is_err());
//! # Ok::<(), String>(())
//! ```

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Address of a shared store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A folder that all machines see: `/shared/stages`, or `file:///shared/stages`.
    Folder(PathBuf),
    /// A bucket: `s3://bucket/prefix`, `gs://bucket/prefix`, `az://container/prefix`.
    Bucket {
        /// Whose bucket.
        cloud: Cloud,
        /// Its name.
        bucket: String,
        /// What every name in it begins with; may be empty.
        prefix: String,
    },
}

/// Whose buckets there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cloud {
    /// Amazon's S3, and everything that speaks as it does.
    S3,
    /// Google Cloud Storage.
    Gcs,
    /// Azure Blob Storage.
    Azure,
}

impl Cloud {
    const ALL: [(&'static str, Self); 3] =
        [("s3", Self::S3), ("gs", Self::Gcs), ("az", Self::Azure)];

    fn scheme(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, cloud)| *cloud == self).map_or("", |(scheme, _)| scheme)
    }
}

const EXPECTED: &str =
    "a folder, file:///FOLDER, s3://BUCKET/PREFIX, gs://BUCKET/PREFIX or az://CONTAINER/PREFIX";

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = |why: &str| Err(format!("expected {EXPECTED}, found `{text}`{why}"));
        let Some((scheme, rest)) = text.split_once("://") else {
            // A slash that was forgotten, not a folder of that name.
            let half = ["file:", "s3:", "gs:", "az:"].iter().any(|scheme| text.starts_with(scheme));
            return if text.is_empty() || half {
                expected("")
            } else {
                Ok(Self::Folder(text.into()))
            };
        };
        if scheme == "file" {
            let rooted = rest.starts_with('/');
            return if rooted { Ok(Self::Folder(rest.into())) } else { expected("") };
        }
        let Some((_, cloud)) = Cloud::ALL.into_iter().find(|(name, _)| *name == scheme) else {
            return expected("");
        };
        if rest.contains(['@', '?', '#']) {
            // Not repeated: what stands there may be a key.
            return Err(format!(
                "expected {EXPECTED}, found one with `@`, `?` or `#`: keys come from the environment"
            ));
        }
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if bucket.is_empty() {
            return expected(": it names no bucket");
        }
        let prefix = prefix.trim_matches('/');
        if !prefix.is_empty() && prefix.split('/').any(|part| ["", ".", ".."].contains(&part)) {
            return expected(": a part of its prefix is empty, `.` or `..`");
        }
        Ok(Self::Bucket { cloud, bucket: bucket.into(), prefix: prefix.into() })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) => write!(f, "{}", path.display()),
            Self::Bucket { cloud, bucket, prefix } if prefix.is_empty() => {
                write!(f, "{}://{bucket}", cloud.scheme())
            }
            Self::Bucket { cloud, bucket, prefix } => {
                write!(f, "{}://{bucket}/{prefix}", cloud.scheme())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Address, String> {
        text.parse()
    }

    #[test]
    fn an_address_is_a_folder_or_a_bucket_and_is_said_as_it_was_read() {
        for text in ["/shared/stages", "stages", "s3://ours", "gs://ours/a/b", "az://box/a"] {
            assert_eq!(read(text).unwrap().to_string(), text);
        }
        assert_eq!(read("file:///shared/x"), Ok(Address::Folder("/shared/x".into())));
        let (cloud, bucket, prefix) = (Cloud::S3, "ours".into(), "a/b".into());
        assert_eq!(read("s3://ours/a/b/"), Ok(Address::Bucket { cloud, bucket, prefix }));
    }

    #[test]
    fn what_is_no_address_is_told_with_the_rule_and_a_key_is_never_repeated() {
        for text in [
            "",
            "s3:/ours",
            "http://here",
            "s3://",
            "s3:///a",
            "file://a/b",
            "gs://a/b//c",
            "az://a/../b",
        ] {
            let why = read(text).unwrap_err();
            assert!(why.starts_with("expected a folder, file:///FOLDER, s3://"), "{why}");
            assert!(why.contains(&format!("found `{text}`")), "{why}");
        }
        for text in ["s3://key:secret@ours/a", "az://box?sig=secret"] {
            assert!(!read(text).unwrap_err().contains("secret"));
        }
    }
}
