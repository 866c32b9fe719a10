//! A share of the runs.

use std::str::FromStr;

/// The i-th of n equal shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// Whether the shard contains a run. Neighbouring runs go to different shards, so that all shards take about the same time.
    pub fn has(self, number: usize) -> bool {
        number % self.count == self.index - 1
    }

    /// File name of the shard's table in a batch of a command.
    pub fn file_name(self, command: &str) -> String {
        format!("{command}-{}-of-{}.csv", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Shard { index, count }),
            _ => Err("i/n is needed with i from 1 to n, as 1/4".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_in_exactly_one_shard() {
        let shards: Vec<Shard> = (1..=7).map(|i| format!("{i}/7").parse().expect("a shard")).collect();
        assert!((0..1000).all(|number| shards.iter().filter(|shard| shard.has(number)).count() == 1));
        for bad in ["0/4", "5/4", "1", "a/b", "1/0", "-1/4"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
