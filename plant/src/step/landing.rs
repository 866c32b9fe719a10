//! Search for the time at which a point meets the ground. Each trial integrates a part of the step and gives the gap at its end.
//!
//! The first trial gives the curvature of a parabola, whose root is the second trial. Later trials follow the secant, because the forces at
//! other contacts may change with the length of the part, and with them the curvature. A root outside the known bracket is replaced by the
//! middle of the bracket.

/// Time of a landing since the beginning of a part [s], and the gap then [m].
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    pub time: f64,
    pub gap: f64,
}

/// What the trials have shown so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct LandingSearch {
    /// The latest time above the ground and the earliest below it [s].
    above: f64,
    below: f64,
    last: Option<Landing>,
}

impl LandingSearch {
    /// Nothing is known, except that the part begins above the ground.
    pub fn new() -> LandingSearch {
        LandingSearch { above: 0.0, below: f64::INFINITY, last: None }
    }

    /// The next time to try within `h`. `start` and `rate` are the gap at the beginning [m] and its derivative [m/s].
    pub fn next(&mut self, trial: Landing, [start, rate]: [f64; 2], h: f64) -> f64 {
        let Landing { time, gap } = trial;
        match gap > 0.0 {
            true => self.above = self.above.max(time),
            false => self.below = self.below.min(time),
        }
        let root = match self.last.replace(trial) {
            None => first_root(start, rate, (gap - start - rate * time) / (time * time)),
            Some(last) => time - gap * (time - last.time) / (gap - last.gap),
        };
        let inside = root > self.above && root < self.below;
        if inside { root } else { 0.5 * (self.above + self.below) }.min(h)
    }
}

/// Time at which a point meets the ground: gap + rate t + bend t² = 0, with rate < 0.
pub(super) fn first_root(gap: f64, rate: f64, curvature: f64) -> f64 {
    2.0 * gap / (-rate + (rate * rate - 4.0 * curvature * gap).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::{Landing, LandingSearch};

    /// Trials until the gap is a part of 1e-5 of the displacement in 1 ms.
    fn trials(gap: impl Fn(f64) -> f64) -> usize {
        let (h, rate) = (1e-3, -0.03);
        let (mut search, mut time) = (LandingSearch::new(), 1e-4);
        (1..50)
            .find(|_| {
                let trial = Landing { time, gap: gap(time) };
                time = search.next(trial, [gap(0.0), rate], h);
                trial.gap.abs() <= 1e-5 * 0.03 * h
            })
            .unwrap_or(50)
    }

    #[test]
    fn a_landing_is_found_in_a_few_trials_also_if_the_acceleration_changes_with_the_length_of_the_part() {
        let start = 3.2e-6;
        assert_eq!(trials(|t| start - 0.03 * t + 40.0 * t * t), 2, "a parabola is exact");
        // Measured in the walk: the roots of parabolas through start and trial alternate between two times without end.
        let bend = |t: f64| start - 0.03 * t + if t < 1.2e-4 { 75.0 } else { 75.0 - 3e5 * (t - 1.2e-4) } * t * t;
        // Here they would creep: the gap hardly falls until a foot leaves the ground.
        let creeps = |t: f64| start - 0.03 * t + 60.0 * t * t * (1.0 - (t / 1.5e-4).powi(4)).max(-0.2);
        for (name, count) in [("alternates", trials(bend)), ("creeps", trials(creeps))] {
            println!("{name}: {count} trials");
            assert!(count <= 8, "{name}: {count} trials");
        }
    }
}
