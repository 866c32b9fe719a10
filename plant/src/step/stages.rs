//! Coefficients and stages of explicit Runge-Kutta methods.

use crate::model::Model;
use crate::state::State;

/// Coefficients of an explicit method. Forces do not depend on time, so the nodes are not needed.
#[derive(Debug)]
pub(super) struct Tableau {
    /// Weights of the previous stages, from the second stage on.
    pub a: &'static [&'static [f64]],
    /// Weights of the result.
    pub b: &'static [f64],
    /// Weights of the recorded contact forces. They are not negative, so that a mean of forces that push within the cone of friction does so.
    pub record: &'static [f64],
}

/// The classical method of fourth order.
pub(super) const RK4: Tableau =
    Tableau { a: &[&[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]], b: RK4_WEIGHTS, record: RK4_WEIGHTS };

const RK4_WEIGHTS: &[f64] = &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// The method of Dormand and Prince of eighth order.
///
/// Two of its weights b are negative, so the forces are recorded by another quadrature on its nodes 0, 1/4, 127/195, 3/5, 6/7 and 1. It is exact
/// for polynomials up to degree 5, the highest degree that weights without a negative one reach on the nodes of b. The stages have order 5, so
/// the recorded forces have order 6.
///
/// # Source
/// Hairer, Nørsett & Wanner, program DOP853. Interpolatory quadrature: Davis & Rabinowitz, *Methods of Numerical Integration* (1984), 2.5.
#[rustfmt::skip]
pub(super) const DOP853: Tableau = Tableau {
    a: &[
        &[0.05260015195876773],
        &[0.0197250569845379, 0.0591751709536137],
        &[0.02958758547680685, 0.0, 0.08876275643042054],
        &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
        &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
        &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
        &[0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023],
        &[0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894, -43.48988418106996],
        &[0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423, -33.28821096898486, -0.020331201708508627],
        &[-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196],
        &[2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636],
    ],
    b: &[0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259],
    record: &[2081.0 / 27432.0, 0.0, 0.0, 0.0, 0.0, 0.0, 41728.0 / 111741.0, 0.0, 751868325.0 / 3038248432.0, 50.0 / 567.0, 487403.0 / 3095496.0, 47.0 / 816.0],
};

/// Its error estimates of fifth and third order, as weights of the stages.
#[rustfmt::skip]
pub(super) const DOP853_ERRORS: [&[f64]; 2] = [
    &[0.01312004499419488, 0.0, 0.0, 0.0, 0.0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294],
    &[-0.18980075407240762, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082],
];

/// The stages of a step.
#[derive(Debug)]
pub(super) struct Stages {
    /// Rate of the displacement in each stage.
    displacement_rate: Vec<Vec<f64>>,
    /// Acceleration in each stage.
    acceleration: Vec<Vec<f64>>,
    /// d and ẋ of the present stage.
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    /// Velocity change that the contact forces cause in the step.
    pub contact_change: Vec<f64>,
}

impl Stages {
    pub fn new(model: &Model) -> Self {
        let zeros = || vec![0.0; model.dofs()];
        let room = || vec![zeros(); DOP853.b.len()];
        Stages {
            displacement_rate: room(),
            acceleration: room(),
            displacement: zeros(),
            velocity: zeros(),
            contact_change: zeros(),
        }
    }

    /// Greatest entry of h times the weighted sum of the stages, relative to 1 + |ẋ0|.
    pub fn sum(&self, start: &State, weights: &[f64], h: f64) -> f64 {
        let entry =
            |stages: &[Vec<f64>], i: usize| weights.iter().zip(stages).map(|(w, k)| w * k[i]).sum::<f64>().abs();
        let both = |(i, rate): (usize, &f64)| {
            entry(&self.displacement_rate, i).max(entry(&self.acceleration, i)) / (1.0 + rate.abs())
        };
        h.abs() * start.xdot.iter().enumerate().map(both).fold(0.0, f64::max)
    }

    /// d and ẋ0 + Δẋ for h times the weighted sum of the stages.
    pub fn combine(&mut self, start: &State, weights: &[f64], h: f64) -> (&[f64], &[f64]) {
        let Stages { displacement_rate, acceleration, displacement, velocity, .. } = self;
        velocity.copy_from_slice(&start.xdot);
        displacement.fill(0.0);
        for ((weight, displacement_rate), acceleration) in
            weights.iter().zip(displacement_rate).zip(acceleration).filter(|((weight, _), _)| **weight != 0.0)
        {
            let step = h * weight;
            displacement.iter_mut().zip(displacement_rate).for_each(|(d, rate)| *d += step * *rate);
            velocity.iter_mut().zip(acceleration).for_each(|(v, rate)| *v += step * *rate);
        }
        (displacement, velocity)
    }

    /// Stores the rates of a stage.
    pub fn take(&mut self, stage: usize, model: &Model, state: &State, acceleration: &[f64]) {
        self.acceleration[stage].copy_from_slice(acceleration);
        match stage {
            0 => self.displacement_rate[stage].copy_from_slice(&state.xdot), // d = 0
            _ => state.displacement_rate(model, &self.displacement, &mut self.displacement_rate[stage]),
        }
    }
}
