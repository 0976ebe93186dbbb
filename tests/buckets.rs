//! Stages that lie in a bucket: a local S3 that is not ours, real programs on both ends.
#![cfg(all(unix, feature = "remote"))]

use std::io::BufRead as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use runner::depot::check_depot;
use runner::{Address, Found};
use serde_json::Value;

use crate::batch::{Batch, number, same};
use crate::cases;
use crate::kinfold::Said;

/// Key and secret of a server that takes any.
const KEY: &str = "some-key-of-ours";
const SECRET: &str = "some-secret-of-ours";

/// A local S3 with one bucket, ended when it is let go.
pub struct S3 {
    child: Child,
    port: u16,
}

impl S3 {
    /// Starts one with a bucket `ours`; none without Python and moto.
    pub fn start() -> Option<Self> {
        let python = cases::python_with("moto.server, boto3")?;
        let script = "import sys, boto3\n\
            from moto.server import ThreadedMotoServer\n\
            server = ThreadedMotoServer(ip_address='127.0.0.1', port=0)\n\
            server.start()\n\
            host, port = server.get_host_and_port()\n\
            boto3.client('s3', endpoint_url=f'http://127.0.0.1:{port}', region_name='us-east-1',\n\
                aws_access_key_id='k', aws_secret_access_key='s').create_bucket(Bucket='ours')\n\
            print(port, flush=True)\n\
            sys.stdin.read()\n";
        let mut command = Command::new(python);
        command.args(["-c", script]).stdin(Stdio::piped());
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
        let port = lines.map_while(Result::ok).find_map(|line| line.trim().parse().ok());
        Some(Self { child, port: port.expect("the server says where it listens") })
    }

    /// What a program needs to know to use it.
    pub fn environment(&self) -> Vec<(&'static str, String)> {
        environment(self.port)
    }
}

impl Drop for S3 {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn environment(port: u16) -> Vec<(&'static str, String)> {
    vec![
        ("AWS_ACCESS_KEY_ID", KEY.into()),
        ("AWS_SECRET_ACCESS_KEY", SECRET.into()),
        ("AWS_REGION", "us-east-1".into()),
        ("AWS_ENDPOINT", format!("http://127.0.0.1:{port}")),
        ("AWS_ALLOW_HTTP", "true".into()),
    ]
}

fn ran(batch: &Batch, environment: &[(&str, String)], store: &str) -> (Said, Value) {
    let mut command = batch.batch(&["--json", "--store", store]);
    let said: Said = command.envs(environment.iter().cloned()).output().unwrap().into();
    let answer = serde_json::from_str(&said.out).unwrap_or_default();
    (said, answer)
}

/// Does something to the bucket behind its users' backs: lines of Python that know `s3`.
fn by_hand(endpoint: &str, lines: &str) {
    let python = cases::python_with("boto3").unwrap();
    let mut hand = Command::new(python);
    hand.args(["-c", &format!("import boto3\ns3 = boto3.client('s3')\n{lines}")]);
    hand.env("AWS_ACCESS_KEY_ID", KEY).env("AWS_SECRET_ACCESS_KEY", SECRET);
    hand.env("AWS_ENDPOINT_URL", endpoint).env("AWS_DEFAULT_REGION", "us-east-1");
    let said: Said = hand.output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
}

#[test]
fn machines_that_share_a_bucket_make_each_stage_once() {
    let Some(s3) = S3::start() else { return };
    let (one, other, alone) = (Batch::of(2), Batch::of(2), Batch::of(2));
    let (said, first) = ran(&one, &s3.environment(), "s3://ours/stages");
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(number(&first["this_run"], "stages_run") > 0);
    let (said, second) = ran(&other, &s3.environment(), "s3://ours/stages/");
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(number(&second["this_run"], "stages_run"), 0, "{second}");
    assert_eq!(alone.ran(&[]).0.code, Some(0));
    same(&one.assets(), &other.assets());
    same(&one.assets(), &alone.assets());
}

/// Tries the promise of a depot in a process of its own, since the address is in the environment.
#[test]
fn a_bucket_keeps_the_promise_and_gives_damage_away() {
    if std::env::var_os("AWS_ENDPOINT").is_none() {
        let Some(s3) = S3::start() else { return };
        let mut again = Command::new(std::env::current_exe().unwrap());
        again.args(["--exact", "buckets::a_bucket_keeps_the_promise_and_gives_damage_away"]);
        let said: Said = again.envs(s3.environment()).output().unwrap().into();
        assert_eq!(said.code, Some(0), "{}\n{}", said.out, said.err);
        return;
    }
    let address: Address = "s3://ours/promise".parse().unwrap();
    let depot = address.open("test").unwrap();
    check_depot(&*depot).unwrap().unwrap();
    // Somebody's hand in the bucket: the same digest, other bytes.
    let digest = trace::Digest::of(b"a lid");
    let (head, tail) = digest.as_str().split_at(2);
    let key = format!("promise/cas/{head}/{tail}");
    let put = format!("s3.put_object(Bucket='ours', Key='{key}', Body=b'a li')\n");
    by_hand(&std::env::var("AWS_ENDPOINT").unwrap(), &put);
    assert_eq!(depot.blob(&digest).unwrap(), Found::Damaged);
    depot.put_blob(&digest, b"a lid").unwrap();
    assert_eq!(depot.blob(&digest).unwrap(), Found::Whole(b"a lid".to_vec()));
}

#[test]
fn a_blob_that_rotted_in_the_bucket_is_made_again() {
    let Some(s3) = S3::start() else { return };
    let (one, other) = (Batch::of(1), Batch::of(1));
    assert_eq!(ran(&one, &s3.environment(), "s3://ours/stages").0.code, Some(0));
    let rot = "all = s3.list_objects_v2(Bucket='ours', Prefix='stages/cas/')['Contents']\n\
        for one in all: s3.put_object(Bucket='ours', Key=one['Key'], Body=b'rotten')\n";
    by_hand(&s3.environment()[3].1, rot);
    let (said, answer) = ran(&other, &s3.environment(), "s3://ours/stages");
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(number(&answer["this_run"], "stages_recalled"), 0, "{answer}");
    same(&one.assets(), &other.assets());
    let (said, answer) = ran(&Batch::of(1), &s3.environment(), "s3://ours/stages");
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(number(&answer["this_run"], "stages_run"), 0, "it is whole again: {answer}");
}

#[test]
fn a_bucket_that_cannot_be_used_is_told_by_address_and_rule_before_any_work() {
    let Some(s3) = S3::start() else { return };
    let batch = Batch::of(1);
    let told = |environment: &[(&str, String)], store: &str, code: i32, words: &[&str]| {
        let (said, _) = ran(&batch, environment, store);
        assert_eq!(said.code, Some(code), "{said:?}");
        for word in words {
            assert!(said.err.contains(word), "expected {word} in {}", said.err);
        }
        assert!(!said.err.contains(SECRET) && !said.err.contains("panicked"), "{}", said.err);
        assert!(!Path::exists(&batch.path("out")), "nothing was begun");
    };
    let there = s3.environment();
    told(&there, "s3://nobodys/stages", 1, &["s3://nobodys/stages", "expected a bucket that is"]);
    told(&there, "ftp://ours", 2, &["expected a folder, file:///FOLDER, s3://BUCKET/PREFIX"]);
    let began = Instant::now();
    let nowhere = environment(1);
    told(&nowhere, "s3://ours/stages", 1, &["s3://ours/stages", "hint: bucket and keys come from"]);
    assert!(began.elapsed() < Duration::from_secs(60), "{:?}", began.elapsed());
}

/// A server that answers everything with one status.
fn refusing(status: u16) -> crate::server::Server {
    crate::server::Server::start(move |_| crate::server::Answer {
        status,
        headers: vec![],
        body: b"<Error><Code>AccessDenied</Code></Error>".to_vec(),
    })
}

#[test]
fn keys_that_may_not_are_told_apart_from_keys_that_are_unknown() {
    for (status, rule) in [(403, "expected keys that may"), (401, "expected keys that are known")] {
        let server = refusing(status);
        let (said, _) = ran(&Batch::of(1), &environment(server.port), "s3://ours/stages");
        assert_eq!(said.code, Some(1), "{said:?}");
        assert!(said.err.contains(rule), "expected {rule} in {}", said.err);
    }
}
