//! Pins the measuring thread to one core.

use nix::sched::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use nix::unistd::Pid;

/// Keeps the thread that creates it on one core until it is dropped, if the system allows this.
pub struct Core(Option<(usize, CpuSet)>);

impl Core {
    /// Pins this thread to the core that it runs on.
    pub fn hold() -> Core {
        let this = Pid::from_raw(0);
        let held = || -> nix::Result<(usize, CpuSet)> {
            let (before, number) = (sched_getaffinity(this)?, sched_getcpu()?);
            let mut one = CpuSet::new();
            one.set(number)?;
            sched_setaffinity(this, &one)?;
            Ok((number, before))
        };
        Core(held().ok())
    }

    /// A sentence that says whether the thread was pinned.
    pub fn remark(&self) -> String {
        match self.0 {
            Some((number, _)) => format!("The thread that measures was held on core {number}."),
            None => "The system did not let the thread that measures be held on one core.".into(),
        }
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        if let Some((_, before)) = &self.0 {
            let _ = sched_setaffinity(Pid::from_raw(0), before);
        }
    }
}
