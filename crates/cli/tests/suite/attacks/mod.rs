//! Attacks on a running bench. The twins serve in a process of their own over TCP and in real time, the program runs
//! against them, and each file here disturbs it in one way. Whatever happens: no wrong row, no row twice, and the axes
//! rest.
//!
//!     cargo test -p isolux --test suite attacks              # short, as in CI
//!     ISOLUX_ATTACK_ROUNDS=50 ISOLUX_ATTACK_SEED=7 cargo test -p isolux --test suite attacks -- --nocapture
//!
//! `ISOLUX_TEST_DIR` keeps the folders.

#![cfg(unix)]

mod damaged_records;
mod interference;
mod kills;
mod second_process;
mod sleeps;
mod support;
mod sweeps;
mod undisturbed;
