//! MuJoCo on the same robots: a script reads each of them as MJCF and steps it in C.

use super::points::Point;
use super::scenes::GrowthCurve;
use crate::chart::peers::scripts;
use crate::chart::watch::ChartProgress;
use messages::scene::Scene;
use sessions::export::mjcf;
use shared::exit::{Exit, Failure};
use shared::output::temporary_folder;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The engine's name.
pub const NAME: &str = "MuJoCo";

/// Points of a curve; none, with a message, if MuJoCo does not install.
///
/// # Errors
/// No Python, or a file that cannot be written.
pub fn points(curve: &GrowthCurve, scenes: &[(f64, Scene)], watch: &ChartProgress) -> Result<Vec<Point>, Failure> {
    let folder = temporary_folder("growth")?;
    let ended = measured(curve, scenes, &folder, watch);
    let _ = std::fs::remove_dir_all(&folder);
    ended
}

/// The same, with its files in `folder`.
fn measured(
    curve: &GrowthCurve,
    scenes: &[(f64, Scene)],
    folder: &Path,
    watch: &ChartProgress,
) -> Result<Vec<Point>, Failure> {
    let fault = |error: String| Failure::new(Exit::Fault, format!("--peers: {error}"));
    let mut files: Vec<PathBuf> = Vec::new();
    for (x, scene) in scenes {
        let file = folder.join(format!("growth-{}-{x}.xml", curve.name));
        std::fs::write(&file, mjcf(scene)?).map_err(|error| fault(error.to_string()))?;
        files.push(file);
    }
    let script = scripts::copy(folder, "growth.py")?;
    let output = Command::new("python3").arg(&script).args(&files).output();
    let output = output.map_err(|error| fault(format!("python3 does not start: {error}")))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        let last = errors.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
        return Err(fault(format!("{} failed ({}): {last}", script.display(), output.status)));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().filter(|line| line.contains("left out")).for_each(|line| watch.log(line));
    let times = text.lines().filter_map(|line| line.strip_prefix("us ")?.parse().ok());
    Ok(scenes.iter().zip(times).map(|((x, _), us)| Point { curve: curve.name, engine: NAME, x: *x, us }).collect())
}
