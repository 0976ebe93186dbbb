//! A worker: does single stages for Restate, from the shared store to the shared store.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use restate_sdk::discovery::ServiceName;
use restate_sdk::endpoint::{Builder, ContextInternal, Error};
use restate_sdk::prelude::*;
use restate_sdk::service::macro_support::{ServiceBoxFuture, service_definition};
use restate_sdk::service::{Discoverable as _, Service};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

use super::{HANDLER, service};
use crate::cancel::{Cancel, Wish};
use crate::depot::Depot;
use crate::errand::{Answer, Errand, ErrandError};
use crate::failure::StageError;
use crate::graph::Dag;
use crate::needs::Patience;

/// Stack of a stage's thread, bytes; meshes make deep trees.
const STACK: usize = 32 << 20;
/// How long Restate keeps an answer: the store has the result for good.
const KEPT: Duration = Duration::from_secs(60);
/// How long a call may wait for its place, beyond what its stage may take.
const QUEUE: Duration = Duration::from_secs(3600);
/// How often the wish to stop is looked at.
const GLANCE: Duration = Duration::from_millis(50);
/// How often Restate tries a call that a worker broke off: for some minutes, then it is put off.
const ATTEMPTS: u64 = 30;

/// Where stages are done.
pub struct Bench {
    work: Box<dyn Work>,
    places: Arc<Semaphore>,
}

/// A flow and what its stages work with, its types forgotten.
trait Work: Send + Sync {
    fn computing(&self) -> Vec<(&'static str, Patience)>;
    fn perform(&self, errand: &Errand) -> Result<Answer, ErrandError>;
}

struct Bound<T, F> {
    flow: Dag<T>,
    tools: F,
    depot: Arc<dyn Depot>,
}

impl<T, F: Fn(Option<u64>) -> T + Send + Sync> Work for Bound<T, F> {
    fn computing(&self) -> Vec<(&'static str, Patience)> {
        self.flow.computing()
    }

    fn perform(&self, errand: &Errand) -> Result<Answer, ErrandError> {
        self.flow.perform(errand, &(self.tools)(errand.seed), &*self.depot)
    }
}

impl Bench {
    /// One with so many places, at least one, for the stages of a flow. `tools` gives what a stage
    /// works with, under the seed of its errand.
    pub fn new<T: 'static>(
        flow: Dag<T>,
        tools: impl Fn(Option<u64>) -> T + Send + Sync + 'static,
        depot: Arc<dyn Depot>,
        jobs: usize,
    ) -> Arc<Self> {
        let places = Arc::new(Semaphore::new(jobs.max(1)));
        Arc::new(Self { work: Box::new(Bound { flow, tools, depot }), places })
    }

    /// Does an errand on a thread of its own, which keeps its place as long as it runs: one that is
    /// given up as too slow cannot be stopped, only ignored.
    async fn perform(
        self: Arc<Self>,
        errand: Errand,
        patience: Duration,
        place: OwnedSemaphorePermit,
    ) -> HandlerResult<Json<Answer>> {
        let (tell, told) = oneshot::channel();
        let thread = std::thread::Builder::new().name(errand.stage.clone()).stack_size(STACK);
        thread.spawn(move || {
            let _place = place;
            // Nobody may be listening any more.
            drop(tell.send(self.work.perform(&errand)));
        })?;
        match tokio::time::timeout(patience, told).await {
            Ok(answer) => Ok(Json(answer??)),
            Err(_) => {
                let limit = patience.as_secs_f64();
                let error = StageError::new(format!("took longer than {limit} s and was given up"));
                Ok(Json(Answer::failed(error)))
            }
        }
    }
}

/// The service of one stage.
struct StageService {
    bench: Arc<Bench>,
    patience: Duration,
}

#[restate_sdk::service]
impl StageService {
    /// Does an errand.
    #[handler]
    async fn make(&self, ctx: Context<'_>, errand: Json<Errand>) -> HandlerResult<Json<Answer>> {
        let Json(errand) = errand;
        let place = Arc::clone(&self.bench.places).acquire_owned().await?;
        let (bench, patience) = (Arc::clone(&self.bench), self.patience);
        let name = errand.stage.clone();
        Ok(ctx.run(move || bench.perform(errand, patience, place)).name(name).await?)
    }
}

/// One service under its stage's name: the SDK's macro knows one name per type, and every stage has
/// its own times.
struct Named(Arc<StageService>);

impl Service for Named {
    type Future = ServiceBoxFuture;

    fn handle(&self, ctx: ContextInternal) -> ServiceBoxFuture {
        let service = Arc::clone(&self.0);
        Box::pin(async move {
            if ctx.handler_name() != HANDLER {
                return Err(Error::unknown_handler(ctx.service_name(), ctx.handler_name()));
            }
            let (errand, metadata) = ctx.input().await;
            let answer = service.make((&ctx, metadata).into(), errand).await;
            ctx.handle_handler_result(answer);
            ctx.end();
            Ok(())
        })
    }
}

/// Whether these are public keys of Restate's.
///
/// # Errors
/// What is wrong with the first one that is none.
pub fn known(identity: &[String]) -> Result<(), String> {
    obeying(identity).map(drop)
}

/// An endpoint that obeys whoever signs with one of these keys; anybody, where there are none.
fn obeying(identity: &[String]) -> Result<Builder, String> {
    identity.iter().try_fold(Endpoint::builder(), |endpoint, key| {
        let read = endpoint.identity_key(key);
        read.map_err(|e| format!("expected a public key of Restate, publickeyv1_…: {e}"))
    })
}

/// The services of all stages that compute.
fn endpoint(bench: &Arc<Bench>, identity: &[String]) -> io::Result<Endpoint> {
    let mut endpoint = obeying(identity).map_err(io::Error::other)?;
    for (stage, patience) in bench.work.computing() {
        let patience = patience.timeout;
        let options = ServiceOptions::new()
            .inactivity_timeout(patience + QUEUE)
            .abort_timeout(patience + QUEUE)
            .idempotency_retention(KEPT)
            .journal_retention(KEPT)
            .retry_policy_initial_interval(Duration::from_millis(100))
            .retry_policy_exponentiation_factor(2.0)
            .retry_policy_max_interval(Duration::from_secs(10))
            .retry_policy_max_attempts(ATTEMPTS)
            .retry_policy_kill_on_max_attempts();
        let mut discovery = StageService::discover();
        discovery.name = ServiceName::try_from(service(stage)).map_err(io::Error::other)?;
        let one = Named(Arc::new(StageService { bench: Arc::clone(bench), patience }));
        endpoint = endpoint.bind(service_definition(one, discovery).options(options));
    }
    Ok(endpoint.build())
}

/// Serves Restate on a socket until somebody wants it to stop. With keys, only requests that one of
/// them signed are obeyed.
///
/// # Errors
/// When the operating system refuses threads or the socket, or a key is none.
pub fn serve(
    bench: &Arc<Bench>,
    listener: TcpListener,
    identity: &[String],
    cancel: &Cancel,
) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let stopped = async {
            while cancel.wish() == Wish::Go {
                tokio::time::sleep(GLANCE).await;
            }
        };
        HttpServer::new(endpoint(bench, identity)?).serve_with_cancel(listener, stopped).await;
        Ok(())
    });
    runtime.shutdown_background();
    served
}
