//! What a front end and a use case that takes long say to each other: events one way, pause, cancel and answers the
//! other.

pub mod control;
pub mod live;
pub mod operator;
pub mod progress;
