//! Claims about single stages.

mod landing_plate;
mod stages;
mod wedged_feet;
