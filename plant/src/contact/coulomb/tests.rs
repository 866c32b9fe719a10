//! Claims about single stages.

mod heavy_on_light;
mod landing_plate;
mod stages;
mod wedged_feet;
