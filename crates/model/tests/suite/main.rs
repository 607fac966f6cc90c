//! Models and scenes as documents, and the light that they predict.

mod bin_means;
mod cases;
mod catalogue;
mod documents;
mod impossible;
mod near_field;
mod page;
mod scenes;
