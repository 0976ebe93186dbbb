//! Configurations as people write them, and what becomes of them.

use super::*;
use crate::budget::MemoryBook;
use crate::generators::MemoryLedger;
use crate::net::calls::Unkept;
use crate::net::pace::ImaginedPace;
use crate::transport::Deny;

fn world() -> World {
    let variable = |name: &str| (name == "SOME_KEY").then(|| "canary".to_owned());
    let (transport, pace) = (Arc::new(Deny), Arc::new(ImaginedPace::default()));
    let ledger = Arc::new(MemoryLedger::default());
    let (calls, book, gates) = (Arc::new(Unkept), Arc::new(MemoryBook::default()), Arc::default());
    let (clock, scratch) = (Arc::new(trace::FixedClock(0)), "scratch".into());
    let on_record = Arc::new(Deny);
    World {
        transport,
        on_record,
        calls,
        pace,
        clock,
        ledger,
        book,
        gates,
        scratch,
        keeper: None,
        onlooker: None,
        variable,
    }
}

fn open(text: &str) -> Result<Config, AdapterError> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), text).unwrap();
    Config::open(file.path())
}

fn identities(text: &str) -> Result<[Option<String>; 2], AdapterError> {
    let config = open(text)?;
    let mesh = config.image_to_3d(&world())?.map(|a| a.identity()).transpose()?;
    Ok([mesh, config.vlm(&world())?.map(|a| a.identity()).transpose()?])
}

#[test]
fn providers_are_built_as_they_are_written() {
    let [mesh, vlm] = identities(
        "[image_to_3d]\nprovider = 'command'\nprogram = 'gen'\narguments = ['{image}']\n\
         [vlm]\nprovider = 'openai'\nbase = 'http://localhost:8000/v1'\nmodel = 'Qwen3-VL'\n",
    )
    .unwrap();
    assert_eq!(mesh.unwrap(), "command/1 gen {image}");
    let vlm = vlm.unwrap();
    assert!(vlm.starts_with("openai-chat/1 Qwen3-VL at localhost:8000"), "{vlm}");
    assert!(vlm.ends_with("Xy1000"), "{vlm}");
    let meshy = "[image_to_3d]\nprovider = 'meshy'\nmodel = 'meshy-6'\nkey_env = 'SOME_KEY'\n";
    assert!(identities(meshy).unwrap()[0].as_ref().unwrap().contains("meshy-6"));
    assert_eq!(identities("").unwrap(), [None, None]);
}

#[test]
fn every_provider_is_read_from_its_section() {
    let sections = [
        ("gradio", "base = 'http://127.0.0.1:7860'\napp = 'trellis'"),
        ("gradio", "base = 'http://h'\ncalls = [{ function = 'run', data = ['{image}', 1] }]"),
        ("fal", "model = 'fal-ai/trellis-2'\nkey_env = 'SOME_KEY'\ninput = { steps = 7 }"),
        ("tripo", "model = 'v3.1-20260211'\nkey_env = 'SOME_KEY'"),
        ("stability", "model = 'stable-fast-3d'\nkey_env = 'SOME_KEY'"),
        ("comfyui", "base = 'http://h'\nworkflow = { '1' = { inputs = {} } }\nimage_node = '1'"),
        ("tencent", "model = '3.1'\nid_env = 'SOME_KEY'\nkey_env = 'SOME_KEY'\nregion = 'r'"),
        ("replicate", "model = 'o/n'\nkey_env = 'SOME_KEY'\nimage_key = 'image'"),
    ];
    for (provider, rest) in sections {
        let text = format!("[image_to_3d]\nprovider = '{provider}'\n{rest}\n");
        let [mesh, _] = identities(&text).unwrap();
        assert!(mesh.unwrap().starts_with(provider), "{provider}");
    }
    let nothing = "[image_to_3d]\nprovider = 'gradio'\nbase = 'http://h'\n";
    assert!(identities(nothing).unwrap_err().to_string().contains("`app` or `calls`"));
}

#[test]
fn a_policy_is_kept_before_anything_is_asked() {
    let hunyuan = "[image_to_3d]\nprovider = 'hunyuan'\nbase = 'http://h'\n";
    let policy: Policy = "commercial-eu".parse().unwrap();
    let error = open(hunyuan).unwrap().permit(&policy).unwrap_err();
    assert!(error.to_string().contains("hunyuan") && error.to_string().contains("forbids `eu`"));
    let declared = format!("{hunyuan}[manners.image_to_3d]\nallowed = ['eu']\n");
    open(&declared).unwrap().permit(&policy).unwrap();
    open(hunyuan).unwrap().permit(&Policy::default()).unwrap();
}

#[test]
fn a_key_that_is_not_set_is_named() {
    let tencent = "[image_to_3d]\nprovider = 'tencent'\nmodel = '3.1'\n";
    let error = identities(&format!("{tencent}key_env = 'SOME_KEY'\n")).unwrap_err();
    assert_eq!(error.to_string(), "no key: the variable TENCENTCLOUD_SECRET_ID is not set");
    let error = identities(&format!("{tencent}id_env = 'SOME_KEY'\n")).unwrap_err();
    assert_eq!(error.to_string(), "no key: the variable TENCENTCLOUD_SECRET_KEY is not set");
    let error = identities("[vlm]\nprovider = 'gemini'\nmodel = 'g'\n").unwrap_err();
    assert_eq!(error.to_string(), "no key: the variable GEMINI_API_KEY is not set");
    assert!(error.hint().is_some());
}

#[test]
fn an_unknown_word_is_told_with_its_place() {
    let error = open("[vlm]\nprovider = 'openai'\nmodle = 'x'\n").unwrap_err().to_string();
    assert!(error.contains("modle") && error.contains("line 3"), "{error}");
    open("[image_to_3d]\nprovider = 'nobody'\n").unwrap_err();
}

#[test]
fn a_critic_is_there_only_where_it_is_switched_on() {
    let vlm = "[vlm]\nprovider = 'openai'\nbase = 'http://localhost:8000/v1'\nmodel = 'some-vlm'\n";
    let [off, on] = [open(vlm).unwrap(), open(&format!("{vlm}critic = true\n")).unwrap()];
    assert!(off.critic(&world()).unwrap().is_none());
    let critic = on.critic(&world()).unwrap().unwrap().identity().unwrap();
    assert!(critic.starts_with("openai-chat/1 some-vlm at localhost:8000 prompts "), "{critic}");
    let identity = |config: &Config| config.vlm(&world()).unwrap().unwrap().identity().unwrap();
    assert_eq!(identity(&off), identity(&on), "who says what the parts are stays the same");
    let kept = |config: &Config| serde_json::to_string(&config.redacted()).unwrap();
    assert_eq!(kept(&off), kept(&open(&format!("{vlm}critic = false\n")).unwrap()));
    assert!(!kept(&off).contains("critic") && kept(&on).contains("\"critic\":true"));
    assert!(on.without(false, true).critic(&world()).unwrap().is_none(), "a condition was given");
}
