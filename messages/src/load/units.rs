//! Doubts about the units of a robot's file: lengths in millimetres, masses in grams.

use crate::legible;
use crate::robot::Body;

/// No robot has longer legs [m]. A robot of 0.1 m and more whose lengths are in millimetres has.
const LONGEST_LEG: f64 = 100.0;
/// Density of lead [kg/m³]. A robot fills a small part of a cube whose sides are as long as its legs. If it is heavier than such a cube of
/// lead, its masses are not in kilograms or its lengths not in metres.
const LEAD: f64 = 11_340.0;

/// Sentences on lengths and masses that no legged robot has. The bodies are in canonical order.
pub(super) fn doubts(bodies: &[Body]) -> Vec<String> {
    let length =
        |body: &Body| body.joint.as_ref().map_or(0.0, |joint| joint.at.iter().map(|x| x * x).sum::<f64>().sqrt());
    let leg: f64 = bodies.iter().take(3).map(length).sum();
    let mass: f64 = bodies.iter().map(|body| body.mass).sum();
    let long = format!("the legs are {} m long: are the lengths in millimetres?", rounded(leg));
    let heavy = format!(
        "the robot weighs {} kg, more than a cube of lead as wide as its legs of {} m are long: are all masses in kg and all lengths in m?",
        rounded(mass),
        rounded(leg)
    );
    [(leg > LONGEST_LEG, long), (mass > LEAD * leg.powi(3), heavy)]
        .into_iter()
        .filter_map(|(is_doubtful, words)| is_doubtful.then_some(words))
        .collect()
}

/// A number with three digits.
fn rounded(number: f64) -> String {
    format!("{number:.2e}").parse().map_or_else(|_| number.to_string(), legible)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::table_1;

    #[test]
    fn millimetres_and_grams_are_doubted_and_robots_of_any_size_are_not() {
        for (length, mass, words) in [
            (1.0, 1.0, None),
            (50.0, 50f64.powi(3), None),
            (0.02, 0.02f64.powi(3), None),
            (1e3, 1.0, Some("the legs are 450 m long")),
            (1.0, 1e3, Some("the robot weighs 14000 kg, more than a cube of lead as wide as its legs of 0.45 m")),
        ] {
            let mut bodies = table_1();
            for body in &mut bodies {
                body.mass *= mass;
                body.joint.iter_mut().for_each(|joint| joint.at = joint.at.map(|x| length * x));
            }
            let doubts = doubts(&bodies);
            assert!(doubts.len() == usize::from(words.is_some()), "{doubts:?}");
            assert!(doubts.iter().zip(words).all(|(doubt, words)| doubt.starts_with(words)), "{doubts:?}");
        }
    }
}
