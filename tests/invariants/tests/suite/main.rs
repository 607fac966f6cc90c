//! The rules of `docs/architecture.md`, and what the documents promise.

mod book;
mod rules;
mod systems;
