//! The time of a piece of work of some nanoseconds.

use crate::println;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Rounds of which the best and the middle one are told.
const ROUNDS: usize = 201;
/// A round takes at least so long: ten thousand times what the clock resolves.
const ROUND: Duration = Duration::from_micros(500);

/// Measures the pieces of work whose names contain one of the words on the command line; without
/// words, all.
#[derive(Debug)]
pub struct Stopwatch {
    words: Vec<String>,
}

impl Stopwatch {
    /// With the words of the command line.
    pub fn from_arguments() -> Self {
        // Cargo adds `--bench`.
        let words = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
        println!("{:64} {:>9} {:>9}", "time of one call [ns]", "best", "median");
        Self { words }
    }

    /// Prints the time of one call, of the best round and of the middle one.
    pub fn measure<R>(&self, name: &str, mut work: impl FnMut() -> R) {
        if !(self.words.is_empty() || self.words.iter().any(|word| name.contains(word))) {
            return;
        }
        let mut round = |calls: u32| {
            let start = Instant::now();
            for _ in 0..calls {
                black_box(work());
            }
            start.elapsed()
        };
        let mut calls = 1;
        while round(calls) < ROUND {
            calls *= 2;
        }
        let mut times: Vec<Duration> = (0..ROUNDS).map(|_| round(calls)).collect();
        times.sort_unstable();
        let of_call = |time: Duration| time.as_secs_f64() * 1e9 / f64::from(calls);
        let [best, median] = [times[0], times[ROUNDS / 2]].map(of_call);
        println!("{name:64} {best:9.2} {median:9.2}");
    }
}
