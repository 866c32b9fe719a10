//! The stages of a step without contact, and of setting up its contact problem, at one state.

use crate::robot::{Activity, Recording};
use divan::{Bencher, black_box};
use messages::scene::Law;
use plant::composite::Composite;
use plant::delassus::{ContactMap, Free};
use plant::detect::{Touch, touching};
use plant::dynamics;
use plant::factor::{Factor, PathMatrix};
use plant::ground::GroundHeights;
use plant::kinematics::{self, Pose};
use plant::model::Model;
use plant::state::State;

/// All quantities of one state.
struct Evaluated {
    model: Model,
    state: State,
    pose: Pose,
    composite: Composite,
    h: PathMatrix,
    b: Vec<f64>,
    factor: Factor,
    touches: Vec<Touch>,
    map: ContactMap,
}

impl Evaluated {
    /// In the middle of the window.
    fn of(activity: Activity) -> Evaluated {
        let recording = Recording::of(activity, &[]);
        let model = Model::new(&recording.scene).expect("a good scene");
        let state = recording.states[recording.states.len() / 2].clone();
        let (composite, pose) = (Composite::new(&model), Pose::of(&model, &state));
        let (h, b) = Composite::equations(&model, &pose, &state.xdot);
        let factor = Factor::of(&model, &h).expect("H is positive definite");
        let mut touches = vec![];
        touching(&model, &GroundHeights::plane(&model), &pose, Law::Cone, 1e-3, &state.xdot, &mut touches);
        let map = ContactMap::new(&model);
        Evaluated { model, state, pose, composite, h, b, factor, touches, map }
    }
}

/// Fourteen degrees of freedom. The rotation of the base is three virtual joints, or a quaternion.
const BASES: [Activity; 2] = [Activity::Walking, Activity::Standing];

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn kinematics(bencher: Bencher, activity: Activity) {
    let Evaluated { model, state, mut pose, .. } = Evaluated::of(activity);
    bencher.bench_local(|| kinematics::pose(&model, black_box(&state), black_box(&mut pose)));
}

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn h_fast(bencher: Bencher, activity: Activity) {
    let Evaluated { model, pose, mut composite, mut h, .. } = Evaluated::of(activity);
    bencher.bench_local(|| composite.inertia(&model, black_box(&pose), black_box(&mut h)));
}

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn h_by_unit_accelerations(bencher: Bencher, activity: Activity) {
    let Evaluated { model, pose, .. } = Evaluated::of(activity);
    bencher.bench_local(|| dynamics::inertia(&model, black_box(&pose)));
}

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn b_fast(bencher: Bencher, activity: Activity) {
    let Evaluated { model, state, pose, mut composite, mut b, .. } = Evaluated::of(activity);
    bencher.bench_local(|| composite.bias(&model, black_box(&pose), &state.xdot, black_box(&mut b)));
}

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn b_by_inverse_dynamics(bencher: Bencher, activity: Activity) {
    let Evaluated { model, state, pose, .. } = Evaluated::of(activity);
    bencher.bench_local(|| dynamics::bias(&model, black_box(&pose), &state.xdot));
}

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn factorisation(bencher: Bencher, activity: Activity) {
    let Evaluated { model, h, mut factor, .. } = Evaluated::of(activity);
    bencher.bench_local(|| factor.factorize(&model, black_box(&h)));
}

#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn solve(bencher: Bencher, activity: Activity) {
    let Evaluated { model, mut b, factor, .. } = Evaluated::of(activity);
    bencher.bench_local(|| factor.solve(&model, black_box(&mut b)));
}

/// Eight contacts with a quaternion base, four with a virtual one.
#[divan::bench(args = BASES, sample_count = 200, sample_size = 64)]
fn k_and_delassus(bencher: Bencher, activity: Activity) {
    let Evaluated { model, state, pose, factor, touches, mut map, .. } = Evaluated::of(activity);
    bencher.bench_local(|| {
        let free = Free { pose: black_box(&pose), factor: &factor, rate: &state.xdot };
        map.drift(&model, &free, &touches, Law::Cone, |_, drift| drift);
        black_box(map.assemble(&model, &free, &touches));
    });
}
