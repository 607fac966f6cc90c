//! Why a simulation fails, before its map is computed.

use crate::direct::DirectError;
use crate::setup::SetupError;

/// Why a simulation fails.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The scene.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The rays.
    #[error(transparent)]
    Direct(#[from] DirectError),
    /// Another thread asked for it.
    #[error("the simulation was stopped before its end")]
    Stopped,
    /// The camera's responsivity.
    #[error("sensor.responsivity: {message}")]
    Responsivity {
        /// What is wrong, with file and line.
        message: String,
    },
}
