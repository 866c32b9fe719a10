//! Claims about single stages.

mod landing_plate;
mod stages;
