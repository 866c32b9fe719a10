//! The parts of a round trip over our ports: the transfer itself, iceoryx2, and our own additions.

use super::carrier::Carrier;
use super::lines::Wake;
use super::results::Results;
use super::spread::Spread;
use messages::clock::now_ns;
use messages::port::Waiting;
use messages::wire::{Command, Sensors, Stamped};
use shared::exit::Failure;
use std::hint::black_box;

/// Repetitions that are timed together, because one takes about as long as a reading of the clock.
const BATCH: u64 = 100;
const SAMPLES: usize = 2_000;
const PARTS: &str = "round trip over pub/sub, spin, medians [µs]";

/// Times within this process: a reading of the clock, which is part of every sample, and the check sums of a round trip.
///
/// # Errors
/// None; see [`Spread::new`].
pub fn alone(results: &mut Results) -> Result<(), Failure> {
    results.put("clock", "one reading", &batches(|| _ = black_box(now_ns()))?);
    let (mut sensors, mut command) = (Sensors::default(), Command::default());
    let sums = batches(|| {
        black_box(&mut sensors).seal();
        black_box(&mut command).seal();
        black_box(black_box(&sensors).is_sound() && black_box(&command).is_sound());
    })?;
    results.put("check sums", "sensors and command, sealed and checked", &sums);
    Ok(())
}

fn batches(mut job: impl FnMut()) -> Result<Spread, Failure> {
    let batch = |_| {
        let begun = now_ns();
        (0..BATCH).for_each(|_| job());
        (now_ns() - begun) / BATCH
    };
    Spread::of((0..SAMPLES).map(batch))
}

/// Each part of a round trip, as a difference of medians.
pub fn parts(results: &mut Results) {
    let median = |carrier: Carrier| {
        results.spread(carrier.name(), "round trip").map_or(f64::NAN, |spread| spread.quantile(0.5) as f64)
    };
    let [raw, alone, unsealed, whole] = [
        Carrier::Lines(Wake::Spin),
        Carrier::Bare { ours: false },
        Carrier::Bare { ours: true },
        Carrier::Port(Waiting::Spin),
    ]
    .map(median);
    for (part, ns) in [
        ("raw shared memory: one word each way", raw),
        ("iceoryx2: loan, copy, send, receive", alone - raw),
        ("our ports: early loan, late return", unsealed - alone),
        ("stamp, seal, check", whole - unsealed),
    ] {
        results.count(PARTS, part, ns.round() / 1e3);
    }
}
