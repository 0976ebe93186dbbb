//! A shared store in a bucket: S3, Google Cloud Storage or Azure, through `object_store`.

use std::future::Future;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Once};
use std::time::Duration;

use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::path::Path;
use object_store::prefix::PrefixStore;
use object_store::{
    BackoffConfig, Error, ObjectStore, ObjectStoreExt as _, PutMode, PutPayload, RetryConfig,
};
use tokio::runtime::{Builder, Runtime};
use trace::Digest;

use super::address::{Address, Cloud};
use super::depot::{Depot, DepotError, read_result, result_bytes};
use super::journal::Committed;
use super::store::Found;

/// Says what the objects beside it are; the first thing that is written and read.
const MARKER: &str = "kinfold-store.json";
const SCHEMA: &[u8] = b"{\"schema\":\"kinfold-store/1\"}\n";
/// How long a request that meets a passing trouble is repeated.
const PATIENCE: Duration = Duration::from_secs(30);
/// Longest quotation of somebody else's words, characters.
const QUOTED: usize = 400;

/// A shared store in a bucket. `cas/ab/cdef…` holds bytes, `results/ab/cdef…` results, as in a
/// folder; what is written is written under the condition that nothing is there.
pub struct BucketDepot {
    address: String,
    store: Arc<dyn ObjectStore>,
    runtime: Runtime,
}

/// What became of something that was written where nothing may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Put {
    Written,
    Kept,
}

impl BucketDepot {
    /// The bucket of an address, with keys from the environment.
    ///
    /// # Errors
    /// [`DepotError`] when it is not there, may not be written, or replaces what must stay.
    pub fn open(address: &Address) -> Result<Self, DepotError> {
        let place = address.to_string();
        let lossy = |text: std::ffi::OsString| text.to_string_lossy().into_owned();
        let mut settings = std::env::vars_os().map(|(name, value)| (lossy(name), lossy(value)));
        let unreadable = settings.find(|(name, value)| is_bad_endpoint(name, value));
        if let Some((name, _)) = unreadable {
            // Not repeated: a key may stand in it.
            let found = format!("expected an address like http://host:9000 in {name}, found none");
            return Err(DepotError::Bucket { place, doing: "be set up", found });
        }
        let store = built(address).map_err(|e| failed(&place, "be set up", &e))?;
        Self::over(place, store)
    }

    /// The same over any object store, its address in words.
    ///
    /// # Errors
    /// As [`BucketDepot::open`].
    pub fn over(address: String, store: Arc<dyn ObjectStore>) -> Result<Self, DepotError> {
        let mut runtime = Builder::new_multi_thread();
        let runtime = runtime.worker_threads(2).thread_name("bucket").enable_all().build();
        let runtime = runtime.map_err(|e| DepotError::Bucket {
            place: address.clone(),
            doing: "start threads",
            found: e.to_string(),
        })?;
        let this = Self { address, store, runtime };
        this.prove()?;
        Ok(this)
    }

    /// Proves that the bucket is there, is ours to write, and keeps the first of two writes.
    fn prove(&self) -> Result<(), DepotError> {
        let marker = Path::from(MARKER);
        if self.put_if_absent(&marker, SCHEMA)? == Put::Written
            && self.put_if_absent(&marker, SCHEMA)? == Put::Written
        {
            return Err(DepotError::Bucket {
                place: self.address.clone(),
                doing: "share it",
                found: "expected a store that keeps the first of two writes (put-if-absent), found that the second replaced it".into(),
            });
        }
        match self.get(&marker)? {
            Some(bytes) if bytes == SCHEMA => Ok(()),
            found => Err(DepotError::Foreign {
                place: self.place(&marker),
                found: found.map_or("nothing".into(), |b| quoted(&String::from_utf8_lossy(&b))),
            }),
        }
    }

    fn place(&self, path: &Path) -> String {
        format!("{}/{path}", self.address)
    }

    /// Waits for an answer. The client stops on an internal error over settings it cannot use; that
    /// is its error, not the end of the program.
    fn wait<A>(&self, asked: impl Future<Output = Result<A, Error>>) -> Result<A, Error> {
        let answer = catch_unwind(AssertUnwindSafe(|| self.runtime.block_on(asked)));
        answer.unwrap_or_else(|_| {
            let source = "the client stopped on an internal error: are its settings in order?";
            Err(Error::Generic { store: "bucket", source: source.into() })
        })
    }

    fn get(&self, path: &Path) -> Result<Option<Vec<u8>>, DepotError> {
        let read = async { self.store.get(path).await?.bytes().await };
        match self.wait(read) {
            Ok(bytes) => Ok(Some(bytes.to_vec())),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(e) => Err(failed(&self.place(path), "read", &e)),
        }
    }

    fn put_if_absent(&self, path: &Path, bytes: &[u8]) -> Result<Put, DepotError> {
        match self.put(path, bytes, PutMode::Create) {
            Ok(()) => Ok(Put::Written),
            Err(Error::AlreadyExists { .. } | Error::Precondition { .. }) => Ok(Put::Kept),
            Err(e) => Err(failed(&self.place(path), "write", &e)),
        }
    }

    fn put(&self, path: &Path, bytes: &[u8], mode: PutMode) -> Result<(), Error> {
        let payload = PutPayload::from(bytes.to_vec());
        self.wait(self.store.put_opts(path, payload, mode.into())).map(drop)
    }
}

impl Depot for BucketDepot {
    fn blob(&self, digest: &Digest) -> Result<Found, DepotError> {
        Ok(match self.get(&named("cas", digest))? {
            None => Found::Absent,
            Some(bytes) if Digest::of(&bytes) == *digest => Found::Whole(bytes),
            Some(_) => Found::Damaged,
        })
    }

    fn put_blob(&self, digest: &Digest, bytes: &[u8]) -> Result<(), DepotError> {
        let path = named("cas", digest);
        let kept = self.put_if_absent(&path, bytes)? == Put::Kept;
        if !kept || matches!(self.blob(digest)?, Found::Whole(_)) {
            return Ok(());
        }
        let replaced = self.put(&path, bytes, PutMode::Overwrite);
        replaced.map_err(|e| failed(&self.place(&path), "replace damaged bytes", &e))
    }

    fn result(&self, key: &Digest) -> Result<Option<Committed>, DepotError> {
        let path = named("results", key);
        self.get(&path)?.map(|bytes| read_result(&bytes, &self.place(&path))).transpose()
    }

    fn put_result(&self, key: &Digest, result: &Committed) -> Result<Committed, DepotError> {
        match self.put_if_absent(&named("results", key), &result_bytes(result))? {
            Put::Written => Ok(result.clone()),
            Put::Kept => Ok(self.result(key)?.unwrap_or_else(|| result.clone())),
        }
    }
}

/// Whether a variable should hold a server's address, and holds none.
fn is_bad_endpoint(name: &str, value: &str) -> bool {
    let ours = ["AWS_", "AZURE_", "GOOGLE_"].iter().any(|cloud| name.starts_with(cloud));
    let address = reqwest::Url::parse(value);
    let good = address.is_ok_and(|a| ["http", "https"].contains(&a.scheme()) && a.has_host());
    ours && name.contains("ENDPOINT") && !good
}

fn named(folder: &str, digest: &Digest) -> Path {
    let (head, tail) = digest.as_str().split_at(2);
    Path::from_iter([folder, head, tail])
}

/// The client of an address.
fn built(address: &Address) -> Result<Arc<dyn ObjectStore>, Error> {
    static PROVIDER: Once = Once::new();
    // One that is there already is as good.
    PROVIDER.call_once(|| drop(rustls::crypto::ring::default_provider().install_default()));
    let Address::Bucket { cloud, bucket, prefix } = address else {
        return Err(Error::NotImplemented {
            operation: "a folder".into(),
            implementer: "buckets".into(),
        });
    };
    let retry = RetryConfig {
        backoff: BackoffConfig { max_backoff: Duration::from_secs(5), ..BackoffConfig::default() },
        max_retries: 6,
        retry_timeout: PATIENCE,
    };
    let store: Arc<dyn ObjectStore> = match cloud {
        Cloud::S3 => {
            let builder = AmazonS3Builder::from_env().with_bucket_name(bucket).with_retry(retry);
            Arc::new(builder.build()?)
        }
        Cloud::Gcs => {
            let builder = GoogleCloudStorageBuilder::from_env().with_bucket_name(bucket);
            Arc::new(builder.with_retry(retry).build()?)
        }
        Cloud::Azure => {
            let builder = MicrosoftAzureBuilder::from_env().with_container_name(bucket);
            Arc::new(builder.with_retry(retry).build()?)
        }
    };
    Ok(if prefix.is_empty() { store } else { Arc::new(PrefixStore::new(store, prefix.as_str())) })
}

/// The error with the rule it breaks, where that is known.
fn failed(place: &str, doing: &'static str, error: &Error) -> DepotError {
    let rule = match error {
        Error::NotFound { .. } => "expected a bucket that is there, found none: ",
        Error::Unauthenticated { .. } => "expected keys that are known there, found others: ",
        Error::PermissionDenied { .. } => "expected keys that may, found that they may not: ",
        _ => "",
    };
    let mut words = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(cause) = source {
        let cause_words = cause.to_string();
        if !words.contains(&cause_words) {
            words = format!("{words}: {cause_words}");
        }
        source = cause.source();
    }
    DepotError::Bucket { place: place.into(), doing, found: format!("{rule}{}", quoted(&words)) }
}

/// Somebody else's words on one line, cut, and without the queries of addresses: keys may stand
/// there.
fn quoted(words: &str) -> String {
    let plain = |word: &str| match word.split_once('?') {
        Some((address, _)) if address.contains("://") => format!("{address}?…"),
        _ => word.to_owned(),
    };
    let line = words.split_whitespace().map(plain).collect::<Vec<_>>().join(" ");
    line.chars().take(QUOTED).collect()
}

#[cfg(test)]
mod tests {
    use object_store::memory::InMemory;

    use super::super::depot::check_depot;
    use super::*;

    fn depot(store: &Arc<dyn ObjectStore>) -> BucketDepot {
        BucketDepot::over("memory://ours".into(), Arc::clone(store)).unwrap()
    }

    fn memory() -> Arc<dyn ObjectStore> {
        Arc::new(InMemory::new())
    }

    #[test]
    fn a_bucket_keeps_the_promise_of_a_depot() {
        check_depot(&depot(&memory())).unwrap().unwrap();
        let prefixed: Arc<dyn ObjectStore> = Arc::new(PrefixStore::new(memory(), "some/prefix"));
        check_depot(&depot(&prefixed)).unwrap().unwrap();
    }

    #[test]
    fn of_many_that_put_at_once_one_result_stands() {
        let store = memory();
        let key = Digest::of(b"key");
        let put = |n: usize| {
            let own = Committed { output: Digest::of(n.to_string().as_bytes()), notes: vec![] };
            depot(&store).put_result(&key, &own).unwrap().output
        };
        let told: Vec<_> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..8).map(|n| scope.spawn(move || put(n))).collect();
            all.into_iter().map(|t| t.join().unwrap()).collect()
        });
        assert!(told.iter().all(|t| *t == told[0]), "{told:?}");
    }

    #[test]
    fn a_damaged_blob_is_found_and_replaced_and_a_damaged_result_is_an_error() {
        let store = memory();
        let depot = depot(&store);
        let digest = Digest::of(b"a lid");
        depot.put_blob(&digest, b"a lid").unwrap();
        depot.put(&named("cas", &digest), b"a li", PutMode::Overwrite).unwrap();
        assert_eq!(depot.blob(&digest).unwrap(), Found::Damaged);
        depot.put_blob(&digest, b"a lid").unwrap();
        assert_eq!(depot.blob(&digest).unwrap(), Found::Whole(b"a lid".to_vec()));
        depot.put(&named("results", &digest), b"{}", PutMode::Overwrite).unwrap();
        let why = depot.result(&digest).unwrap_err().to_string();
        let place = format!("shared store memory://ours/results/{}", &digest.as_str()[..2]);
        assert!(why.starts_with(&place) && why.contains("expected a result, found"), "{why}");
    }

    #[test]
    fn a_bucket_of_another_version_is_refused() {
        let store = memory();
        let other = PutPayload::from_static(b"{\"schema\":\"kinfold-store/2\"}");
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(store.put(&Path::from(MARKER), other)).unwrap();
        let Err(error) = BucketDepot::over("memory://ours".into(), store) else {
            panic!("it opened")
        };
        assert!(error.to_string().contains("found {\"schema\":\"kinfold-store/2\"}"), "{error}");
    }

    #[test]
    fn an_endpoint_is_an_address() {
        assert!(!is_bad_endpoint("AWS_ENDPOINT", "http://127.0.0.1:9000"));
        assert!(!is_bad_endpoint("PATH", "here") && !is_bad_endpoint("AWS_REGION", "here"));
        for value in ["", "here", "127.0.0.1:9000", "http://127.0.0.1:Starting up", "ftp://a"] {
            assert!(is_bad_endpoint("AWS_ENDPOINT", value), "{value}");
        }
    }

    #[test]
    fn what_others_say_is_cut_and_holds_no_query() {
        let said = quoted("no\n https://box/a?sig=secret&x=1 here");
        assert_eq!(said, "no https://box/a?… here");
        assert_eq!(quoted(&"x".repeat(1000)).chars().count(), QUOTED);
    }
}
