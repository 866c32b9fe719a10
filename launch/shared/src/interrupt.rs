//! Ctrl-C and TERM, also during a step that takes minutes.
//!
//! A simulation checks the stop flag between its control periods. [`requested`] sets the flag and waits. If a simulation does not end, its
//! step is under way for too long, and the program ends without it.

use crate::exit::Exit;
use messages::log;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard};
use std::thread::sleep;
use std::time::Duration;

/// Time that a control period under way has to end: [`POLLS`] of these. They are counted, so that time in which the process is stopped
/// does not count.
const POLL: Duration = Duration::from_millis(50);
/// 2.5 s: a launcher kills its processes after 2 s, and a plant has to end within 3 s.
const POLLS: u32 = 50;

/// What is lost in most commands.
pub const RESULTS_LOST: &str = "the results of its run are lost";

/// The simulations under way: what is lost or left behind if the program ends without them.
static UNDER_WAY: Mutex<Vec<&str>> = Mutex::new(Vec::new());

/// A simulation that checks the stop flag between its control periods, until this is dropped.
pub struct UnderWay(&'static str);

impl UnderWay {
    /// A simulation begins. `loss` is a clause about what is lost or left behind if its step does not end.
    #[must_use]
    pub fn begin(loss: &'static str) -> UnderWay {
        under_way().push(loss);
        UnderWay(loss)
    }
}

impl Drop for UnderWay {
    fn drop(&mut self) {
        let mut all = under_way();
        if let Some(place) = all.iter().position(|loss| *loss == self.0) {
            all.remove(place);
        }
    }
}

/// The user has interrupted the program: sets `stop`, and ends the program if a simulation goes on all the same. To be called in a thread
/// of its own, such as that of the signal handler.
pub fn requested(stop: &AtomicBool) {
    stop.store(true, Relaxed);
    for _ in 0..POLLS {
        if under_way().is_empty() {
            return;
        }
        sleep(POLL);
    }
    let mut losses = under_way().clone();
    losses.sort_unstable(); // equal ones side by side
    losses.dedup();
    if !losses.is_empty() {
        let (seconds, losses) = ((POLL * POLLS).as_secs_f64(), losses.join(", and "));
        log(format_args!(
            "error: interrupted: the control period under way did not end within {seconds} s, so {losses}"
        ));
        process::exit(Exit::Interrupted as i32);
    }
}

fn under_way() -> MutexGuard<'static, Vec<&'static str>> {
    UNDER_WAY.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}
