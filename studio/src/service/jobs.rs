//! Jobs: asked for, listed, looked at.

use std::sync::Arc;

use axum::extract::{Path, RawQuery, Request, State};
use axum::http::StatusCode;
use axum::{Extension, Json};
use schemars::JsonSchema;
use serde::Serialize;

use super::body;
use super::gate::Who;
use super::room::{Desk, LISTED};
use crate::http::answers::Refusal;
use crate::http::room::apart;
use crate::works::{About, Job, JobOrder, Refused, Submitted};

/// Jobs that are listed at once, unless fewer are asked for.
const AT_ONCE: usize = 100;

/// Some jobs, the newest first.
#[derive(Serialize, JsonSchema)]
pub(crate) struct JobsAnswer {
    /// The jobs.
    jobs: Vec<Job>,
}

pub(super) async fn about(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
) -> Result<Json<About>, Refusal> {
    Ok(Json(apart(move || desk.works.about(&who)).await??))
}

pub(super) async fn submit(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
    request: Request,
) -> Result<(StatusCode, Json<Job>), Refusal> {
    let order: JobOrder = body::json(request, desk.limits.patience).await?;
    let Submitted { job, is_new } = apart(move || desk.works.submit(&who, order)).await??;
    let status = if is_new { StatusCode::ACCEPTED } else { StatusCode::OK };
    Ok((status, Json(job)))
}

impl From<Refused> for Refusal {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Order(failure) | Refused::House(failure) => failure.into(),
            Refused::Condition(error) => {
                Self::from(error).hint("`kinfold schema condition` prints the format")
            }
            Refused::Full(failure) => {
                let refusal = Self::new(StatusCode::TOO_MANY_REQUESTS, failure.message);
                failure.hint.into_iter().fold(refusal, Self::hint)
            }
        }
    }
}

/// A job of this one's, or why there is none.
pub(super) async fn found(desk: &Desk, who: String, id: String) -> Result<Job, Refusal> {
    let works = Arc::clone(&desk.works);
    let job = apart(move || works.job(&who, &id)).await??;
    job.ok_or_else(|| {
        Refusal::new(StatusCode::NOT_FOUND, "this token has no such job")
            .hint("`/v1/jobs` lists its jobs")
    })
}

pub(super) async fn one(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
    Path(id): Path<String>,
) -> Result<Json<Job>, Refusal> {
    found(&desk, who, id).await.map(Json)
}

pub(super) async fn list(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
    RawQuery(query): RawQuery,
) -> Result<Json<JobsAnswer>, Refusal> {
    let (mut before, mut most) = (None, AT_ONCE);
    for pair in query.as_deref().unwrap_or_default().split('&').filter(|pair| !pair.is_empty()) {
        match pair.split_once('=').unwrap_or((pair, "")) {
            ("before", id) => before = Some(id.to_owned()),
            ("most", number) if number.parse().is_ok_and(|n: usize| (1..=AT_ONCE).contains(&n)) => {
                most = number.parse().unwrap_or(AT_ONCE);
            }
            _ => {
                let found =
                    format!("expected `before=ID` and `most=` 1 to {AT_ONCE}, found `{pair}`");
                return Err(Refusal::new(StatusCode::BAD_REQUEST, found).hint(LISTED));
            }
        }
    }
    let jobs = apart(move || desk.works.jobs(&who, before.as_deref(), most)).await??;
    Ok(Json(JobsAnswer { jobs }))
}
