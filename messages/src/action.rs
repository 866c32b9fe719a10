//! Requests to a running plant or controller, decoded.

use crate::wire::{Request, RequestKind, Stamped, Verdict};

/// The action that a request demands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Plant: stop simulated time.
    Pause,
    /// Plant: let simulated time go on.
    Resume,
    /// Plant: run for a number of control periods, then pause.
    Step {
        /// Number of control periods.
        periods: u64,
    },
    /// Plant: start a new run from time zero.
    Reset {
        /// New seed; absent: the seed stays.
        seed: Option<u64>,
    },
    /// Plant: push the centre of mass of a body.
    Push {
        /// Number of the body in the scene.
        body: usize,
        /// Impulse in W [N·s].
        impulse: [f64; 3],
        /// Duration of the push [s].
        duration: f64,
    },
    /// Plant: switch the drives on again after a fault.
    Rearm,
    /// Controller: change the gait.
    Gait(GaitRequest),
}

/// What a request asks of the gait.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GaitRequest {
    /// Other set-points.
    Set {
        /// Period of two steps; absent: unchanged [s].
        period: Option<f64>,
        /// Walking speed; absent: unchanged [m/s].
        speed: Option<f64>,
    },
    /// The end of the walk.
    Stop,
}

/// On the wire, the value of a set-point that stays unchanged.
const UNCHANGED: f64 = f64::INFINITY;

impl Action {
    /// Decodes a request.
    ///
    /// # Errors
    /// [`Verdict::Damaged`] if the request is not sealed or its kind is unknown.
    pub fn decode(request: &Request) -> Result<Action, Verdict> {
        let change = |value: f64| (value != UNCHANGED).then_some(value);
        if !request.is_sound() {
            return Err(Verdict::Damaged);
        }
        let kind = usize::try_from(request.kind).ok().and_then(|kind| RequestKind::ALL.get(kind));
        Ok(match kind.ok_or(Verdict::Damaged)? {
            RequestKind::Pause => Action::Pause,
            RequestKind::Resume => Action::Resume,
            RequestKind::Step => Action::Step { periods: request.count },
            RequestKind::Reset => Action::Reset { seed: (request.seed != 0).then_some(request.seed) },
            RequestKind::Push => {
                Action::Push { body: request.count as usize, impulse: request.impulse, duration: request.duration }
            }
            RequestKind::Rearm => Action::Rearm,
            RequestKind::Set => {
                Action::Gait(GaitRequest::Set { period: change(request.period), speed: change(request.speed) })
            }
            RequestKind::Stop => Action::Gait(GaitRequest::Stop),
        })
    }

    /// The action as a request that is not yet sealed.
    pub fn encode(self) -> Request {
        let of = |kind: RequestKind| Request { kind: kind as u64, ..Request::default() };
        match self {
            Action::Pause => of(RequestKind::Pause),
            Action::Resume => of(RequestKind::Resume),
            Action::Step { periods } => Request { count: periods, ..of(RequestKind::Step) },
            Action::Reset { seed } => Request { seed: seed.unwrap_or(0), ..of(RequestKind::Reset) },
            Action::Push { body, impulse, duration } => {
                Request { count: body as u64, impulse, duration, ..of(RequestKind::Push) }
            }
            Action::Rearm => of(RequestKind::Rearm),
            Action::Gait(GaitRequest::Set { period, speed }) => Request {
                period: period.unwrap_or(UNCHANGED),
                speed: speed.unwrap_or(UNCHANGED),
                ..of(RequestKind::Set)
            },
            Action::Gait(GaitRequest::Stop) => of(RequestKind::Stop),
        }
    }

    /// Whether the action is for the controller. All others are for the plant.
    pub fn is_for_controller(self) -> bool {
        matches!(self, Action::Gait(_))
    }
}

impl Request {
    /// The request with the number of the other user who asks through a share. The stamp of an owner's request has zero there.
    pub fn on_behalf_of(mut self, user: Option<u32>) -> Request {
        self.stamp.epoch = user.map_or(0, |user| u64::from(user) + 1);
        self
    }

    /// Number of the other user who asks through a share.
    pub fn other_user(&self) -> Option<u32> {
        u32::try_from(self.stamp.epoch.checked_sub(1)?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::REQUESTS;

    #[test]
    fn a_request_carries_the_user_for_whom_it_is_forwarded() {
        for user in [None, Some(0), Some(1000), Some(u32::MAX)] {
            assert_eq!(Action::Pause.encode().on_behalf_of(user).sealed().other_user(), user);
        }
    }

    #[test]
    fn every_action_survives_encoding_and_decoding() {
        let actions = [
            Action::Pause,
            Action::Resume,
            Action::Step { periods: 3 },
            Action::Reset { seed: Some(7) },
            Action::Push { body: 4, impulse: [1.0, -2.0, 0.5], duration: 0.05 },
            Action::Rearm,
            Action::Gait(GaitRequest::Set { period: None, speed: Some(0.15) }),
            Action::Gait(GaitRequest::Stop),
        ];
        assert_eq!(actions.len(), REQUESTS.len());
        for (kind, action) in actions.into_iter().enumerate() {
            let request = action.encode();
            assert_eq!((request.kind, Action::decode(&request.sealed())), (kind as u64, Ok(action)));
            assert_eq!(Action::decode(&request), Err(Verdict::Damaged), "not sealed");
        }
        assert_eq!(
            Action::decode(&Request { kind: REQUESTS.len() as u64, ..Request::default() }.sealed()),
            Err(Verdict::Damaged)
        );
    }
}
