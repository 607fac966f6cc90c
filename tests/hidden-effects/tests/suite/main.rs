//! A small suite of hidden effects with fixed seeds, judged by what is claimed.

mod colour;
mod share;
mod verdicts;
