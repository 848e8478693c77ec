//! Every parser of bytes from outside, fed with mutated seeds: nothing panics, hangs or reserves more than a gigabyte.
//!
//! A test run tries each target for a moment. `fuzz/run.sh` sets `DSSLAM_FUZZ_SECONDS` and `DSSLAM_FUZZ_TARGET` for more; the driver sees no
//! coverage, but keeps inputs at which a parser says something new. Inputs that once failed are in `fuzz/regressions`.

#![allow(clippy::disallowed_methods, reason = "inputs are timed, results are not")]

#[path = "../../../fuzz/src/lib.rs"]
#[allow(unreachable_pub, dead_code, reason = "it is a library where libFuzzer calls it")]
mod targets;

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::root;
use targets::{TARGETS, Target};

/// A single input may take this long.
const PATIENCE: Duration = Duration::from_secs(10);
/// The most memory that a process may have had, 10^6 bytes.
const MEMORY_MB: u64 = 1000;
/// Longest input.
const MAX_LEN: usize = 16 << 10;
/// Inputs kept beside the seeds.
const MAX_POOL: usize = 2000;
/// What numbers in texts are replaced by.
const WORDS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "-1e308",
    "1e-320",
    "4294967296",
    "2147483648",
    "18446744073709551616",
    "9999999999999999999999",
    "0x10",
    ".5",
    "1_000",
    "null",
    "true",
    "[]",
    "{}",
    "\u{feff}",
    "",
];

/// What a target went through.
#[derive(Default)]
struct Trial {
    n: u64,
    slowest: Duration,
    said: BTreeSet<String>,
}

/// What a parser said without its numbers, names and quotations.
fn gist(said: &str) -> String {
    let letters = said.chars().filter(|c| c.is_ascii_lowercase() || *c == ' ').take(160);
    letters.collect::<String>().split_whitespace().filter(|word| word.len() > 2).collect::<Vec<_>>().join(" ")
}

/// Runs a target on one input; a panic names the input's file.
fn run(target: &Target, input: &[u8], trial: &mut Trial) -> String {
    let begun = Instant::now();
    let said = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    let took = begun.elapsed();
    trial.n += 1;
    trial.slowest = trial.slowest.max(took);
    let failed = |what: &str| {
        let file = std::env::temp_dir().join(format!("dsslam-fuzz-{}-{}.bin", target.name, trial.n));
        fs::write(&file, input).unwrap();
        panic!("{}: {what} with the input {}", target.name, file.display());
    };
    if took > PATIENCE {
        failed("more than 10 s");
    }
    said.unwrap_or_else(|_| failed("a panic"))
}

fn mutate(pool: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut input = pool.choose(random).unwrap().clone();
    for _ in 0..random.random_range(1..=6) {
        change(&mut input, pool, random);
    }
    input.truncate(MAX_LEN);
    input
}

fn change(input: &mut Vec<u8>, pool: &[Vec<u8>], random: &mut ChaCha8Rng) {
    if input.is_empty() {
        input.push(random.random());
        return;
    }
    let at = random.random_range(0..input.len());
    let end = (at + 1 + random.random_range(0..32)).min(input.len());
    match random.random_range(0..12) {
        0 => input[at] ^= 1 << random.random_range(0..8),
        1 => input[at] = random.random(),
        2 => input[at] = *[0, 1, 0x7f, 0x80, 0xff, b'\n', b' ', b'-', b'.', b':'].choose(random).unwrap(),
        3 => drop(input.drain(at..end)),
        4 => input.truncate(at),
        5 => {
            let piece = input[at..end].to_vec();
            input.splice(at..at, piece);
        }
        6 => {
            // The rest of another input.
            let other = pool.choose(random).unwrap();
            let from = random.random_range(0..=other.len());
            input.truncate(at);
            input.extend(&other[from..]);
        }
        7 => {
            let value = ((1_u64 << random.random_range(0..64)) - random.random_range(0..2)).to_le_bytes();
            let n = *[2, 4, 8].choose(random).unwrap();
            for (place, byte) in input[at..].iter_mut().zip(&value[..n]) {
                *place = *byte;
            }
        }
        8..10 => replace_word(input, at, WORDS.choose(random).unwrap().as_bytes()),
        10 => {
            let word = WORDS.choose(random).unwrap();
            input.splice(at..at, word.bytes());
        }
        _ => {
            // A line more, or one less.
            let begin = input[..at].iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
            let end = input[at..].iter().position(|&b| b == b'\n').map_or(input.len(), |i| at + i + 1);
            let line = input[begin..end].to_vec();
            let keeps = random.random_bool(0.5);
            input.splice(begin..if keeps { begin } else { end }, if keeps { line } else { Vec::new() });
        }
    }
}

/// Replaces the word around a place.
fn replace_word(input: &mut Vec<u8>, at: usize, word: &[u8]) {
    let is_part = |b: &u8| b.is_ascii_alphanumeric() || b".-+_".contains(b);
    let begin = input[..at].iter().rposition(|b| !is_part(b)).map_or(0, |i| i + 1);
    let end = input[at..].iter().position(|b| !is_part(b)).map_or(input.len(), |i| at + i);
    input.splice(begin..end.max(begin), word.iter().copied());
}

fn try_for(target: &Target, time: Duration, seed: u64) -> Trial {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut pool, mut trial) = ((target.seeds)(), Trial::default());
    for input in pool.clone() {
        let said = run(target, &input, &mut trial);
        trial.said.insert(gist(&said));
    }
    let begun = Instant::now();
    while begun.elapsed() < time {
        for _ in 0..200 {
            let input = mutate(&pool, &mut random);
            let said = run(target, &input, &mut trial);
            if pool.len() < MAX_POOL && trial.said.insert(gist(&said)) {
                pool.push(input);
            }
        }
        let memory = peak_memory_mb();
        assert!(memory < MEMORY_MB, "{}: {memory} MB after {} inputs", target.name, trial.n);
    }
    trial
}

/// Most memory that this process has had; 0 where the system does not tell.
fn peak_memory_mb() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).map_or(0, |kb| kb / 1000)
}

/// The number that the environment names.
fn setting(name: &str) -> Option<u64> {
    std::env::var(name)
        .ok()
        .map(|value| value.parse().unwrap_or_else(|_| panic!("{name}: `{value}` is not a number")))
}

#[test]
fn mutated_inputs_are_refused_or_read() {
    let wanted = std::env::var("DSSLAM_FUZZ_TARGET").ok();
    let time = Duration::from_secs_f64(setting("DSSLAM_FUZZ_SECONDS").map_or(0.3, |seconds| seconds as f64));
    let seed = setting("DSSLAM_FUZZ_SEED").unwrap_or(1);
    let chosen = TARGETS.iter().filter(|target| wanted.as_deref().is_none_or(|name| name == target.name));
    let mut n_targets = 0;
    for target in chosen {
        let trial = try_for(target, time, seed);
        let (name, n, kinds) = (target.name, trial.n, trial.said.len());
        let slowest = 1000.0 * trial.slowest.as_secs_f64();
        println!(
            "{name:<15} {n:>9} inputs, {kinds:>4} different answers, slowest {slowest:.1} ms, peak {} MB",
            peak_memory_mb()
        );
        n_targets += 1;
    }
    assert!(n_targets > 0, "no target is called {wanted:?}");
}

#[test]
fn seeds_are_accepted_and_reach_what_they_are_for() {
    for target in TARGETS {
        let said: Vec<String> = (target.seeds)().iter().map(|seed| (target.run)(seed)).collect();
        let is_accepted =
            |said: &String| said.contains("accepted") || said == "ended" || said.contains("Whole");
        // Of formats that are many, each seed stands for one.
        let is_each = ["calibrations", "layouts", "trajectories", "bags"].contains(&target.name);
        let n = said.iter().filter(|said| is_accepted(said)).count();
        assert!(if is_each { n == said.len() } else { n > 0 }, "{}: {said:#?}", target.name);
    }
}

/// Inputs that once made a parser fail, in files that begin with the name of their target.
#[test]
fn inputs_that_once_failed_are_handled() {
    for entry in fs::read_dir(root().join("fuzz/regressions")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let Some(target) = TARGETS.iter().find(|target| name.starts_with(&format!("{}-", target.name)))
        else {
            continue;
        };
        run(target, &fs::read(&path).unwrap(), &mut Trial::default());
    }
}

/// cargo-fuzz finds each target by its file.
#[test]
fn every_target_has_its_file_for_libfuzzer() {
    let manifest = fs::read_to_string(root().join("fuzz/Cargo.toml")).unwrap();
    for target in TARGETS {
        let path = format!("fuzz_targets/{}.rs", target.name);
        let text = fs::read_to_string(root().join("fuzz").join(&path)).unwrap();
        assert!(text.contains(&format!("\"{}\"", target.name)), "{path}");
        assert!(manifest.contains(&format!("path = \"{path}\"")), "{path} is not in fuzz/Cargo.toml");
    }
}
