//! How large the model of a run is.

use messages::scene::Scene;
use plant::PlantError;
use plant::contact::tangents;
use plant::model::Model;

/// What the model of a scene has, in words.
///
/// # Errors
/// If the scene cannot be simulated.
pub fn size(scene: &Scene) -> Result<String, PlantError> {
    let model = Model::new(scene)?;
    let base = format!("{:?}", model.base).to_lowercase();
    let (dofs, contacts) = (model.dofs(), model.corners.len());
    let directions = tangents(scene.plant.law).min(model.directions);
    Ok(format!("{base} base, {dofs} degrees of freedom, {contacts} contact points, friction along {directions}"))
}
