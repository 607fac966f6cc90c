//! Every fuzz target reads damaged copies of good input without a panic, and `fuzz/` names each of them.

use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Damaged copies of each seed.
const COPIES: usize = 1500;

/// What stands in files of strangers where a number should.
const WORDS: [&[u8]; 12] = [
    b"NaN",
    b"1e999",
    b"-1",
    b"0",
    b"99999999999999999999",
    b"inf",
    b",",
    b"\n",
    b"\xff\xfe",
    b"\0",
    b"\"",
    b"[",
];

fn damage(bytes: &mut Vec<u8>, random: &mut impl Rng) {
    for _ in 0..random.random_range(1..=3) {
        if bytes.is_empty() {
            return;
        }
        // Every second one in the head, where the counts stand.
        let end = if random.random() {
            bytes.len()
        } else {
            bytes.len().min(400)
        };
        let at = random.random_range(0..end);
        let to = (at + random.random_range(1..=40)).min(bytes.len());
        match random.random_range(0..6) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = random.random(),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..to)),
            4 => {
                let again = bytes[at..to].to_vec();
                bytes.splice(at..at, again);
            }
            _ => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                let to = (at + word.len()).min(bytes.len());
                bytes.splice(at..to, word.iter().copied());
            }
        }
    }
}

#[test]
fn damaged_input_is_never_a_panic() {
    for target in isolux_fuzz::targets() {
        let seeds = (target.seeds)();
        assert!(!seeds.is_empty(), "{}", target.name);
        for (k, seed) in seeds.iter().enumerate() {
            (target.run)(seed);
            (0..COPIES).into_par_iter().for_each(|copy| {
                let mut random = ChaCha8Rng::seed_from_u64((k * COPIES + copy) as u64);
                let mut bytes = seed.clone();
                damage(&mut bytes, &mut random);
                let read = std::panic::catch_unwind(|| (target.run)(&bytes));
                assert!(read.is_ok(), "{}, seed {k}, copy {copy}", target.name);
            });
        }
    }
}

/// `fuzz/Cargo.toml` has a binary for each target; all are the one file that hands the bytes to the target of its name.
#[test]
fn cargo_fuzz_has_them_all() {
    let manifest = include_str!("../../../fuzz/Cargo.toml");
    for target in isolux_fuzz::targets() {
        let bin = format!("name = \"{}\"\npath = \"fuzz_targets/target.rs\"\n", target.name);
        assert!(manifest.contains(&bin), "{} in fuzz/Cargo.toml", target.name);
    }
    assert_eq!(manifest.matches("[[bin]]").count(), isolux_fuzz::targets().count());
}
