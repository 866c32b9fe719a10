//! Shifts of the energy program (14)-(16), and how they grow to mu |v_F|: see [`super::solver::Solver`].
//!
//! Without exaggeration they come nearer by a factor each round. Where a foot turns against what hardly yields, the factor
//! is almost one, and thousands of rounds would ask for the same small change.

/// How the shifted energy program is tried: rounds, and how shifts grow. (Most steps need one round, few the second way.)
pub(super) const WAYS: [(usize, Growth); 4] =
    [(20, Growth::Plain), (40, Growth::Common(10)), (30, Growth::Common(0)), (400, Growth::Each)];
/// Greatest exaggeration of all shifts together.
const MOST: f64 = 64.0;

/// How shifts grow from round to round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Growth {
    /// To the slip that they caused.
    Plain,
    /// Twice as far beyond it each time that this is asked for again undiminished, each by itself.
    Each,
    /// The same together, as long as the residual stays, from this round on.
    Common(usize),
}

impl Growth {
    /// How far all shifts go beyond the slip that they caused, after they went `boost` in the round before.
    pub fn boost(self, round: usize, boost: f64, stays: bool) -> f64 {
        match self {
            Growth::Common(from) if stays && round >= from => f64::min(2.0 * boost, MOST),
            _ => 1.0,
        }
    }
}

/// What is added to the v_N of a contact: mu |v_F| in the end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shift {
    pub value: f64,
    /// The last change that was asked for, and by how much it was exaggerated.
    change: f64,
    boost: f64,
}

impl Shift {
    /// Goes to the slip that it caused, or as far beyond as `boost` says; without it, twice as far each time that the
    /// change is asked for again undiminished.
    pub fn approach(&mut self, slip: f64, boost: Option<f64>) {
        let change = slip - self.value;
        let again = change * self.change > 0.5 * self.change * self.change;
        self.boost = boost.unwrap_or(if again { 2.0 * self.boost } else { 1.0 });
        self.change = change;
        self.value = (self.value + self.boost * change).max(0.0);
    }
}
