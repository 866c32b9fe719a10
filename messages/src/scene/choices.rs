//! Choices of a scene, each one word in its file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declares an enum together with `ALL`, its variants in the order of the declaration.
macro_rules! listed {
    ($(#[$meta:meta])* pub enum $enum:ident { $( $(#[$variant_meta:meta])* $variant:ident, )* }) => {
        $(#[$meta])*
        pub enum $enum { $( $(#[$variant_meta])* $variant, )* }

        impl $enum {
            /// Every variant, in the order of the declaration.
            pub const ALL: [$enum; [$( stringify!($variant) ),*].len()] = [$( $enum::$variant ),*];
        }
    };
}

listed! {
    /// Distribution of the additional delay of a command. Delays are independent of each other, except in bursts.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
    #[serde(rename_all = "kebab-case")]
    pub enum Jitter {
        /// Uniform between 0 and `jitter_ms`.
        #[default]
        Uniform,
        /// Normal with the standard deviation `jitter_ms` about `delay_ms`. A delay below zero changes its sign.
        Normal,
        /// `jitter_ms` within bursts and 0 outside. On average a burst begins .5 s after the last one has ended and lasts .05 s, both
        /// exponentially distributed (Gilbert's two-state chain).
        Burst,
    }
}

/// Coordinates of the base. A scene should use as few degrees of freedom as it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Base {
    /// Fixed to the world: no degrees of freedom.
    Fixed,
    /// Forward, up and pitch: three degrees of freedom.
    Planar,
    /// The paper's virtual joints x, y, z, yaw, pitch, roll: six degrees of freedom.
    Virtual,
    /// Position and unit quaternion, velocities in W: six degrees of freedom without a singularity; the default.
    Quaternion,
}

listed! {
    /// Integration methods, from simple to exact: how a step of `dt` computes the next state.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
    pub enum Method {
        /// Position with the old velocity. First order. It gains energy and serves as a negative example.
        ExplicitEuler,
        /// Velocity first, then position with the new velocity: the paper's method. First order.
        SemiImplicitEuler,
        /// Moreau-Jean with theta = 1/2: forces and velocities are means over the step, contact acts at its end. Second order.
        MoreauJean,
        /// All forces at the midpoint of the step, position by half a step each of the old and the new velocity. Second order, one evaluation.
        MidpointMoreau,
        /// The midpoint rule with the contact law at the end of the step, impacts at their own time, springs and dampers implicit. Second
        /// order in lasting, rolling and turning contact and at impacts. It does not create energy.
        MidpointContact,
        /// Runge-Kutta of fourth order for the free motion, contact as one impulse at the end of the step.
        Rk4,
        /// Runge-Kutta of fourth order with the contact forces in every stage; a step is split at impact and at the end of slip.
        Rk4Impact,
        /// The implicit midpoint rule, contact included, iterated to rounding. Second order, symmetric in time.
        ImplicitMidpoint,
        /// `MidpointContact` with steps as short as `tolerance_step` requires. One step is compared with two half steps.
        StepDoubling,
        /// Dormand-Prince 8(5,3) with contact forces in every stage, step lengths by `tolerance_step`, events located in time: the reference.
        EventDriven,
    }
}

impl Method {
    /// Whether the method supports `restitution`.
    pub fn bounces(self) -> bool {
        match self {
            Method::SemiImplicitEuler | Method::MidpointContact | Method::StepDoubling => true,
            Method::Rk4Impact | Method::EventDriven => true,
            Method::ExplicitEuler | Method::MoreauJean | Method::MidpointMoreau => false,
            Method::Rk4 | Method::ImplicitMidpoint => false,
        }
    }

    /// Whether the method chooses its step length by `tolerance_step`.
    pub fn chooses_steps(self) -> bool {
        match self {
            Method::StepDoubling | Method::EventDriven => true,
            Method::ExplicitEuler | Method::SemiImplicitEuler | Method::MoreauJean | Method::MidpointMoreau => false,
            Method::MidpointContact | Method::Rk4 | Method::Rk4Impact | Method::ImplicitMidpoint => false,
        }
    }

    /// Whether the method computes contact forces between events, which it locates in time.
    pub fn locates_events(self) -> bool {
        match self {
            Method::Rk4Impact | Method::EventDriven => true,
            Method::ExplicitEuler | Method::SemiImplicitEuler | Method::MoreauJean | Method::MidpointMoreau => false,
            Method::MidpointContact | Method::Rk4 | Method::ImplicitMidpoint | Method::StepDoubling => false,
        }
    }
}

/// Task of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gait {
    /// Stand on both feet.
    Stand,
    /// Step in place, or walk when `speed` is not zero.
    Walk,
}

/// Rule that stabilises the sagittal plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sagittal {
    /// Foot placement: the predicted state at touchdown determines the landing position.
    FootPlacement,
    /// The paper's rule: mirror the foot about the centre of gravity, x_t1 = 2 x_c1, and control the energy E_1 by (42).
    Energy,
}

/// Nominal inertia J_n of the servos.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NominalInertia {
    /// A matrix: that of the robot with its drives and a fixed supporting foot.
    Matrix,
    /// A number for each joint, as in (23).
    Diagonal,
}

/// Switching element of the sliding mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Switching {
    /// Proportional within a boundary layer around the sliding surface.
    BoundaryLayer,
    /// The sign of the sliding variable, with full amplitude.
    Relay,
}
