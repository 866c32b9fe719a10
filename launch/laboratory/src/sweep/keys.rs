//! The keys and values of the arguments.

use super::args::SweepArgs;
use crate::batch::axis::{Axis, refused};
use shared::exit::Failure;

/// Name of the axis of seeds, and the keys that it sets.
pub const SEED: &str = "seed";
pub const SEED_KEYS: [&str; 3] = ["link.seed", "plant.seed", "plant.ground.random.seed"];
/// Most seeds of each combination.
const MOST_SEEDS: usize = 1000;
/// Values that `--edge` compares at first unless a number is given: steps of a twentieth of the range.
const EDGE_VALUES: usize = 21;

/// The axes of the arguments.
///
/// # Errors
/// A bad range.
pub fn axes(args: &SweepArgs) -> Result<Vec<Axis>, Failure> {
    let mut axes: Vec<Axis> = args.edge.iter().map(|text| edge(text)).collect::<Result<_, _>>()?;
    let mut count = None;
    for range in &args.ranges {
        match range.split_once('=') {
            Some(("seeds", _)) if count.is_some() => return Err(refused(range, "seeds are given twice".into())),
            Some(("seeds", text)) => count = Some(seeds(text).map_err(|words| refused(range, words))?),
            _ => axes.push(Axis::parse(range).map_err(|words| refused(range, words))?),
        }
    }
    if axes.iter().any(|axis| axis.key == SEED) {
        let words = "write seeds=N for the seeds from 1 to N, or choose those of link.seed, plant.seed or plant.ground.random.seed";
        return Err(refused(SEED, words.into()));
    }
    axes.extend(count.map(|count| Axis { key: SEED.into(), values: (1..=count).map(|k| k.to_string()).collect() }));
    Ok(axes)
}

/// The axis of `--edge`: one range.
fn edge(text: &str) -> Result<Axis, Failure> {
    let refuse = |words| refused(&format!("--edge {text}"), words);
    let ends = text.split_once('=').map(|(_, range)| range.trim().trim_start_matches("log:"));
    let colons = ends.filter(|ends| !ends.contains(',')).map_or(0, |ends| ends.matches(':').count());
    let whole = match colons {
        0 => return Err(refuse("give a key with one range, for example plant.friction=0.1:0.9".into())),
        1 => format!("{}:{EDGE_VALUES}", text.trim()),
        _ => text.into(),
    };
    Axis::parse(&whole).map_err(refuse)
}

fn seeds(text: &str) -> Result<usize, String> {
    let count = text.trim().parse().ok().filter(|count| (1..=MOST_SEEDS).contains(count));
    count.ok_or(format!("a whole number of seeds from 1 to {MOST_SEEDS} is needed"))
}

/// Checks that no key and no value of a key is given twice.
///
/// # Errors
/// Naming it.
pub fn check_keys(axes: &[Axis], settings: &[String]) -> Result<(), Failure> {
    let set = settings.iter().filter_map(|setting| setting.split_once('=')).map(|(key, _)| key.trim());
    let mut known: Vec<&str> = set.collect();
    for axis in axes {
        let keys = if axis.key == SEED { SEED_KEYS.to_vec() } else { vec![axis.key.as_str()] };
        for key in keys {
            if known.contains(&key) {
                return Err(refused(key, "the key is given twice; give all its values at once".into()));
            }
            known.push(key);
        }
        let mut values: Vec<&String> = axis.values.iter().collect();
        values.sort_unstable();
        if let Some(pair) = values.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(refused(&axis.key, format!("the value {} is given twice", pair[0])));
        }
    }
    Ok(())
}
