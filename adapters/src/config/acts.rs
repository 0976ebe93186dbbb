//! What a configuration would do that its providers do not do by themselves: what a person must
//! know before a file that somebody else may have written is obeyed.

use std::net::IpAddr;
use std::path::{Path, PathBuf};

use trace::Digest;

use super::{Config, GeneratorConfig, VlmConfig, reading};
use crate::AdapterError;
use crate::bounded::read_limited;
use crate::generators::comfy::Workflow;
use crate::net::redact;

/// Largest configuration file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// A configuration as it stands in a file: nothing that it names was read, sent or started.
#[derive(Clone, Debug)]
pub struct Draft {
    config: Config,
    /// The file.
    pub path: PathBuf,
    /// The file's bytes.
    pub digest: Digest,
}

impl Draft {
    /// Reads the file and nothing else.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file, the line and the field.
    pub fn read(path: &Path) -> Result<Self, AdapterError> {
        let name = path.display().to_string();
        let bytes = read_limited(path, MAX_BYTES)?;
        let digest = Digest::of(&bytes);
        let text = String::from_utf8(bytes).map_err(|_| AdapterError::Format {
            path: name.clone(),
            expected: "a kinfold configuration",
            found: "bytes that are no UTF-8".into(),
        })?;
        let config = reading::read(&name, &text)?;
        Ok(Self { config, path: path.to_path_buf(), digest })
    }

    /// What it says; the files it names are not read.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The same without the sections that a given file stands in for.
    #[must_use]
    pub fn without(self, mesh: bool, condition: bool) -> Self {
        Self { config: self.config.without(mesh, condition), ..self }
    }

    /// What it would do that the providers do not do by themselves, one sentence each; none where
    /// there is nothing to approve.
    pub fn acts(&self) -> Vec<String> {
        let mut told = vec![];
        if let Some(generator) = &self.config.image_to_3d {
            told.extend(of_generator(generator));
        }
        if let Some(vlm) = &self.config.vlm {
            told.extend(of_vlm(vlm));
        }
        told
    }

    /// The configuration, once a person said that it may act: the files it names are read.
    ///
    /// # Errors
    /// [`AdapterError`] where one cannot be read.
    pub fn approved(self) -> Result<Config, AdapterError> {
        let mut config = self.config;
        if let Some(generator) = &mut config.image_to_3d {
            generator.read_files(self.path.parent().unwrap_or(Path::new(".")))?;
        }
        Ok(config)
    }
}

fn of_generator(generator: &GeneratorConfig) -> Vec<String> {
    const SECTION: &str = "[image_to_3d]";
    if let GeneratorConfig::Command { program, arguments, .. } = generator {
        let words = [program].into_iter().chain(arguments).cloned().collect::<Vec<_>>().join(" ");
        return vec![format!("{SECTION} starts the program `{words}`")];
    }
    let usual = generator.usual();
    let base = generator.base().filter(|base| Some(*base) != usual.base);
    let keys = [generator.id_variable(), generator.key_variable()];
    let mut told = sends(SECTION, base, generator.base(), &keys, &[usual.id, usual.key]);
    if let GeneratorConfig::Comfyui { workflow: Workflow::File(file), .. } = generator {
        told.push(format!("{SECTION} sends the workflow in `{file}`"));
    }
    told
}

fn of_vlm(vlm: &VlmConfig) -> Vec<String> {
    let base = Some(vlm.base()).filter(|base| *base != vlm.usual_base());
    sends("[vlm]", base, Some(vlm.base()), &[vlm.key_variable()], &[Some(vlm.usual_key())])
}

/// Where pictures and keys go, if not where they usually go.
fn sends(
    section: &str,
    other: Option<&str>,
    base: Option<&str>,
    keys: &[Option<&str>],
    usual: &[Option<&str>],
) -> Vec<String> {
    let mut told: Vec<_> = other
        .map(|base| format!("{section} sends pictures to {}", redact::url(base)))
        .into_iter()
        .collect();
    let host = redact::host(base.unwrap_or_default());
    for (key, usual) in keys.iter().zip(usual) {
        if let Some(variable) = key.filter(|_| other.is_some() || key != usual) {
            told.push(format!("{section} sends what {variable} holds to {host}"));
        }
    }
    told
}

/// Whether a key may be sent to an address: over https, or to this very machine.
pub fn may_carry_keys(url: &str) -> bool {
    let Ok(uri) = url.parse::<ureq::http::Uri>() else { return false };
    let host = uri.host().unwrap_or_default().trim_matches(['[', ']']);
    let own = host.eq_ignore_ascii_case("localhost")
        || host.parse::<IpAddr>().is_ok_and(|ip| ip.to_canonical().is_loopback());
    uri.scheme_str() == Some("https") || own
}

impl Config {
    /// Reads a configuration file that a person named, and the files that it names.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file, the line and the field.
    pub fn open(path: &Path) -> Result<Self, AdapterError> {
        Draft::read(path)?.approved()
    }

    /// Refuses addresses to which a key, or a password in the address itself, would leave in plain.
    ///
    /// # Errors
    /// [`AdapterError::Plain`], naming the host and the variable.
    pub fn check_keys(&self) -> Result<(), AdapterError> {
        let generator = self.image_to_3d.as_ref().and_then(|g| Some((g.base()?, g.key_variable())));
        let vlm = self.vlm.as_ref().map(|vlm| (vlm.base(), vlm.key_variable()));
        for (base, key) in generator.into_iter().chain(vlm) {
            let uri = base.parse::<ureq::http::Uri>().ok();
            let user = uri.is_some_and(|u| u.authority().is_some_and(|a| a.as_str().contains('@')));
            let variable = key.or(user.then_some("the address"));
            if let Some(variable) = variable.filter(|_| !may_carry_keys(base)) {
                let (host, variable) = (redact::host(base), variable.to_owned());
                return Err(AdapterError::Plain { host, variable });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draft(text: &str) -> Draft {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Draft::read(file.path()).unwrap()
    }

    #[test]
    fn what_a_provider_does_by_itself_needs_nobodys_leave() {
        let usual = [
            "",
            "[vlm]\nprovider = 'openai'\nmodel = 'm'\n",
            "[vlm]\nprovider = 'openai'\nmodel = 'm'\nkey_env = 'OPENAI_API_KEY'\n",
            "[vlm]\nprovider = 'anthropic'\nmodel = 'm'\nbase = 'https://api.anthropic.com'\n",
            "[image_to_3d]\nprovider = 'meshy'\nmodel = 'meshy-6'\n[budget]\nmoney = 1.0\n",
            "[image_to_3d]\nprovider = 'tencent'\nmodel = '3.1'\nregion = 'r'\n",
        ];
        for text in usual {
            assert_eq!(draft(text).acts(), Vec::<String>::new(), "{text}");
        }
    }

    #[test]
    fn programs_addresses_and_other_variables_are_told() {
        let cases: [(&str, &[&str]); 6] = [
            (
                "[image_to_3d]\nprovider = 'command'\nprogram = './x'\narguments = ['{image}']\n",
                &["[image_to_3d] starts the program `./x {image}`"],
            ),
            (
                "[vlm]\nprovider = 'openai'\nmodel = 'm'\nbase = 'http://127.0.0.1:9/v1'\n\
                 key_env = 'AWS_SECRET_ACCESS_KEY'\n",
                &[
                    "[vlm] sends pictures to http://127.0.0.1:9/v1",
                    "[vlm] sends what AWS_SECRET_ACCESS_KEY holds to 127.0.0.1:9",
                ],
            ),
            (
                "[vlm]\nprovider = 'gemini'\nmodel = 'm'\nkey_env = 'GITHUB_TOKEN'\n",
                &["[vlm] sends what GITHUB_TOKEN holds to generativelanguage.googleapis.com"],
            ),
            (
                "[image_to_3d]\nprovider = 'meshy'\nmodel = 'm'\nbase = 'https://me:pw@h.example'\n",
                &[
                    "[image_to_3d] sends pictures to https://h.example/",
                    "[image_to_3d] sends what MESHY_API_KEY holds to h.example",
                ],
            ),
            (
                "[image_to_3d]\nprovider = 'tencent'\nmodel = '3.1'\nid_env = 'USER'\n",
                &["[image_to_3d] sends what USER holds to ai3d.tencentcloudapi.com"],
            ),
            (
                "[image_to_3d]\nprovider = 'comfyui'\nbase = 'http://h'\nworkflow = '/etc/passwd'\n\
                 image_node = '1'\n",
                &[
                    "[image_to_3d] sends pictures to http://h/",
                    "[image_to_3d] sends the workflow in `/etc/passwd`",
                ],
            ),
        ];
        for (text, acts) in cases {
            assert_eq!(draft(text).acts(), acts, "{text}");
        }
    }

    #[test]
    fn keys_leave_over_https_or_to_this_machine() {
        for url in
            ["https://h.example/", "http://localhost:1/v1", "http://127.9.9.9", "http://[::1]:2/"]
        {
            assert!(may_carry_keys(url), "{url}");
        }
        for url in [
            "http://h.example/",
            "http://192.168.1.7:8000",
            "http://localhost.example",
            "ftp://h",
            "",
        ] {
            assert!(!may_carry_keys(url), "{url}");
        }
        let vlm = "[vlm]\nprovider = 'openai'\nmodel = 'm'\n";
        let check = |rest: &str| draft(&format!("{vlm}{rest}")).config().check_keys();
        check("base = 'http://192.168.1.7/v1'\n").unwrap();
        check("base = 'http://127.0.0.1/v1'\nkey_env = 'K'\n").unwrap();
        let error = check("base = 'http://192.168.1.7/v1'\nkey_env = 'K'\n").unwrap_err();
        assert!(error.to_string().contains("the key in K would leave over plain http"), "{error}");
        check("base = 'http://me:pw@192.168.1.7/v1'\n").unwrap_err();
    }
}
