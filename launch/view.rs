//! The page in 3-D: of a run that is over, in `report.html`; of one that goes on, from a server of our own.

pub mod film;
pub mod live;
pub mod page;
