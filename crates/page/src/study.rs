//! What is worked out of the runs: numbers, maps and pictures, without a command to the bench.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse as _, Response};
use isolux_app::Failure;
use isolux_app::drawing::{PolarSoFar, polar_so_far};
use isolux_app::study::what_if::{self, Variation, WhatIf};
use isolux_app::study::{card, diagnosed, next, results};
use serde::{Deserialize, Serialize};

use crate::controller::Controller;
use crate::shared::Shared;

/// What can be worked out.
#[derive(Debug, Deserialize)]
#[serde(tag = "study", rename_all = "snake_case", deny_unknown_fields)]
enum Study {
    /// The card of a run of the folder; the others are of the run that is shown.
    Card { run: String },
    /// The results, without these corrections; none: as they lie in the folder.
    Results { without: Option<Vec<String>> },
    /// The sensor in a pose.
    Illuminated { requested: Variation },
    /// Rays against the noise-free solution in that pose.
    Convergence { requested: Variation },
    /// The newest diagnosis.
    Diagnosis {},
    /// The plan of a proposal.
    Next { number: usize },
    /// The polar diagram of what a tab has seen of the scan.
    Polar { so_far: PolarSoFar },
}

impl Study {
    fn of(&self, controller: &Controller, what_if: &WhatIf) -> Result<String, Failure> {
        match self {
            Self::Card { run } => json(&card::card(&controller.named(run)?)?),
            Self::Results { without } => json(&results::results(&controller.run()?, without.as_deref())?),
            Self::Illuminated { requested } => json(&what_if.illuminated(&controller.run()?, requested)?),
            Self::Convergence { requested } => json(&what_if::convergence(&controller.run()?, requested)?),
            Self::Diagnosis {} => json(&diagnosed::diagnosed(&controller.run()?)?),
            Self::Next { number } => json(&next::shown(&controller.run()?, *number)?),
            Self::Polar { so_far } => json(&serde_json::json!({ "svg": polar_so_far(so_far) })),
        }
    }
}

fn json(of: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(of).map_err(Failure::instrument)
}

/// `POST /api/study`.
pub async fn study(State(shared): State<Arc<Shared>>, body: Bytes) -> Response {
    let study: Study = match serde_json::from_slice(&body) {
        Ok(study) => study,
        Err(error) => return (StatusCode::BAD_REQUEST, format!("no such study: {error}\n")).into_response(),
    };
    let done = tokio::task::spawn_blocking(move || study.of(&shared.controller, &shared.what_if)).await;
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
