//! The routes, behind the guard.

use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, Query, Request, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE, HeaderName, LOCATION, SET_COOKIE};
use axum::http::{HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use isolux_app::formats::dropped::dropped;
use serde::Deserialize;

use crate::assets::asset;
use crate::command::Command;
use crate::guard::Refusal;
use crate::shared::Shared;
use crate::stream::From;
use crate::{stream, study};

/// Section 3.3 of the policy: nothing but what this server itself gives.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
    font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// The report is one file with its style and its viewer in it, whose library it unpacks. It may run in a frame of its own alone.
const REPORT_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' blob:; style-src 'unsafe-inline'; \
    img-src data:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; sandbox allow-scripts";

/// A dropped file may be so large, as text of base64.
const LARGEST_DROP: usize = 48 << 20;

/// The routes.
pub fn router(shared: Arc<Shared>) -> Router {
    let api = Router::new()
        .route("/api/stream", get(stream::stream))
        .route("/api/events", get(events))
        .route("/api/sensor", get(sensor))
        .route("/api/in-motion", get(in_motion))
        .route("/api/command", post(command))
        .route("/api/study", post(study::study))
        .route("/api/inspect", post(inspect).layer(DefaultBodyLimit::max(LARGEST_DROP)))
        .route("/results/{name}", get(result))
        .route("/report", get(report))
        .route_layer(from_fn_with_state(shared.clone(), inside));
    Router::new()
        .merge(api)
        .fallback(get(shell))
        .layer(from_fn_with_state(shared.clone(), outside))
        .with_state(shared)
}

/// Checks 2 to 4, and the headers of every answer.
async fn outside(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let passed = shared.guard.outside(request.method(), request.headers());
    let mut response = match passed {
        Ok(()) => next.run(request).await,
        Err(refusal) => refused(&refusal),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
        ("cross-origin-opener-policy", "same-origin"),
        ("cross-origin-resource-policy", "same-origin"),
        ("x-frame-options", "DENY"),
    ] {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    let policy = HeaderName::from_static("content-security-policy");
    headers.entry(policy).or_insert(HeaderValue::from_static(POLICY));
    headers
        .entry(CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-store"));
    response
}

/// Check 5.
async fn inside(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    match shared.guard.inside(request.headers()) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refused(&refusal),
    }
}

fn refused(refusal: &Refusal) -> Response {
    (refusal.status, format!("{}\n", refusal.sentence)).into_response()
}

#[derive(Deserialize)]
struct Launch {
    code: Option<String>,
}

/// The files of the page, which say nothing of the bench; `/?code=` exchanges the code for the cookie.
async fn shell(State(shared): State<Arc<Shared>>, Query(launch): Query<Launch>, request: Request) -> Response {
    let path = request.uri().path().trim_start_matches('/');
    if path.is_empty()
        && let Some(code) = launch.code
    {
        return match shared.guard.exchange(&code) {
            Ok(cookie) => {
                (shared.say)(&shared.guard.launch_url());
                (
                    StatusCode::SEE_OTHER,
                    [(LOCATION, "/".to_owned()), (SET_COOKIE, cookie)],
                )
                    .into_response()
            }
            // A browser that has its cookie already may come by the same address again.
            Err(_) if shared.guard.inside(request.headers()).is_ok() => {
                (StatusCode::SEE_OTHER, [(LOCATION, "/")]).into_response()
            }
            Err(refusal) => launch_page(refusal.status),
        };
    }
    if path.is_empty() && shared.guard.inside(request.headers()).is_err() {
        return launch_page(StatusCode::UNAUTHORIZED);
    }
    match asset(if path.is_empty() { "index.html" } else { path }) {
        Some(asset) => ([(CONTENT_TYPE, asset.kind)], asset.bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such page\n").into_response(),
    }
}

/// What a browser sees that has not opened the page by the address of the terminal.
fn launch_page(status: StatusCode) -> Response {
    let bytes = asset("launch.html").map_or(&b""[..], |asset| asset.bytes);
    (status, [(CONTENT_TYPE, "text/html; charset=utf-8")], bytes).into_response()
}

/// Events that a tab lacks, at once.
async fn events(State(shared): State<Arc<Shared>>, Query(from): Query<From>) -> Response {
    json(shared.controller.broadcast().message(from.session, from.from).text)
}

/// The last map of the sensor.
async fn sensor(State(shared): State<Arc<Shared>>) -> Response {
    so_far(
        shared.controller.so_far().sensor(),
        "there is no map of the sensor yet\n",
    )
}

/// What a scan in motion knows so far.
async fn in_motion(State(shared): State<Arc<Shared>>) -> Response {
    so_far(shared.controller.so_far().in_motion(), "nothing was swept yet\n")
}

fn so_far(made: Option<String>, none: &'static str) -> Response {
    made.map_or_else(|| (StatusCode::NOT_FOUND, none).into_response(), json)
}

/// The report of the run that is shown.
async fn report(State(shared): State<Arc<Shared>>) -> Response {
    match shared.controller.report() {
        Some(bytes) => {
            let policy = HeaderName::from_static("content-security-policy");
            let headers = [(CONTENT_TYPE, "text/html; charset=utf-8"), (policy, REPORT_POLICY)];
            (headers, bytes).into_response()
        }
        None => (StatusCode::NOT_FOUND, "this run has no report yet\n").into_response(),
    }
}

fn json(text: String) -> Response {
    ([(CONTENT_TYPE, "application/json")], text).into_response()
}

/// A file of the results of the run that is shown, to be kept.
async fn result(State(shared): State<Arc<Shared>>, Path(name): Path<String>) -> Response {
    match shared.controller.result(&name) {
        Some(bytes) => {
            let kept = format!("attachment; filename=\"{name}\"");
            let headers = [
                (CONTENT_TYPE, "application/octet-stream".to_owned()),
                (CONTENT_DISPOSITION, kept),
            ];
            (headers, bytes).into_response()
        }
        None => (StatusCode::NOT_FOUND, "the results have no such file\n").into_response(),
    }
}

/// A file that was dropped on the page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Drop {
    name: String,
    base64: String,
}

/// What is said of a dropped file, and its pictures.
async fn inspect(body: Bytes) -> Response {
    let facts = tokio::task::spawn_blocking(move || {
        let file: Drop = serde_json::from_slice(&body).map_err(|error| error.to_string())?;
        let bytes = STANDARD.decode(&file.base64).map_err(|error| error.to_string())?;
        let facts = dropped(&file.name, &bytes).map_err(|failure| failure.message)?;
        serde_json::to_string(&facts).map_err(|error| error.to_string())
    })
    .await;
    match facts {
        Ok(Ok(text)) => json(text),
        Ok(Err(why)) => (StatusCode::BAD_REQUEST, format!("{why}\n")).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "a defect of the program\n").into_response(),
    }
}

/// A command; the answer says what is done about it. What becomes of it is told by the stream.
async fn command(State(shared): State<Arc<Shared>>, body: Bytes) -> Response {
    let command: Command = match serde_json::from_slice(&body) {
        Ok(command) => command,
        Err(error) => return (StatusCode::BAD_REQUEST, format!("no such command: {error}\n")).into_response(),
    };
    // What a command does may wait for the disk or for another process.
    let controller = shared.controller.clone();
    let done = tokio::task::spawn_blocking(move || controller.command(&command)).await;
    match done {
        Ok(Ok(sentence)) => json(serde_json::json!({ "done": sentence }).to_string()),
        Ok(Err(failure)) => {
            let body = serde_json::json!({ "failed": failure.message, "help": failure.help });
            (
                StatusCode::CONFLICT,
                [(CONTENT_TYPE, "application/json")],
                body.to_string(),
            )
                .into_response()
        }
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "a defect of the program\n").into_response(),
    }
}
