//! The report of a run: a folder with summary, trajectory, figures, and a page that contains all of them.

mod contact;
pub mod draw;
pub mod figure;
mod lateral;
mod loads;
mod phase_portrait;
pub mod plot;
mod snapshots;
mod timing;
mod torques;
mod trajectory;

use crate::analysis::RunAnalysis;
use crate::summary::Summary;
use crate::trajectory_csv;
use crate::view::frame;
use crate::view::page::ViewPage;
use figure::Figure;
use messages::scene::Scene;
use shared::exit::Failure;
use shared::output::{MARK, prepare_folder, remove_own_figures, write_atomically};
use std::path::Path;
use std::{fs, io};

/// All figures that apply to the run, in the order of the page. Empty without records.
pub fn figures(analysis: &RunAnalysis) -> Vec<Figure> {
    if analysis.rows.is_empty() {
        return Vec::new();
    }
    let figures = [
        snapshots::figure(analysis),
        Some(trajectory::figure(analysis)),
        lateral::figure(analysis),
        phase_portrait::figure(analysis),
        torques::figure(analysis),
        Some(loads::figure(analysis)),
        Some(contact::figure(analysis)),
        Some(timing::figure(analysis)),
    ];
    figures.into_iter().flatten().collect()
}

/// First line of `scene.toml`.
const SCENE_HEADER: &str = "# this scene as `biped run` had it\n";

/// Names and first bytes of the files. An existing file is replaced only if it begins with these bytes.
const FILES: [(&str, &str); 4] = [
    ("summary.json", "{\n  \"scene\":"),
    ("trajectory.csv", "# World frame"),
    ("report.html", MARK),
    ("scene.toml", SCENE_HEADER),
];

/// Creates the folder before the run starts.
///
/// # Errors
/// If the folder cannot be created, or contains a file of the same name that this program did not write.
pub fn prepare(path: &Path) -> Result<(), Failure> {
    prepare_folder(path, &FILES)
}

/// Writes [`FILES`] and `figures/*.svg` into the folder and creates it if necessary. Each file is written completely or
/// not at all. `text` is the scene as TOML.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, analysis: &RunAnalysis, summary: &Summary, scene: &Scene, text: &str) -> io::Result<()> {
    let figures = figures(analysis);
    let drawings = folder.join("figures");
    fs::create_dir_all(&drawings)?;
    remove_own_figures(&drawings)?; // an earlier run may have had other figures
    write_atomically(&folder.join("summary.json"), &summary.json())?;
    write_atomically(&folder.join("trajectory.csv"), &trajectory_csv::table(analysis))?;
    write_atomically(&folder.join("report.html"), &page(&figures, analysis, summary, scene, text))?;
    write_atomically(&folder.join("scene.toml"), &format!("{SCENE_HEADER}{text}"))?;
    for panel in figures.iter().flat_map(|figure| &figure.panels) {
        write_atomically(&drawings.join(panel.name).with_extension("svg"), &panel.svg)?;
    }
    Ok(())
}

/// The page: the run in 3-D, the summary, and all figures.
pub fn page(figures: &[Figure], analysis: &RunAnalysis, summary: &Summary, scene: &Scene, text: &str) -> String {
    let rows = summary.lines().into_iter().map(|(name, value)| {
        let class = match name {
            "outcome" if summary.fell || summary.cut_short_by.is_some() => " class=\"bad\"",
            "outcome" => " class=\"good\"",
            _ => "",
        };
        format!("<tr><td>{name}</td><td{class}>{}</td></tr>\n", plot::escaped(&value))
    });
    let table = format!("<section>\n<table class=\"facts\">\n{}</table>\n</section>\n", rows.collect::<String>());
    let drawings = figures.iter().map(|figure| {
        let panels: String = figure.panels.iter().map(|panel| themed_svg(&panel.svg)).collect();
        format!(
            "<figure>\n<h2>{}</h2>\n<figcaption>{}</figcaption>\n<div>{panels}</div>\n</figure>\n",
            figure.title, figure.caption
        )
    });
    ViewPage {
        title: &format!("biped: {}", summary.scene),
        description: &scene.description,
        run_info: &frame::run_info(&analysis.robot, scene),
        trajectory: &frame::trajectory(analysis),
        below: &[table, drawings.collect(), SOURCE.into()].concat(),
        scene: text,
    }
    .html()
}

/// Source of the figures.
const SOURCE: &str = "<p class=\"lead\">Figures 6 to 9 are drawn after Y. Fujimoto and A. Kawamura, \"Three Dimensional Digital \
    Simulation and Autonomous Walking Control for Eight-Axis Biped Robot\", 1995.</p>\n";

/// A figure for embedding in a page: its colours follow the light or dark theme of the page.
pub fn themed_svg(svg: &str) -> String {
    svg.replace("#1F2328", "currentColor").replace("#E1E5EA", "var(--grid)").replace("#FFFFFF", "var(--card)")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::synthetic::SyntheticWalk;
    use std::time::Duration;

    fn report(scene: &Scene, seconds: u64) -> (Vec<Figure>, String) {
        let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(scene));
        for seq in 0..1000 * seconds {
            analysis.push(&walk.truth(seq, seq as f64 * 1e-3));
        }
        let summary = Summary::new("<walk>", &analysis, Duration::from_secs(1), 2);
        let figures = figures(&analysis);
        let scene = Scene { description: "fourteen & more".into(), ..scene.clone() };
        let page = page(&figures, &analysis, &summary, &scene, "note = \"{{figures}}\"");
        (figures, page)
    }

    #[test]
    fn the_page_is_complete_and_fetches_nothing() {
        let (figures, page) = report(&Scene::default(), 14);
        assert_eq!(figures.len(), 8);
        assert!(page.len() < 5_000_000, "{} bytes", page.len());
        let (page, scripts) = page.split_once("<script").unwrap();
        assert_eq!(scripts.matches("</script>").count(), 4, "no data or library closes its script element");
        assert_eq!(page.matches("<svg").count(), figures.iter().map(|figure| figure.panels.len()).sum::<usize>());
        assert!(page.contains("&lt;walk&gt;") && page.contains("fourteen &amp; more"));
        assert!(page.contains("Digital Simulation and Autonomous Walking Control for Eight-Axis Biped Robot\", 1995."));
        assert_eq!(page.matches("{{").count(), 1, "the scene's own braces stay, all placeholders are replaced");
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!["http:", "https:", "src=", "href=", "url("].iter().any(|fetch| outside.contains(fetch)));
        assert!(!page.contains("NaN") && !page.contains("inf"));
    }

    #[test]
    fn a_robot_without_legs_gets_only_the_figures_that_apply() {
        let mut scene = Scene::default();
        scene.bodies.retain(|body| body.name == messages::robot::TRUNK);
        let (figures, _) = report(&scene, 1);
        let titles: Vec<_> = figures.iter().map(|figure| figure.title).collect();
        assert_eq!(titles.len(), 5, "{titles:?}");
        assert!(super::figures(&RunAnalysis::new(&scene)).is_empty());
    }

    #[test]
    fn the_folder_is_complete_and_has_no_temporary_files() {
        let folder = std::env::temp_dir().join(format!("biped-report-{}", std::process::id()));
        let mut analysis = RunAnalysis::new(&Scene::default());
        analysis.push(&SyntheticWalk::new(0.0).truth(0, 0.0));
        let summary = Summary::new("stand", &analysis, Duration::from_secs(1), 1);
        write(&folder, &analysis, &summary, &Scene::default(), "").unwrap();
        let names = |folder: &Path| -> Vec<String> {
            let mut names: Vec<_> =
                fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        };
        assert_eq!(names(&folder), ["figures", "report.html", "scene.toml", "summary.json", "trajectory.csv"]);
        assert!(names(&folder.join("figures")).iter().all(|name| name.ends_with(".svg")));
        fs::remove_dir_all(&folder).unwrap();
    }
}
