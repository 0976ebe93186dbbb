//! Files that come in, and files that go out, by their digests.

use axum::body::Bytes;
use axum::extract::{Path, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};

use super::body::Pieces;
use super::gate::Who;
use super::room::Desk;
use crate::http::answers::Refusal;
use crate::http::room::apart;
use crate::works::{Incoming, Kept};

/// Bytes that are written at once.
const PIECE: usize = 1 << 20;

pub(super) async fn upload(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
    request: Request,
) -> Result<(StatusCode, Json<Kept>), Refusal> {
    let mut pieces = Pieces::of(request, desk.limits.most_bytes, desk.limits.patience)?;
    let works = std::sync::Arc::clone(&desk.works);
    let mut file = apart(move || works.receive(&who)).await??;
    let mut some: Vec<Bytes> = Vec::new();
    while let Some(piece) = pieces.next().await? {
        some.push(piece);
        if some.iter().map(Bytes::len).sum::<usize>() >= PIECE {
            file = written(file, std::mem::take(&mut some)).await?;
        }
    }
    let file = written(file, some).await?;
    let kept = apart(move || file.keep()).await??;
    Ok((StatusCode::CREATED, Json(kept)))
}

async fn written(
    mut file: Box<dyn Incoming>,
    pieces: Vec<Bytes>,
) -> Result<Box<dyn Incoming>, Refusal> {
    let done = apart(move || pieces.iter().try_for_each(|piece| file.write(piece)).map(|()| file));
    done.await?.map_err(|e| {
        Refusal::new(StatusCode::INSUFFICIENT_STORAGE, format!("the file cannot be kept: {e}"))
            .hint("the service needs room on its disk; send it again later")
    })
}

pub(super) async fn artefact(
    State(desk): State<Desk>,
    Extension(Who(who)): Extension<Who>,
    Path((id, digest)): Path<(String, String)>,
) -> Result<Response, Refusal> {
    let asked = digest.clone();
    let bytes = apart(move || desk.works.artefact(&who, &id, &asked)).await??;
    let Some(bytes) = bytes else {
        let found = "there is no such job of this token, or it left no file of that digest";
        return Err(
            Refusal::new(StatusCode::NOT_FOUND, found).hint("`/v1/jobs/{id}` lists its files")
        );
    };
    // Nothing of an asset is run by a browser, whatever it says it is; a digest is of the same bytes for ever.
    let head = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_DISPOSITION, "attachment".to_owned()),
        (header::ETAG, format!("\"{digest}\"")),
    ];
    Ok((head, bytes).into_response())
}
