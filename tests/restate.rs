//! A batch on Restate: a server that is not ours, workers in processes of their own, and whatever is
//! killed meanwhile.
#![cfg(all(unix, feature = "restate"))]

mod identity;

use std::io::BufRead as _;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::batch::{Batch, number, same};
use crate::kinfold::{Said, files, program};

/// The server's program: `KINFOLD_RESTATE`, or where `.ci/run` puts its npm package; said loudly
/// where it is not.
fn server_program() -> Option<PathBuf> {
    let packages = concat!(env!("CARGO_MANIFEST_DIR"), "/../.venv/node_modules/@restatedev");
    let default = || {
        let names = std::fs::read_dir(packages).ok()?.filter_map(|e| Some(e.ok()?.path()));
        names.map(|folder| folder.join("bin/restate-server")).find(|program| program.is_file())
    };
    let named = std::env::var_os("KINFOLD_RESTATE").map(PathBuf::from);
    let program = named.filter(|p| p.is_file()).or_else(default);
    if program.is_none() {
        eprintln!("SKIPPED: no restate-server in {packages} (set KINFOLD_RESTATE)");
    }
    program
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// A process that ends when it is let go.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn signal(name: &str, pid: u32) {
    let sent = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).status();
    assert!(sent.unwrap().success());
}

/// A Restate server on ports of its own, all on the loopback.
struct Server {
    program: PathBuf,
    base: tempfile::TempDir,
    ports: [u16; 3],
    /// What it signs its requests with, if it does.
    key: Option<PathBuf>,
    running: Option<Running>,
}

impl Server {
    fn start() -> Option<Self> {
        Self::signing(None)
    }

    fn signing(key: Option<PathBuf>) -> Option<Self> {
        let (program, base) = (server_program()?, tempfile::tempdir().unwrap());
        let ports = [free_port(), free_port(), free_port()];
        let mut this = Self { program, base, ports, key, running: None };
        this.run();
        Some(this)
    }

    fn run(&mut self) {
        let [ingress, admin, node] = self.ports.map(|port| format!("127.0.0.1:{port}"));
        let mut command = Command::new(&self.program);
        command.args(["--no-logo", "--node-name", "one", "--bind-address", &node]);
        command.args(["--advertised-address", &format!("http://{node}"), "--base-dir"]);
        command.arg(self.base.path()).env("RESTATE_DISABLE_TELEMETRY", "true");
        command.env("RESTATE_INGRESS__BIND_ADDRESS", &ingress);
        command
            .env("RESTATE_ADMIN__BIND_ADDRESS", &admin)
            .env("RESTATE_DEFAULT_NUM_PARTITIONS", "4");
        let key = self.key.as_ref();
        command.envs(key.map(|key| ("RESTATE_REQUEST_IDENTITY_PRIVATE_KEY_PEM_FILE", key)));
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        self.running = Some(Running(child));
        let began = Instant::now();
        while !answers(&format!("http://{admin}/health"))
            || !answers(&format!("http://{ingress}/restate/health"))
        {
            assert!(began.elapsed() < Duration::from_secs(60), "the server does not start");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn kill(&mut self) {
        self.running = None;
    }

    /// What a batch is told about it.
    fn arguments(&self, store: &Path, workers: &str) -> Vec<String> {
        let [ingress, admin, _] = self.ports.map(|port| format!("http://127.0.0.1:{port}"));
        let store = store.display().to_string();
        let mut all = vec!["--engine", "restate", "--store", &store];
        all.extend(["--ingress", &ingress, "--admin", &admin]);
        if !workers.is_empty() {
            all.extend(["--workers", workers]);
        }
        all.into_iter().map(String::from).collect()
    }
}

fn answers(url: &str) -> bool {
    use adapters::transport::{Method, Request, Transport as _};
    let request =
        Request::new("test.health", Method::Get, url).within(Duration::from_secs(2), 4096);
    adapters::net::http::Http::default().send(&request).is_ok_and(|r| r.status == 200)
}

/// A worker and where it listens.
fn worker(store: &Path) -> (Running, String) {
    obeying(store, &[])
}

/// One that obeys whoever signs with one of these keys.
fn obeying(store: &Path, keys: &[&str]) -> (Running, String) {
    let mut command = program();
    command.args(["worker", "--engine", "restate", "--listen", "127.0.0.1:0", "--jobs", "2"]);
    command.arg("--store").arg(store).stderr(Stdio::piped());
    for key in keys {
        command.args(["--identity-key", key]);
    }
    let mut child = command.spawn().unwrap();
    let mut line = String::new();
    std::io::BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
    let address = line.trim().strip_prefix("listening on ").and_then(|l| l.split(',').next());
    (Running(child), address.unwrap_or_else(|| panic!("{line}")).to_owned())
}

fn words(arguments: &[String]) -> Vec<&str> {
    arguments.iter().map(String::as_str).collect()
}

#[test]
fn a_batch_on_restate_gives_the_bytes_of_one_in_a_process() {
    let Some(server) = Server::start() else { return };
    let (there, here) = (Batch::of(3), Batch::of(3));
    let store = there.path("shared");
    let refused = there.batch(&words(&server.arguments(&store, ""))).output().unwrap();
    let refused = Said::from(refused);
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.err.contains("found no service kinfold."), "{}", refused.err);
    assert!(refused.err.contains("hint: start `kinfold worker`"), "{}", refused.err);

    let (_worker, address) = worker(&store);
    let arguments = server.arguments(&store, &format!("http://{address}"));
    let (said, answer) = there.ran(&words(&arguments));
    assert_eq!(said.code, Some(0), "{said:?}");
    let (said, embedded) = here.ran(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    same(&here.assets(), &there.assets());
    for name in ["accepted", "planned", "calls"] {
        assert_eq!(number(&answer, name), number(&embedded, name), "{name}");
    }
    assert_eq!(answer["this_run"]["stages_run"], embedded["this_run"]["stages_run"]);
    assert_eq!(there.say(&["audit", "out"]).code, Some(0));
    assert!(there.path("out/index.parquet").is_file());
    assert!(there.say(&["batch", "report", "out"]).code == Some(0));
    let seconds = there.ask("SELECT min(seconds_articulate) FROM items").parse::<f64>().unwrap();
    assert!(seconds > 0.0, "the worker says how long a stage took");

    // Another batch finds everything in the store, and asks nobody.
    let other = Batch::of(3);
    let (_, again) = other.ran(&words(&server.arguments(&store, "")));
    assert_eq!(number(&again["this_run"], "stages_run"), 0, "{again}");
    same(&here.assets(), &other.assets());
}

/// What stands before two workers: streams of HTTP/2 to whoever is well, none to whoever is not.
fn balancer(folder: &Path, workers: &[&str]) -> Option<(Running, String)> {
    let address = format!("127.0.0.1:{}", free_port());
    let server = |(n, worker): (usize, &&str)| {
        format!(
            "  server w{n} {worker} proto h2 check check-proto h2 inter 300ms fall 2 rise 1 on-marked-down shutdown-sessions\n"
        )
    };
    let servers: String = workers.iter().enumerate().map(server).collect();
    let text = format!(
        "defaults\n  mode http\n  timeout connect 2s\n  timeout client 1h\n  timeout server 1h\n  timeout check 1s\n  option redispatch\n\
         frontend restate\n  bind {address} proto h2\n  default_backend workers\n\
         backend workers\n  balance leastconn\n  option httpchk GET /health\n{servers}"
    );
    let file = folder.join("haproxy.cfg");
    std::fs::write(&file, text).unwrap();
    let mut command = Command::new("haproxy");
    command.arg("-f").arg(&file).stdout(Stdio::null()).stderr(Stdio::null());
    match command.spawn() {
        Ok(child) => Some((Running(child), address)),
        Err(_) => {
            eprintln!("SKIPPED: no haproxy to stand before the workers");
            None
        }
    }
}

/// Waits until so many assets are there; the longest time without a new one.
fn until(batch: &Batch, child: &mut Child, assets: usize) -> Duration {
    let there = || std::fs::read_dir(batch.path("out/assets")).map_or(0, Iterator::count);
    let (mut before, mut since, mut longest) = (there(), Instant::now(), Duration::ZERO);
    while before < assets && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(20));
        let now = there();
        longest = longest.max(since.elapsed());
        if now != before {
            (before, since) = (now, Instant::now());
        }
    }
    longest
}

#[test]
#[ignore = "minutes: two hundred items, two workers and a server that are killed"]
fn long_workers_and_server_are_killed_and_nothing_is_lost() {
    let Some(mut server) = Server::start() else { return };
    let items = std::env::var("KINFOLD_ITEMS").ok().and_then(|v| v.parse().ok()).unwrap_or(200);
    let (batch, here) = (Batch::of(items), Batch::of(items));
    let began = Instant::now();
    assert_eq!(here.ran(&[]).0.code, Some(0));
    eprintln!("{items} items in one process in {:.1?}", began.elapsed());

    let store = batch.path("shared");
    let ((one, at_one), (other, at_other)) = (worker(&store), worker(&store));
    let Some((_balancer, address)) = balancer(&batch.path(""), &[&at_one, &at_other]) else {
        return;
    };
    std::thread::sleep(Duration::from_secs(1));
    let arguments = server.arguments(&store, &format!("http://{address}"));
    let began = Instant::now();
    let mut child = batch.batch(&words(&arguments)).spawn().unwrap();
    let share = |percent: usize| items * percent / 100;
    let pause = until(&batch, &mut child, share(15));
    eprintln!("longest pause undisturbed {pause:.1?}");
    signal("STOP", other.0.id());
    let pause = until(&batch, &mut child, share(35));
    eprintln!("longest pause with a worker stopped {pause:.1?}");
    signal("CONT", other.0.id());
    let pause = until(&batch, &mut child, share(50));
    eprintln!("longest pause with it awake again {pause:.1?}");
    drop(one);
    let pause = until(&batch, &mut child, share(65));
    eprintln!("longest pause with a worker killed {pause:.1?}");
    server.kill();
    std::thread::sleep(Duration::from_secs(1));
    server.run();
    let pause = until(&batch, &mut child, items);
    eprintln!("longest pause with the server killed and started again {pause:.1?}");
    let said: Said = child.wait_with_output().unwrap().into();
    eprintln!("{items} items with all that in {:.1?}", began.elapsed());
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(said.out, format!("accepted   {items}\n"));
    same(&here.assets(), &batch.assets());
    assert_eq!(batch.repeated(), 0, "a committed result was committed again");
    assert_eq!(batch.say(&["audit", "out"]).code, Some(0));
    let results = |folder: &Path| files(&folder.join("results")).len();
    assert!(results(&store) > 0);
}
