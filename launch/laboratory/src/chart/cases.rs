//! What is compared: the scenes with their exact answers, the ways to simulate them, and the steps to do it with.

use messages::load::{load, validate};
use messages::scene::{Law, Method, Scene};
use serde::Serialize;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;

/// A comparison scene.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Name of the scene.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// The error that it is about, for an axis.
    pub words: &'static str,
    /// What is asked of it.
    pub question: Question,
    /// An error to come below.
    pub bound: f64,
}

/// What is asked of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Does free flight keep its energy?
    Flight,
    /// Where does what slides flat end up?
    Slide,
    /// How far does what slips slide down?
    Descend,
    /// Does what sticks stay?
    Stick,
    /// Does what falls stop at the ground?
    Drop,
    /// Do the feet stay?
    Stand,
    /// How high does the block rock after its impact?
    Rock,
    /// How fast does the wheel roll?
    Wheel,
    /// How far does what slides and turns get, and turn?
    Turn,
    /// Where is the ball that rolls, and how has it turned?
    Roll,
}

impl Question {
    /// Metrics that answer it, the same for every engine; the greatest of them is drawn.
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

    /// Whether its centre of mass moves by a formula besides.
    pub fn has_formula(self) -> bool {
        matches!(self, Question::Slide | Question::Descend | Question::Stick | Question::Drop)
    }
}

/// How deep something sinks into the ground [m].
pub const PENETRATION: &str = "penetration_m";

/// How high above the ground something rises that should touch it [m].
pub const HOP: &str = "hop_m";

const fn case(name: &'static str, title: &'static str, words: &'static str, question: Question, bound: f64) -> Case {
    Case { name, title, words, question, bound }
}

/// The twelve comparison scenes.
pub const CASES: [Case; 12] = [
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
    case("turn", "turn: a puck slides and turns", "error of the turn, or of the way [-]", Question::Turn, 1e-4),
    case("ball", "ball: a loaded ball rolls", "error of the angle, or of the way [-]", Question::Roll, 1e-3),
];

/// Steps that the finest run may take.
const PATIENCE: f64 = 1e4;

/// A contact law with an integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// The law.
    pub law: Law,
    /// The integrator.
    pub method: Method,
}

/// The law under which integrators are compared.
pub const LAW: Law = Law::DEFAULT;
/// The integrator with which laws are compared.
pub const METHOD: Method = Method::MoreauJean;

impl Way {
    /// As tables have it: `Cone/MoreauJean`.
    pub fn name(self) -> String {
        format!("{}/{}", word(&self.law), word(&self.method))
    }

    /// Share of the steps that it is given: what takes many times as long gets as many times fewer.
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

/// A setting as a scene has it.
pub fn word(value: &impl Serialize) -> String {
    let json = serde_json::to_value(value).unwrap_or_default();
    json.as_str().map_or(json.to_string(), String::from)
}

/// Every integrator under one law, and every law with one integrator. In flight there is no law; where points come and
/// go, or eight of them share a load, step doubling takes the shortest of its steps throughout; the page says so.
pub fn ways(case: &Case) -> Vec<Way> {
    let steady = !matches!(case.question, Question::Rock | Question::Wheel | Question::Stand);
    let methods = Method::ALL.iter().filter(|&&method| steady || method != Method::StepDoubling);
    let mut ways: Vec<_> = methods.map(|&method| Way { law: LAW, method }).collect();
    if case.question != Question::Flight {
        ways.extend(Law::ALL.iter().filter(|&&law| law != LAW).map(|&law| Way { law, method: METHOD }));
    }
    ways
}

/// Steps h for a case, coarse to fine [s]; the coarsest in any case.
pub fn steps(case: &Case, way: Way, duration: f64, quick: bool) -> Vec<f64> {
    let fits = |h: &f64| duration / h <= 1.001 * way.share() * PATIENCE;
    let grid = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5];
    match quick {
        true if way.share() < 1.0 && case.question == Question::Stand => Vec::new(),
        true => [5e-3, 1e-3].into_iter().filter(fits).collect(),
        false => grid.into_iter().filter(|h| *h == grid[0] || fits(h)).collect(),
    }
}

/// The cases called `names`; all of them for none.
///
/// # Errors
/// One sentence on a name that is no comparison scene.
pub fn chosen(names: &[String]) -> Result<Vec<Case>, Failure> {
    let known = || CASES.map(|case| case.name).join(", ");
    if let Some(name) = names.iter().find(|name| CASES.iter().all(|case| case.name != **name)) {
        let message = format!("--scenes: there is no comparison scene `{name}`; there are {}", known());
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(CASES.into_iter().filter(|case| names.is_empty() || names.iter().any(|name| name == case.name)).collect())
}

/// The scene, simulated this way with this step: one step to a control period.
///
/// # Errors
/// A scene that is refused.
pub fn scene(name: &str, way: Way, h: f64, settings: &[String]) -> Result<Scene, Failure> {
    let mut scene = load(name, settings, SCENES)?;
    (scene.plant.law, scene.plant.method) = (way.law, way.method);
    (scene.plant.dt, scene.rate) = (h, 1.0 / h);
    validate(&scene, name)?;
    Ok(scene)
}
