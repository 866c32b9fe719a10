//! View (iv): the same scene on models of growing size: difference of the answer, and cost.

use super::cases::{self, Combination, LAW, METHOD};
use super::core::Core;
use super::csv::{Measurement, OURS, View};
use super::trial::{RunEnd, RunLog, time, watch_until};
use super::watch::{ChartProgress, Job};
use messages::load::parse;
use messages::scene::{Base, Law, Scene};
use shared::exit::{Exit, Failure, check_interrupt};

/// The step [s].
const H: f64 = 1e-3;

/// Models of one scene from small to large. The answer of the last one, the full model, is the reference.
pub struct Group {
    /// Name in the table.
    pub name: &'static str,
    /// Heading: the growing quantity.
    pub title: &'static str,
    models: fn() -> Result<Vec<ModelSize>, Failure>,
}

/// A model: its name, its scene, and the law.
type ModelSize = (String, Scene, Law);

/// The groups as the page shows them.
pub const GROUPS: [Group; 5] = [
    Group { name: "pendulum", title: "base: an inverted pendulum on its foot", models: pendulum },
    Group { name: "base", title: "base: a cube slides along x", models: bases },
    Group { name: "points", title: "points that can touch: the same cube", models: points },
    Group { name: "feet", title: "points that can touch: a biped in flight", models: feet },
    Group { name: "directions", title: "directions of friction: a cube slides across the axes", models: directions },
];

/// A row for each model: difference from the full model, and cost.
///
/// # Errors
/// Ctrl-C, or a scene that is refused.
pub fn measure(progress: &ChartProgress) -> Result<Vec<Measurement>, Failure> {
    let mut rows = Vec::new();
    let _core = Core::hold();
    for group in GROUPS {
        let models = (group.models)()?;
        progress.expect(models.len());
        let mut answers = Vec::new();
        for (name, mut scene, law) in models {
            progress.step(Job::Sizing)?;
            (scene.plant.law, scene.plant.method, scene.plant.dt, scene.rate) = (law, METHOD, H, 1.0 / H);
            let RunEnd::Done(log) = watch_until(&scene, &[], progress.stop) else {
                check_interrupt(progress.stop)?;
                return Err(Failure::new(
                    Exit::Fault,
                    format!("the model {} / {name} cannot be simulated", group.name),
                ));
            };
            let (seconds, _) = time(&scene, &[], progress.stop)?;
            answers.push((name, answer(&log), seconds, scene.duration, scene.periods()));
        }
        let Some(full) = answers.last().map(|last| last.1) else { continue };
        rows.extend(answers.into_iter().map(|(method, answer, seconds, duration, steps)| Measurement {
            view: View::Models,
            scene: group.name.into(),
            engine: OURS.into(),
            method,
            dt: H,
            metric: "difference".into(),
            error: difference(answer, full),
            cost: seconds / duration,
            us_per_step: 1e6 * seconds / steps as f64,
        }));
    }
    Ok(rows)
}

/// Momentum and kinetic energy at the end [N·s, J].
fn answer(log: &RunLog) -> [f64; 4] {
    let totals = log.samples.last().map(|sample| sample.totals).unwrap_or_default();
    [totals.linear.x, totals.linear.y, totals.linear.z, totals.kinetic]
}

fn difference(answer: [f64; 4], full: [f64; 4]) -> f64 {
    let norm = |of: [f64; 4]| of.iter().map(|part| part * part).sum::<f64>().sqrt();
    norm(std::array::from_fn(|i| answer[i] - full[i])) / norm(full)
}

/// A comparison scene with a duration in which the bodies do not come to rest.
fn scene(name: &str, duration: f64) -> Result<Scene, Failure> {
    let mut scene = cases::scene(name, Combination { law: LAW, method: METHOD }, H, &[])?;
    scene.duration = duration;
    Ok(scene)
}

fn on(base: Base, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.plant.base = base;
    scene
}

const ROD: &str = r#"
duration = 0.5

[initial]
orientation_deg = [0.0, 5.0, 0.0]

[[bodies]]
name = "rod"
mass = 1.0
size = [0.02, 0.02, 0.02]
com = [0.0, 0.0, 0.8]
contacts = [[0.0, 0.0, 0.0]]
"#;

const HINGE: &str = r#"
duration = 0.5

[plant]
base = "fixed"
drive_inertia = 0.0

[initial]
joints = [0.08726646259971647]

[[bodies]]
name = "ground"
mass = 1.0
size = [0.1, 0.1, 0.1]

[[bodies]]
name = "rod"
mass = 1.0
size = [0.02, 0.02, 0.02]
com = [0.0, 0.0, 0.8]
joint = { parent = "ground", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }
"#;

fn pendulum() -> Result<Vec<ModelSize>, Failure> {
    let (hinge, rod) = (parse(HINGE, "hinge")?, parse(ROD, "rod")?);
    Ok(vec![
        ("fixed: a hinge, 1 degree of freedom".into(), hinge, LAW),
        ("planar: 3, and a contact point".into(), on(Base::Planar, &rod), LAW),
        ("virtual joints: 6".into(), on(Base::Virtual, &rod), LAW),
        ("quaternion: 6".into(), on(Base::Quaternion, &rod), LAW),
    ])
}

fn bases() -> Result<Vec<ModelSize>, Failure> {
    let slide = scene("slide", 0.3)?;
    let names =
        [(Base::Planar, "planar: 3"), (Base::Virtual, "virtual joints: 6"), (Base::Quaternion, "quaternion: 6")];
    Ok(names.into_iter().map(|(base, name)| (name.into(), on(base, &slide), LAW)).collect())
}

/// On a planar base one point stands for an edge of the cube. The upper corners never touch.
fn points() -> Result<Vec<ModelSize>, Failure> {
    let slide = scene("slide", 0.3)?;
    let (mut two, mut eight) = (on(Base::Planar, &slide), slide.clone());
    two.bodies[0].contacts.retain(|point| point[1] > 0.0);
    eight.bodies[0].contacts.extend(slide.bodies[0].contacts.iter().map(|point| [point[0], point[1], -point[2]]));
    Ok(vec![
        ("2, planar base".into(), two, LAW),
        ("4, the sole".into(), slide, LAW),
        ("8, every corner".into(), eight, LAW),
    ])
}

fn feet() -> Result<Vec<ModelSize>, Failure> {
    let free = scene("free", 0.5)?;
    let mut none = free.clone();
    none.bodies.iter_mut().for_each(|body| body.contacts.clear());
    Ok(vec![("0".into(), none, LAW), ("8, both soles".into(), free, LAW)])
}

fn directions() -> Result<Vec<ModelSize>, Failure> {
    let slide = scene("slide30", 0.3)?;
    let model = |name: &str, law| (name.into(), slide.clone(), law);
    Ok(vec![
        model("1, along the slip: Complementarity", Law::Complementarity),
        model("2, with across it: Aligned", Law::Aligned),
        model("4, fixed: Facets(4)", Law::Facets(4)),
        model("8, fixed: Facets(8)", Law::Facets(8)),
        model("16, fixed: Facets(16)", Law::Facets(16)),
        model("all of them: Cone", Law::Cone),
    ])
}
