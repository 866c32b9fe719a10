//! The folder of a run: summary, trajectory, figures, and a page that holds all of it.

mod contact;
pub mod draw;
pub mod figure;
mod frames;
mod lateral;
mod loads;
pub mod plot;
mod portrait;
mod timing;
mod torques;
mod trajectory;

use crate::csv;
use crate::record::Recorder;
use crate::summary::Summary;
use crate::view::film;
use crate::view::page::Page;
use figure::Figure;
use messages::scene::Scene;
use shared::exit::{Exit, Failure};
use shared::output::{MARK, check_replaceable, create_folder, remove_own_figures, write_atomically};
use std::path::Path;
use std::{fs, io};

/// Every figure that applies to the run, in the order of the page; none without records.
pub fn figures(recorder: &Recorder) -> Vec<Figure> {
    if recorder.rows.is_empty() {
        return Vec::new();
    }
    let figures = [
        frames::figure(recorder),
        Some(trajectory::figure(recorder)),
        lateral::figure(recorder),
        portrait::figure(recorder),
        torques::figure(recorder),
        Some(loads::figure(recorder)),
        Some(contact::figure(recorder)),
        Some(timing::figure(recorder)),
    ];
    figures.into_iter().flatten().collect()
}

/// What the scene in the folder begins with.
const SCENE: &str = "# this scene as `biped run` had it\n";

/// What the folder gets, and how each begins.
const FILES: [(&str, &str); 4] = [
    ("summary.json", "{\n  \"scene\":"),
    ("trajectory.csv", "# World frame"),
    ("report.html", MARK),
    ("scene.toml", SCENE),
];

/// Makes the folder, unless somebody else's file is in the way, before the work and not after it.
///
/// # Errors
/// That.
pub fn prepare(path: &Path) -> Result<(), Failure> {
    create_folder(path)?;
    FILES.iter().try_for_each(|(name, head)| {
        let file = path.join(name);
        check_replaceable(&file, head.as_bytes())
            .map_err(|error| Failure::new(Exit::Usage, format!("{}: {error}", file.display())))
    })
}

/// Writes [`FILES`] and `figures/*.svg` into the folder, which it makes if need
/// be. A file is either written whole or not at all. `text` is the scene as the user would write it.
///
/// # Errors
/// As the file system has them, with the file's name.
pub fn write(folder: &Path, recorder: &Recorder, summary: &Summary, scene: &Scene, text: &str) -> io::Result<()> {
    let figures = figures(recorder);
    let drawings = folder.join("figures");
    fs::create_dir_all(&drawings)?;
    remove_own_figures(&drawings)?; // a run before may have had others
    write_atomically(&folder.join("summary.json"), &summary.json())?;
    write_atomically(&folder.join("trajectory.csv"), &csv::table(recorder))?;
    write_atomically(&folder.join("report.html"), &page(&figures, recorder, summary, scene, text))?;
    write_atomically(&folder.join("scene.toml"), &format!("{SCENE}{text}"))?;
    for panel in figures.iter().flat_map(|figure| &figure.panels) {
        write_atomically(&drawings.join(panel.name).with_extension("svg"), &panel.svg)?;
    }
    Ok(())
}

/// The page: the run in 3-D, its summary, and every figure.
pub fn page(figures: &[Figure], recorder: &Recorder, summary: &Summary, scene: &Scene, text: &str) -> String {
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
        let panels: String = figure.panels.iter().map(|panel| inline(&panel.svg)).collect();
        format!(
            "<figure>\n<h2>{}</h2>\n<figcaption>{}</figcaption>\n<div>{panels}</div>\n</figure>\n",
            figure.title, figure.caption
        )
    });
    Page {
        title: &format!("biped: {}", summary.scene),
        description: &scene.description,
        about: &film::about(&recorder.robot, scene),
        film: &film::film(recorder),
        below: &[table, drawings.collect(), SOURCE.into()].concat(),
        scene: text,
    }
    .html()
}

/// Whose figures these are.
const SOURCE: &str = "<p class=\"lead\">Figures 6 to 9 are drawn after Y. Fujimoto and A. Kawamura, \"Three Dimensional Digital \
    Simulation and Autonomous Walking Control for Eight-Axis Biped Robot\", 1995.</p>\n";

/// The drawing in the colours of the page, light or dark.
pub fn inline(svg: &str) -> String {
    svg.replace("#1F2328", "currentColor").replace("#E1E5EA", "var(--grid)").replace("#FFFFFF", "var(--card)")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::fake::FakeWalk;
    use std::time::Duration;

    fn report(scene: &Scene, seconds: u64) -> (Vec<Figure>, String) {
        let (fake, mut recorder) = (FakeWalk::new(0.06), Recorder::new(scene));
        for seq in 0..1000 * seconds {
            recorder.push(&fake.truth(seq, seq as f64 * 1e-3));
        }
        let summary = Summary::new("<walk>", &recorder, Duration::from_secs(1), 2);
        let figures = figures(&recorder);
        let scene = Scene { description: "fourteen & more".into(), ..scene.clone() };
        let page = page(&figures, &recorder, &summary, &scene, "note = \"{{figures}}\"");
        (figures, page)
    }

    #[test]
    fn the_page_holds_everything_and_fetches_nothing() {
        let (figures, page) = report(&Scene::default(), 14);
        assert_eq!(figures.len(), 8);
        assert!(page.len() < 5_000_000, "{} bytes", page.len());
        let (page, scripts) = page.split_once("<script").unwrap();
        assert_eq!(scripts.matches("</script>").count(), 4, "no data or library ends its script");
        assert_eq!(page.matches("<svg").count(), figures.iter().map(|figure| figure.panels.len()).sum::<usize>());
        assert!(page.contains("&lt;walk&gt;") && page.contains("fourteen &amp; more"));
        assert_eq!(page.matches("{{").count(), 1, "the scene's own braces stay, every place is filled");
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!["http:", "https:", "src=", "href=", "url("].iter().any(|fetch| outside.contains(fetch)));
        assert!(!page.contains("NaN") && !page.contains("inf"));
    }

    #[test]
    fn a_robot_that_cannot_walk_gets_the_figures_that_apply() {
        let mut scene = Scene::default();
        scene.bodies.retain(|body| body.name == messages::robot::TRUNK);
        let (figures, _) = report(&scene, 1);
        let titles: Vec<_> = figures.iter().map(|figure| figure.title).collect();
        assert_eq!(titles.len(), 5, "{titles:?}");
        assert!(super::figures(&Recorder::new(&scene)).is_empty());
    }

    #[test]
    fn the_folder_is_complete_and_without_drafts() {
        let folder = std::env::temp_dir().join(format!("biped-report-{}", std::process::id()));
        let mut recorder = Recorder::new(&Scene::default());
        recorder.push(&FakeWalk::new(0.0).truth(0, 0.0));
        let summary = Summary::new("stand", &recorder, Duration::from_secs(1), 1);
        write(&folder, &recorder, &summary, &Scene::default(), "").unwrap();
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
