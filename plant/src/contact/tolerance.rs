//! Every tolerance of the contact laws and of standing feet, with its unit, its reason, and the constants that it follows from.
//!
//! All of them are dimensionless [-]: the solvers work on scaled problems, in which the diagonal of A is about 1.
//!
//! ```text
//!   PROMISED 1e-10  >  STANDING_BOUND 8e-11  >  SOLVED 4e-11  >  WELL_SOLVED = COMPLIANCE 2e-11  >  LEMKE_COMPLIANCE 4e-12
//! ```

// Tolerances of a solution.

/// A natural map up to this value is a solution. It lies below [`PROMISED`], so that a second evaluation, which rounds differently, also
/// stays below the promise.
pub(crate) const SOLVED: f64 = 4e-11;

/// The natural map that every solved step promises.
pub const PROMISED: f64 = 1e-10;

/// A natural map up to this value needs no further iteration. Half of [`SOLVED`]: the other half allows for rounding in later evaluations.
pub(crate) const WELL_SOLVED: f64 = 0.5 * SOLVED;

/// Standing feet are accepted up to this bound of their natural map. Twice [`SOLVED`], because the map itself is less than its bound; still
/// below [`PROMISED`].
pub(crate) const STANDING_BOUND: f64 = 2.0 * SOLVED;

// Compliance.

/// Compliance of the contacts: the number that is added to the diagonal of the scaled A.
///
/// Two feet of one robot press against each other along directions that A resolves to 1e-12 or not at all. With the compliance, the impulse
/// there is the one of least norm. Without it, the impulse is a quotient of two rounding errors. Half of [`SOLVED`]: the residual of rigid
/// contacts then seldom exceeds [`SOLVED`].
pub(crate) const COMPLIANCE: f64 = 0.5 * SOLVED;

/// Compliance in patient attempts for round cones. A light body may carry a heavy one, which moves 1e-13 times as easily; with
/// [`COMPLIANCE`] the light one gives way instead. It lies above the rounding of A (1e-16), so that dependent impulses stay small.
pub(super) const LEAST_COMPLIANCE: f64 = 1e-3 * COMPLIANCE;

/// Compliance while Lemke's method pivots with 32 digits. It lies far above the rounding of A (1e-16), so that there is one solution. It is
/// a tenth of [`SOLVED`], so that it does not show in the residual.
pub(super) const LEMKE_COMPLIANCE: f64 = 0.1 * SOLVED;

/// Compliances in the steps of [`super::compared`]'s semismooth Newton method, tried in this order. The residual does not include them. The
/// first is [`COMPLIANCE`]; where it lets a step go too far along directions that A resolves to 1e-12, larger ones shorten the step. The
/// last is the first again, from the better start.
pub(super) const STEP_COMPLIANCES: [f64; 6] = [COMPLIANCE, 1e-4, 1e-5, 1e-7, 1e-9, COMPLIANCE];

// Rounding.

/// Rounding of A f + b, relative to the sum of the magnitudes of its terms. No contact can be judged more finely.
pub(super) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The same with the rounding of the entries of A, which are sums over a path of links.
pub(super) const ROUNDING_OF_A: f64 = 10.0 * ROUNDING;

/// Rounding excuses a contact if it leaves less than this part of its natural map. Sweeps that have not converged are excused for less.
pub(super) const EXCUSED: f64 = 0.5;

/// A contact stays on the ground if it misses more than this part of the speed with which it has to leave. It enters the ground if it
/// approaches with more than this part of V. Solutions reach all of it, or stop it.
pub(super) const MISSED: f64 = 0.5;

/// A natural map above this value is no rounding error, however large the terms of A f are.
pub(super) const ABOVE_ROUNDING: f64 = 1e-3;

/// A natural map up to this value is rounding for the semismooth Newton method of the compared laws: another step would change nothing.
pub(super) const SEMISMOOTH_ROUNDING: f64 = 1e-14;

/// The same for proximal steps of the energy program, which end at one unit in the last place.
pub(super) const PROXIMAL_ROUNDING: f64 = f64::EPSILON;

/// A contact that pulls by less than this part of the greatest normal impulse pulls by rounding only.
pub(crate) const PULL_ROUNDING: f64 = 1e-14;

/// An amount that becomes zero keeps a rounding error below this, relative to its value before.
pub(super) const ZERO_AMOUNT: f64 = 1e-14;

/// A negative edge velocity of the energy program up to this part of the step's scale is rounding. Some thousand units in
/// the last place: the velocity is a sum over many edges.
pub(super) const NEGATIVE_VELOCITY: f64 = 1e-12;

/// A value that falls by less than this part of the fastest change along a path does not fall.
pub(super) const MIN_FALL: f64 = 1e-10;

// Dependent directions.

/// Remaining diagonal of A, relative to the greatest, below which a direction depends on those before it. A has 16 digits, so the remainder
/// of a dependent direction is near 1e-16.
pub(super) const DEPENDENT: f64 = 1e-12;

/// The same for a pivot among entries of about 1, with compliant contacts. It must lie below [`COMPLIANCE`], because the pivot of a
/// redundant contact is the compliance alone.
pub(super) const DEPENDENT_PIVOT: f64 = 1e-14;

/// The same for cases in which any of the dependent solutions is acceptable.
pub(super) const NEARLY_DEPENDENT_PIVOT: f64 = 1e-7;

/// A diagonal entry of A, relative to the greatest, below which the contact cannot move in that direction. A = YᵀY squares the rounding of
/// Y, so a true zero is near 1e-32.
pub(super) const IMMOVABLE: f64 = 1e-20;

/// Three contacts lie on one line if the determinant of their moment matrix, relative to the product of its diagonal, is below this value.
pub(crate) const COLLINEAR: f64 = 1e-9;

// Directions and slip.

/// An impulse or a slip up to this part of its scale has no direction.
pub(super) const NO_DIRECTION: f64 = 1e-6;

/// At the optimum of the energy program, a contact slips if it moves faster than this part of the step's scale.
pub(super) const MIN_SLIP: f64 = 1e-10;

// Convergence of iterations.

/// A refinement continues while it reduces its error to this part or less. An error that shrinks less lies along dependent directions.
pub(super) const REFINEMENT_REDUCTION: f64 = 0.1;

/// Every repeated solution of standing feet must reduce the velocity error to this part or less.
pub(crate) const STANDING_REDUCTION: f64 = 0.5;

/// Factor by which the friction weight of a slipping contact is reduced beyond the necessary, in the distribution over a patch or a sole, so
/// that few trials suffice.
pub(crate) const OVERREDUCTION: f64 = 1.5;

/// A fixed-point iteration progresses if its change falls below this part of the least change before.
pub(super) const FIXED_POINT_PROGRESS: f64 = 0.9;

/// Minima of a fixed-point iteration without progress before its relaxation changes.
pub(super) const FIXED_POINT_PATIENCE: u32 = 6;

/// Greatest friction of the first problem on the way to greater friction [-]. Interior points solve nearly all problems with less. From .01 on,
/// slow steps of walks would take a fifth more linear systems.
pub(super) const FIRST_FRICTION: f64 = 1.0;

/// Factor on the friction from one of these problems to the next [-]. Of 88 slow problems of rough ground the median takes 26 linear systems; with
/// 3 it takes 40, and with 100 some take as many as without.
pub(super) const FRICTION_FACTOR: f64 = 10.0;

/// Exchanges of contacts at most. The 22 plates of a million problems that no other stage solves take 3 to 13.
pub(super) const MAX_EXCHANGES: usize = 24;

/// Minima of a fixed-point iteration at most. Of the problems of [`super::coulomb`] that need minima, half need one, and one in ten needs more
/// than ten. Two feet that press against each other need up to 80.
pub(super) const MAX_MINIMA: u32 = 200;

/// The same before the law `Cone` starts from random values.
pub(super) const FIRST_MINIMA: u32 = 100;

/// Minima from a random shift. A shift that leads to a solution seldom needs more than three.
pub(super) const RESTART_MINIMA: u32 = 4;

/// A random shift is between all of the slip without impulses and 10 to the power of minus this number of it.
pub(super) const RESTART_DECADES: f64 = 4.0;

/// Newton's method over patches progresses if its residual falls below this part of the least before.
pub(super) const NEWTON_PROGRESS: f64 = 0.5;

/// From an impulse with a residual up to this value, Newton's method is tried once more with balanced weights. Far from a solution that seldom
/// succeeds; interior points do. With 1e-3 or 1e-1 slow steps of walks take nearly as many linear systems.
pub(super) const NEAR_SOLUTION: f64 = 1e-2;

/// Interior points progress if the greater of τ and residual falls below this part of the least before.
pub(super) const INTERIOR_PROGRESS: f64 = 0.5;

/// Factor on the relaxation of a fixed-point iteration that creeps in one direction without progress.
pub(super) const ACCELERATION: f64 = 2.0;

/// Factor on the relaxation of a fixed-point iteration that oscillates without progress.
pub(super) const DAMPING: f64 = 0.5;

/// Interior points stop to reduce the complementarity τ below this value, the step's speed being 1. The impulse is then within 1e-10 of its
/// cone (the root of this value), and Newton's method finds the last digits. Below, rounding of x decides whether x is inside its cone.
pub(super) const MIN_TAU: f64 = 1e-20;

/// The residual of interior points that is rounding, the step's speed being 1.
pub(super) const INTERIOR_RESIDUAL: f64 = 1e-13;

/// Tolerances of gap and feasibility for the external interior-point solver (clarabel). It ends near 1e-9; Newton's method removes the
/// remaining error.
pub(super) const CLARABEL_TOLERANCE: f64 = 1e-13;

// Least squares of the natural map.

/// Weights ρ of the velocities, relative to the mass of a contact. Feet that press against each other move 1e-3 to 1e-6 times as fast as
/// without contact: a smaller weight does not see their velocity, and a larger one sees nothing else.
pub(super) const WEIGHTS: [f64; 4] = [1e3, 1e4, 1e5, 1e6];

/// Random starts at most, each one of least squares and one of energy minima, times the rows of the problem. Of the problems of two feet, 24
/// rows, that need them, each start solves one in two to one in a hundred, often only by one of the two methods.
pub(super) const RANDOM_START_ROWS: usize = 24 * MAX_RANDOM_STARTS;

/// Bounds of this number. A start with 192 rows takes 300 times as long as one with 24.
pub(super) const MIN_RANDOM_STARTS: usize = 20;
pub(super) const MAX_RANDOM_STARTS: usize = 100;

/// Random starts have weights between 10 to the power of these two numbers. Which weight solves a problem differs from problem to problem.
pub(super) const WEIGHT_DECADES: [f64; 2] = [2.0, 8.0];

/// Runs of Newton's method with random weights.
pub(super) const WEIGHTED_RUNS: u32 = 100;

/// Their weights, relative to the mass of a contact, lie between 10 to the power of these two numbers. Problems with masses of 1 : 1e14 need small
/// and great ones.
pub(super) const MASS_DECADES: [f64; 2] = [-8.0, 8.0];

/// Their compliances lie between 10 to the power of these two numbers: from the rounding of A to a little above [`LEAST_COMPLIANCE`].
pub(super) const COMPLIANCE_DECADES: [f64; 2] = [-16.0, -13.5];

/// A random impulse is at most between the one that stops a contact and 10 to the power of minus this number of it.
pub(super) const START_DECADES: f64 = 2.0;

/// Steps at most, taken or not. From the best impulse 10 to 20 are typical.
pub(super) const LEAST_SQUARES_STEPS: u32 = 300;

/// λ of the first step. The greatest entries of JᵀJ are 1 to ρ².
pub(super) const FIRST_DAMPING: f64 = 1e-2;

/// The least λ: it only keeps the matrix regular.
pub(super) const LEAST_DAMPING: f64 = 1e-18;

/// Factors on λ after a step that was taken and after one that was not.
pub(super) const DAMPING_DECREASE: f64 = 0.2;
pub(super) const DAMPING_INCREASE: f64 = 8.0;

/// Steps that are not taken, one after the other, before the method ends. λ has then grown by 8⁸.
pub(super) const MAX_REJECTED: u32 = 8;

/// |F| up to this part of the greatest drift is rounding.
pub(super) const LEAST_SQUARES_ROUNDING: f64 = 1e-15;

// Lemke's method, with 32 digits.

/// Entries up to this value are not accepted as pivots. In the scaled problem a true pivot is about 1. With [`LEMKE_COMPLIANCE`], entries
/// reach the inverse of that value, and their rounding 1e-20.
pub(super) const MIN_PIVOT: f64 = 1e-16;

/// Rows that reach zero within this distance of each other, relative to the largest entry of each row, are tied. The right side is about 1.
pub(super) const TIE: f64 = 1e-28;

/// A pivot that differs from 1 by more than this factor has cost three digits: the dictionary is then recomputed.
pub(super) const MAX_PIVOT_RATIO: f64 = 1e3;

/// Perturbation of the right side that separates tied rows. Far above the rounding of 32 digits, and far below [`SOLVED`].
pub(super) const PERTURBATION: f64 = 1e-14;

// Input.

/// A given A is symmetric if its entries differ by no more than this part of the geometric mean of the diagonal. A larger difference is an
/// error in the data, not rounding.
pub(super) const ASYMMETRY: f64 = 1e-9;
