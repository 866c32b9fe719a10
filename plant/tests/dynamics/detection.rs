//! Which contact points may touch the ground within a step.

use crate::support::*;
use biped_plant::detect::touching;
use biped_plant::ground::GroundHeights;
use messages::scene::Law;

#[test]
fn every_point_is_listed_that_twice_its_speed_drives_into_the_ground() {
    let (mut listed, mut high_links) = (0, 0);
    for_each_case(6, 40, |rng, mut case| {
        let (model, mut free) = (&case.model, random_state(rng, &case.model).xdot);
        if rng.bool() {
            // a spin: the centre of mass of the base has hardly any speed
            let turns = model.world_aligned().max(3)..model.dofs().min(6);
            free.iter_mut().enumerate().for_each(|(i, rate)| *rate *= if turns.contains(&i) { 30.0 } else { 1e-3 });
        }
        let h = 10f64.powf(-3.0 + 2.0 * rng.f64());
        let lowest = model.contact_points.iter().map(|point| case.pose.height(point)).fold(f64::INFINITY, f64::min);
        case.pose.reference.z += 0.8 * rng.f64() - 0.1 - lowest;
        let mut touches = vec![];
        touching(model, &GroundHeights::plane(model), &case.pose, Law::Cone, h, &free, &mut touches);
        for (id, point) in model.contact_points.iter().enumerate() {
            let (arm, gap) = (case.pose.lowest(point), case.pose.height(point));
            let (now, after) = (case.pose.links[point.link].velocity, case.pose.twist(model, point.link, &free));
            let speed = now.at(&arm).norm().max(after.at(&arm).norm());
            let in_reach = point.moves && gap <= 2.0 * h * speed;
            assert_eq!(touches.iter().any(|touch| touch.id == id), in_reach, "point {id} at {gap} m, {h} s");
            listed += usize::from(in_reach);
            high_links += usize::from(gap > 3.0 * model.length);
        }
    });
    assert!(listed > 500 && high_links > 500, "{listed} points listed, {high_links} far above the ground");
}
