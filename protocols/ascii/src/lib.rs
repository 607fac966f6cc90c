//! Languages of text lines as sans-IO codecs: no clock, no I/O.
//!
//! A [`Language`] says which bytes ask and when what has arrived is the answer; [`Lines`] makes a conversation of it,
//! with the silence after a failure that a language without request numbers needs. [`Number`] reads the number forms of
//! IEEE 488.2, and [`Pattern`] the replies of an instrument that a profile describes, whose language is [`Plain`].

mod conversation;
mod line;
mod number;
mod pattern;
mod plain;

pub use conversation::{Judgement, Language, Lines, Reply};
pub use line::{Line, line};
pub use number::Number;
pub use pattern::{Fields, NotAPattern, Pattern};
pub use plain::{End, Form, Message, Plain, Received};
