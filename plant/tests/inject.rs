//! Claims about the injector: every command that arrives was sent, none arrives early, and frequencies are those of the scene.

use biped_plant::inject::{Injector, MEAN_BURST_INTERVAL, MEAN_BURST_LENGTH};
use messages::scene::{Jitter, LinkScene};
use messages::wire::{Command, Stamp, Torques};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const PERIOD: f64 = 1e-3;

fn command(seq: u64) -> Command {
    let stamp = Stamp { seq, ack: seq, ..Stamp::default() };
    Command { stamp, torques: Torques { torque: [seq as f64 * 0.1; 8] }, ..Command::default() }
}

/// Sends a command in each of `count` periods. Returns those that arrive, each with the period of its arrival.
fn arrivals(link: &LinkScene, period: f64, count: u64) -> Vec<(u64, Command)> {
    let mut injector = Injector::new(link, period);
    let mut arrived = Vec::new();
    for tick in 1..=count + 20_000 {
        if tick <= count {
            injector.push(tick, &command(tick));
        }
        while let Some(command) = injector.pop(tick) {
            arrived.push((tick, command));
        }
    }
    arrived
}

/// Delays of all commands that arrive [control periods].
fn delays(link: &LinkScene, count: u64) -> Vec<u64> {
    arrivals(link, PERIOD, count).iter().map(|(tick, command)| tick - command.stamp.seq).collect()
}

/// Whether a count of successes in `n` trials is within 5 standard deviations of its probability.
fn fits(count: usize, n: usize, p: f64) -> bool {
    let n = n as f64;
    (count as f64 - n * p).abs() <= 5.0 * (n * p * (1.0 - p)).sqrt()
}

fn any_link() -> impl Strategy<Value = LinkScene> {
    let jitter = prop::sample::select(Jitter::ALL.to_vec());
    let shares = (0.0..=1.0, 0.0..=1.0, 0.0..=1.0);
    (0.0..50.0, 0.0..20.0, jitter, shares, any::<u64>()).prop_map(|(delay_ms, jitter_ms, jitter, shares, seed)| {
        let (loss, duplicate, reorder) = shares;
        LinkScene { delay_ms, jitter_ms, jitter, loss, duplicate, reorder, seed }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_arriving_command_was_sent_and_none_arrives_early(link in any_link()) {
        let arrived = arrivals(&link, PERIOD, 300);
        for seq in 1..=300 {
            let copies = arrived.iter().filter(|(_, command)| command.stamp.seq == seq).count();
            prop_assert!(copies <= 2, "{seq} came {copies} times");
        }
        let least = match link.jitter {
            Jitter::Normal => 0,
            Jitter::Uniform | Jitter::Burst => (link.delay_ms - 1e-8).ceil() as u64,
        };
        for (tick, got) in &arrived {
            prop_assert_eq!(*got, command(got.stamp.seq));
            prop_assert!(tick - got.stamp.seq >= least, "{} at {tick}", got.stamp.seq);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_sequence(link in any_link()) {
        prop_assert_eq!(arrivals(&link, PERIOD, 300), arrivals(&link, PERIOD, 300));
    }

    #[test]
    fn a_command_lost_at_a_small_loss_is_lost_at_a_greater_one(link in any_link(), less in 0.0..=1.0) {
        let kept = |loss: f64| -> Vec<(u64, Command)> { arrivals(&LinkScene { loss, duplicate: 0.0, ..link.clone() }, PERIOD, 300) };
        let all = kept(link.loss * less);
        prop_assert!(kept(link.loss).iter().all(|arrival| all.contains(arrival)));
    }
}

#[test]
fn a_link_without_faults_changes_nothing() {
    for (jitter, seed) in Jitter::ALL.into_iter().flat_map(|jitter| [0, 1995].map(|seed| (jitter, seed))) {
        let arrived = arrivals(&LinkScene { jitter, seed, ..LinkScene::default() }, PERIOD, 1000);
        assert_eq!(arrived, (1..=1000).map(|tick| (tick, command(tick))).collect::<Vec<_>>());
    }
}

#[test]
fn a_delay_is_rounded_up_to_the_beginning_of_a_period() {
    for (delay_ms, period, periods) in [
        (3.0, 1e-3, 3),
        (0.3, 1e-4, 3), // 3.0000000000000004 in binary
        (2.1, 1e-3, 3),
        (0.001, 1e-3, 1),
        (10.0, 4e-3, 3),
    ] {
        let link = LinkScene { delay_ms, ..LinkScene::default() };
        let arrived = arrivals(&link, period, 100);
        assert_eq!(arrived.len(), 100);
        assert!(
            arrived.iter().all(|(tick, command)| tick - command.stamp.seq == periods),
            "{delay_ms} ms at {period} s"
        );
    }
}

#[test]
fn loss_and_duplicates_come_as_often_as_stated() {
    for (seed, share) in [(1, 0.01), (2, 0.3), (3, 0.9)] {
        let lossy = LinkScene { loss: share, seed, ..LinkScene::default() };
        let lost = 100_000 - arrivals(&lossy, PERIOD, 100_000).len();
        assert!(fits(lost, 100_000, share), "seed {seed}: {lost} lost of 100000 at {share}");
        let doubling = LinkScene { duplicate: share, seed, ..LinkScene::default() };
        let more = arrivals(&doubling, PERIOD, 100_000).len() - 100_000;
        assert!(fits(more, 100_000, share), "seed {seed}: {more} came twice of 100000 at {share}");
    }
    assert!(arrivals(&LinkScene { loss: 1.0, ..LinkScene::default() }, PERIOD, 1000).is_empty());
}

#[test]
fn a_reordered_command_comes_right_behind_its_successor() {
    let link = LinkScene { delay_ms: 2.0, reorder: 0.1, seed: 4, ..LinkScene::default() };
    let arrived = arrivals(&link, PERIOD, 100_000);
    let late: Vec<_> = arrived.iter().filter(|(tick, command)| tick - command.stamp.seq == 3).collect();
    assert!(fits(late.len(), 100_000, 0.1), "{}", late.len());
    assert_eq!(arrived.len(), 100_000, "none is lost");
    for (tick, command) in late {
        let of_the_period: Vec<u64> = arrived.iter().filter(|a| a.0 == *tick).map(|a| a.1.stamp.seq).collect();
        assert_eq!(of_the_period.last(), Some(&command.stamp.seq), "{of_the_period:?}");
    }
}

#[test]
fn uniform_jitter_is_spread_evenly() {
    let link = LinkScene { delay_ms: 1.0, jitter_ms: 4.0, seed: 5, ..LinkScene::default() };
    let delays = delays(&link, 100_000);
    for periods in 2..=5 {
        let count = delays.iter().filter(|delay| **delay == periods).count();
        assert!(fits(count, 100_000, 0.25), "{periods} periods: {count}");
    }
    assert!(delays.iter().all(|delay| (1..=5).contains(delay)));
}

#[test]
fn normal_jitter_has_its_standard_deviation_and_is_folded_at_zero() {
    let of =
        |delay_ms: f64| LinkScene { delay_ms, jitter_ms: 2.0, jitter: Jitter::Normal, seed: 6, ..LinkScene::default() };
    // Share below a whole number of periods: Φ((x − d)/σ), and twice that less one when folded at d = 0.
    let phi = [0.158_655_253_931_457, 0.5, 0.841_344_746_068_543];
    let share =
        |link: &LinkScene, periods: u64| delays(link, 100_000).iter().filter(|delay| **delay <= periods).count();
    for (periods, exact) in [8, 10, 12].into_iter().zip(phi) {
        assert!(fits(share(&of(10.0), periods), 100_000, exact), "{periods}");
    }
    assert!(fits(share(&of(0.0), 2), 100_000, 2.0 * phi[2] - 1.0));
}

#[test]
fn bursts_come_and_last_as_stated() {
    let link = LinkScene { jitter_ms: 7.0, jitter: Jitter::Burst, seed: 7, ..LinkScene::default() };
    let mut by_seq: Vec<_> =
        arrivals(&link, PERIOD, 2_000_000).iter().map(|(tick, c)| (c.stamp.seq, tick - c.stamp.seq)).collect();
    by_seq.sort_unstable();
    assert!(by_seq.iter().all(|(_, delay)| [0, 7].contains(delay)));
    let late = by_seq.iter().filter(|(_, delay)| *delay == 7).count() as f64;
    let begun = by_seq.windows(2).filter(|pair| pair[0].1 < pair[1].1).count() as f64;
    // A geometric length has about its mean for a standard deviation; some 3600 bursts.
    assert!((late / begun * PERIOD / MEAN_BURST_LENGTH - 1.0).abs() < 0.1, "{} s", late / begun * PERIOD);
    assert!(
        (late / 2e6 / (MEAN_BURST_LENGTH / (MEAN_BURST_LENGTH + MEAN_BURST_INTERVAL)) - 1.0).abs() < 0.15,
        "{}",
        late / 2e6
    );
}

#[test]
fn sending_and_receiving_allocate_nothing() {
    let link =
        LinkScene { delay_ms: 30.0, jitter_ms: 20.0, jitter: Jitter::Normal, duplicate: 1.0, ..LinkScene::default() };
    let mut injector = Injector::new(&link, PERIOD);
    let count = allocation_counter::measure(|| {
        for tick in 0..10_000 {
            injector.push(tick, &command(tick));
            while injector.pop(tick).is_some() {}
        }
        // A stalled plant: commands beyond the capacity are lost.
        (0..10_000).for_each(|_| injector.push(10_000, &command(1)));
    });
    assert_eq!(count.count_total, 0);
    let left = std::iter::from_fn(|| injector.pop(u64::MAX)).count();
    assert!((300..500).contains(&left), "{left}"); // 2 copies of 30 + 8.6 × 20 ms, and some more
}
