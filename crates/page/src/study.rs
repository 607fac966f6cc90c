//! What is worked out of the run that is shown: numbers, maps and pictures, without a command to the bench.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse as _, Response};
use camino::Utf8Path;
use isolux_app::Failure;
use isolux_app::study::what_if::{self, Asked};
use isolux_app::study::{diagnosed, next, results};
use serde::{Deserialize, Serialize};

use crate::shared::Shared;

/// What can be worked out.
#[derive(Debug, Deserialize)]
#[serde(tag = "study", rename_all = "snake_case", deny_unknown_fields)]
enum Study {
    /// The results, without these corrections; none: as they lie in the folder.
    Results { without: Option<Vec<String>> },
    /// The sensor in a pose.
    Lit { asked: Asked },
    /// Rays against the noise-free solution in that pose.
    Convergence { asked: Asked },
    /// The newest diagnosis.
    Diagnosis {},
    /// The plan of a proposal.
    Next { number: usize },
}

impl Study {
    fn of(&self, run: &Utf8Path) -> Result<String, Failure> {
        match self {
            Self::Results { without } => json(&results::results(run, without.as_deref())?),
            Self::Lit { asked } => json(&what_if::lit(run, asked)?),
            Self::Convergence { asked } => json(&what_if::convergence(run, asked)?),
            Self::Diagnosis {} => json(&diagnosed::diagnosed(run)?),
            Self::Next { number } => json(&next::shown(run, *number)?),
        }
    }
}

fn json(of: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(of).map_err(Failure::instrument)
}

/// `POST /api/study`.
pub async fn study(State(shared): State<Arc<Shared>>, body: Bytes) -> Response {
    let asked: Study = match serde_json::from_slice(&body) {
        Ok(asked) => asked,
        Err(error) => return (StatusCode::BAD_REQUEST, format!("no such study: {error}\n")).into_response(),
    };
    let desk = shared.desk.clone();
    let done = tokio::task::spawn_blocking(move || asked.of(&desk.run()?)).await;
    let (status, text) = match done {
        Ok(Ok(text)) => (StatusCode::OK, text),
        Ok(Err(failure)) => {
            let body = serde_json::json!({ "failed": failure.message, "help": failure.help });
            (StatusCode::CONFLICT, body.to_string())
        }
        Err(_) => return (StatusCode::INTERNAL_SERVER_ERROR, "a defect of the program\n").into_response(),
    };
    (status, [(CONTENT_TYPE, "application/json")], text).into_response()
}
