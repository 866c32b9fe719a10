//! The comparison: scenes with exact answers, combinations of contact law and integrator, and step lengths.

use messages::load::{load, validate};
use messages::scene::{Law, Method, Scene};
use serde::Serialize;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;

/// A comparison scene.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonScene {
    /// Name of the scene.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Label of the error axis.
    pub words: &'static str,
    /// The question that the scene answers.
    pub question: Question,
    /// The error bound to reach.
    pub bound: f64,
}

/// The question that a scene answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Does free flight keep its energy?
    Flight,
    /// Where does a sliding body stop?
    Slide,
    /// How far does a body slide down a slope?
    Descend,
    /// Does a sticking body stay in place?
    Stick,
    /// Does a falling body stop at the ground?
    Drop,
    /// Do the feet stay in place?
    Stand,
    /// How high does the block rock after its impact?
    Rock,
    /// How fast does the wheel roll?
    Wheel,
    /// How far does a sliding, turning body travel and turn?
    Turn,
    /// How far does a rolling ball travel and turn?
    Roll,
}

impl Question {
    /// Metrics that answer the question, the same for every engine. The largest of them is drawn.
    pub fn metrics(self) -> &'static [&'static str] {
        match self {
            Question::Flight => &["energy"],
            Question::Slide => &["stop", "straight"],
            Question::Descend => &["distance"],
            Question::Stick | Question::Stand => &["creep_m_per_s"],
            Question::Drop => &[PENETRATION, HOP],
            Question::Rock => &["apex"],
            Question::Wheel => &["speed"],
            Question::Turn => &["yaw", "way"],
            Question::Roll => &["angle", "way"],
        }
    }

    /// Whether the body lies flat on the ground.
    pub fn is_flat(self) -> bool {
        self.has_formula() || self == Question::Turn
    }

    /// Whether a closed formula gives the motion of its centre of mass.
    pub fn has_formula(self) -> bool {
        matches!(self, Question::Slide | Question::Descend | Question::Stick | Question::Drop)
    }
}

/// Greatest penetration depth [m].
pub const PENETRATION: &str = "penetration_m";

/// Greatest height above the ground of a body that should touch it [m].
pub const HOP: &str = "hop_m";

const fn case(
    name: &'static str,
    title: &'static str,
    words: &'static str,
    question: Question,
    bound: f64,
) -> ComparisonScene {
    ComparisonScene { name, title, words, question, bound }
}

/// The twelve comparison scenes.
pub const CASES: [ComparisonScene; 12] = [
    case("free", "free: a biped in flight", "drift of the kinetic energy [-]", Question::Flight, 1.5e-12),
    case("slide", "slide: along x", "error of the stopping point [-]", Question::Slide, 1e-5),
    case("slide30", "slide30: across the axes", "error of the stopping point [-]", Question::Slide, 1e-5),
    case("incline", "incline: down 20°", "error of the distance [-]", Question::Descend, 1e-6),
    case("stick", "stick: half a degree inside the cone", "creep [m/s]", Question::Stick, 1e-12),
    case("drop", "drop: a foot falls flat", "penetration or hop [m]", Question::Drop, 1e-9),
    case("stand0", "stand0: a biped on level ground", "creep of the feet [m/s]", Question::Stand, 1e-12),
    case("stand10", "stand10: a biped on 10°", "creep of the feet [m/s]", Question::Stand, 1e-12),
    case("rock", "rock: a block on its edges", "error of the apex [-]", Question::Rock, 1e-3),
    case("wheel", "wheel: without a rim, down 8°", "error of the speed [-]", Question::Wheel, 1e-4),
    case("turn", "turn: a puck slides and turns", "error of the angle or of the distance [-]", Question::Turn, 1e-4),
    case("ball", "ball: a loaded ball rolls", "error of the angle or of the distance [-]", Question::Roll, 1e-3),
];

/// Greatest number of steps of a run [-]: 1 s in steps of 0.1 ms.
const MOST_STEPS: f64 = 1e4;
/// Tolerance of that number for the rounding of duration / h, relative [-].
const STEPS_ROUNDING: f64 = 1e-3;

/// A combination of contact law and integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Combination {
    /// The law.
    pub law: Law,
    /// The integrator.
    pub method: Method,
}

/// The law under which integrators are compared.
pub const LAW: Law = Law::DEFAULT;
/// The integrator with which laws are compared.
pub const METHOD: Method = Method::MoreauJean;

impl Combination {
    /// Name in tables: `Cone/MoreauJean`.
    pub fn name(self) -> String {
        format!("{}/{}", word(&self.law), word(&self.method))
    }

    /// Number of steps, as a share of the greatest one [-]. A method whose step takes n times as long as the plain one gets n times fewer steps, so
    /// that no combination dominates the time of a chart. The shares are rounded.
    pub fn share(self) -> f64 {
        match (self.law, self.method) {
            (Law::FixedPoint(_), _) => 0.05,
            (Law::ConeQp, _) | (_, Method::EventDriven) => 0.1,
            (_, Method::StepDoubling) => 0.1,
            (_, Method::ImplicitMidpoint) => 0.2,
            _ => 1.0,
        }
    }
}

/// A setting as it is written in a scene.
pub fn word(value: &impl Serialize) -> String {
    let json = serde_json::to_value(value).unwrap_or_default();
    json.as_str().map_or(json.to_string(), String::from)
}

/// Every integrator under one law, and every law with one integrator.
///
/// In flight laws make no difference. Step doubling is left out where contacts open and close, or where eight points share a load: it
/// would take its shortest step throughout. The page says so.
pub fn combinations(case: &ComparisonScene) -> Vec<Combination> {
    let steady = !matches!(case.question, Question::Rock | Question::Wheel | Question::Stand);
    let methods = Method::ALL.iter().filter(|&&method| steady || method != Method::StepDoubling);
    let mut combinations: Vec<_> = methods.map(|&method| Combination { law: LAW, method }).collect();
    if case.question != Question::Flight {
        combinations.extend(Law::ALL.iter().filter(|&&law| law != LAW).map(|&law| Combination { law, method: METHOD }));
    }
    combinations
}

/// Steps h of a case, coarse to fine [s]. The coarsest step is always included.
pub fn steps(case: &ComparisonScene, combination: Combination, duration: f64, quick: bool) -> Vec<f64> {
    let fits = |h: &f64| duration / h <= (1.0 + STEPS_ROUNDING) * combination.share() * MOST_STEPS;
    let grid = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5];
    match quick {
        true if combination.share() < 1.0 && case.question == Question::Stand => Vec::new(),
        true => [5e-3, 1e-3].into_iter().filter(fits).collect(),
        false => grid.into_iter().filter(|h| *h == grid[0] || fits(h)).collect(),
    }
}

/// The cases with these names; all cases if there are no names.
///
/// # Errors
/// A name that is not a comparison scene.
pub fn chosen(names: &[String]) -> Result<Vec<ComparisonScene>, Failure> {
    let known = || CASES.map(|case| case.name).join(", ");
    if let Some(name) = names.iter().find(|name| CASES.iter().all(|case| case.name != **name)) {
        let message = format!("--scenes: there is no comparison scene `{name}`; there are {}", known());
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(CASES.into_iter().filter(|case| names.is_empty() || names.iter().any(|name| name == case.name)).collect())
}

/// The scene with this law, integrator and step: one step per control period.
///
/// # Errors
/// A scene that is refused.
pub fn scene(name: &str, combination: Combination, h: f64, settings: &[String]) -> Result<Scene, Failure> {
    let mut scene = load(name, settings, SCENES)?;
    (scene.plant.law, scene.plant.method) = (combination.law, combination.method);
    (scene.plant.dt, scene.rate) = (h, 1.0 / h);
    validate(&scene, name)?;
    Ok(scene)
}
