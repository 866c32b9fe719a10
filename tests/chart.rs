//! Claims about `biped chart`: it draws every view, its table has the documented columns, and a bad argument is refused in one sentence.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::fresh_path;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const HEADER: &str = "view,scene,engine,method,dt,metric,error,cpu_s_per_sim_s,us_per_step";

fn chart(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["chart", "--quick", "--quiet"])
        .args(arguments)
        .arg("--out")
        .arg(folder)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// Charts two scenes. Returns the rows of the table without the columns of times, and the names of all files.
fn chart_two_scenes() -> (Vec<String>, Vec<String>) {
    let folder = fresh_path("chart");
    let output = chart(&["--scenes", "drop,rock"], &folder);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let table = std::fs::read_to_string(folder.join("chart.csv")).expect("a table");
    let page = std::fs::read_to_string(folder.join("chart.html")).expect("a page");
    assert_eq!(page.matches("<svg").count(), names.iter().filter(|name| name.ends_with(".svg")).count());
    assert!(!page.contains("{{") && !page.contains("NaN"), "a placeholder was not filled");
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!["http:", "https:", "src=", "url("].iter().any(|fetch| outside.contains(fetch)));
    std::fs::remove_dir_all(folder).expect("our own folder");
    let timeless = |line: &str| line.rsplitn(3, ',').last().expect("three commas").to_string();
    assert_eq!(table.lines().next(), Some(HEADER));
    (table.lines().skip(1).map(timeless).collect(), names)
}

#[test]
fn every_view_is_drawn_and_two_runs_measure_the_same_errors() {
    let (first, names) = chart_two_scenes();
    for name in ["chart.csv", "chart.html", "failures.svg", "precision-drop.svg", "precision-rock.svg", "step-walk.svg"]
    {
        assert!(names.iter().any(|known| known == name), "{name} is missing: {names:?}");
    }
    for view in ["precision,drop,", "precision,rock,", "step,walk,", "failure,drop,", "failure,zeno,", "model,base,"] {
        assert!(first.iter().any(|row| row.starts_with(view)), "no row of {view}");
    }
    for (law, method) in first.iter().filter_map(|row| row.split(',').nth(3)?.split_once('/')) {
        assert!(!law.is_empty() && !method.is_empty());
    }
    assert!(first.iter().any(|row| row.contains("μ* [-] exact")));
    let (second, _) = chart_two_scenes();
    let changed: Vec<_> = first.iter().zip(&second).filter(|(one, two)| one != two).take(3).collect();
    assert!(first.len() == second.len() && changed.is_empty(), "{changed:?}");
}

/// Under the default law the errors of turning and rolling decrease with the step. Under facets that are fixed in the world, the puck turns
/// freely at any step, which is the negative case.
#[test]
fn turning_and_rolling_errors_follow_the_order_of_the_method() {
    let folder = fresh_path("chart");
    let output = chart(&["--scenes", "turn,ball"], &folder);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = std::fs::read_to_string(folder.join("chart.csv")).expect("a table");
    std::fs::remove_dir_all(folder).expect("our own folder");
    let error = |scene: &str, method: &str, step: &str, metric: &str| -> f64 {
        let start = format!("precision,{scene},biped,{method},{step},{metric},");
        let row = table.lines().find_map(|line| line.strip_prefix(&start)).expect(&start);
        row.split(',').next().and_then(|error| error.parse().ok()).expect("a number")
    };
    for (scene, metric) in [("turn", "yaw"), ("turn", "way"), ("ball", "angle"), ("ball", "way")] {
        for method in ["Cone/SemiImplicitEuler", "Cone/MidpointMoreau", "Cone/Rk4Impact", "Aligned/MoreauJean"] {
            let [coarse, fine] = ["0.005", "0.001"].map(|step| error(scene, method, step, metric));
            // on the ball the error of the paper's step passes through zero near 3 ms; tests/known_answers has its order at finer steps
            let ratio = if (scene, method) == ("ball", "Cone/SemiImplicitEuler") { 0.5 } else { 0.3 };
            assert!(fine < ratio * coarse, "{scene} {method} {metric}: {coarse:e}, {fine:e}");
        }
        let fine = error(scene, "Cone/Rk4Impact", "0.001", metric);
        assert!(fine < 1e-8, "{scene} {metric}: {fine:e}");
    }
    let [coarse, fine] = ["0.005", "0.001"].map(|step| error("turn", "Facets(8)/MoreauJean", step, "yaw"));
    assert!(coarse > 0.15 && (coarse - fine).abs() < 1e-9, "{coarse} {fine}");
}

#[test]
fn growth_is_drawn_with_its_exponents_and_a_chain_of_64_links_costs_more_than_one_of_3() {
    let folder = fresh_path("growth");
    let output = chart(&["--growth"], &folder);
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && printed.contains("| exponent |"), "{}", String::from_utf8_lossy(&output.stderr));
    for curve in ["contacts", "links", "dt"] {
        let drawing = std::fs::read_to_string(folder.join(format!("growth-{curve}.svg"))).expect("a drawing");
        assert!(drawing.contains("this simulator ~ n^"), "{curve}");
    }
    let table = std::fs::read_to_string(folder.join("growth.csv")).expect("a table");
    let links = table.lines().filter_map(|line| line.strip_prefix("links,biped,")?.split_once(','));
    let times: Vec<f64> = links.map(|(_, us)| us.parse().expect("a time")).collect();
    assert!(times.len() == 4 && times[3] > 3.0 * times[0], "{table}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_bad_argument_is_refused_in_one_sentence() {
    let output = chart(&["--scenes", "slide,skate"], &fresh_path("chart"));
    let printed = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{printed}");
    assert!(printed.contains("`skate`") && printed.contains("slide30") && printed.lines().count() == 1, "{printed}");
    let output = chart(&["--growth", "--peers=peers.csv"], &fresh_path("chart"));
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && printed.contains("peers.csv"), "{printed}");
    let output = chart(&[], Path::new("/dev/null/chart"));
    let printed = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{printed}");
    assert!(printed.contains("/dev/null/chart cannot be written") && printed.lines().count() == 1, "{printed}");
}
