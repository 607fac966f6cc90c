//! The language of the Parker XLi indexer drives (EASI) as a sans-IO codec: no clock, no I/O.
//!
//! 9600 baud, 8N1. A command is `<address><command><parameters>` without blanks and ends in CR; a report is `*value` CR
//! LF, an error `*E`. The drive echoes what it receives (system variable EX, factory default 3). Bits of status words
//! are counted from the left, from 1.
//!
//! A command by itself is answered by nothing but its echo. [`Easi`] therefore sends a report with every command, so
//! that each exchange ends with a value, and demands the echo of both: an answer is tied to the kind of question,
//! though not to the one question, for the language has no request numbers. Source: Parker Hannifin, "XL25i, XL50i &
//! XL80i Stepper Drive User Guide", chapters 4 and 6.

mod bits;
mod language;

pub use bits::{Bits, NotBits, drive_fault, status, user_fault};
pub use language::{Answer, Easi, Request};
