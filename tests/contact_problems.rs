//! Contact problems of ten families, from standing to Painlevé's jams, are all solved: `biped study problems` in small.
//! Its seeds are fixed; the figures of the large one are in docs/DESIGN.md.

mod common;

use common::fresh_path;
use std::collections::HashMap;
use std::process::Command;

/// Problems of each family.
const EACH: f64 = 1000.0;

#[test]
fn every_contact_problem_is_solved_in_few_pivots() {
    let folder = fresh_path("problems");
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["study", "problems", "--count", "10000", "--quiet", "--out"])
        .arg(&folder)
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    println!("{}", String::from_utf8_lossy(&output.stdout));
    let text = std::fs::read_to_string(folder.join("problems.csv")).expect("a table");
    std::fs::remove_dir_all(folder).expect("our own folder");
    let cells = |line: &str| line.split(',').map(|cell| cell.trim_matches('"').to_string()).collect::<Vec<_>>();
    let mut lines = text.lines();
    let names = cells(lines.next().expect("a header"));
    let rows: Vec<HashMap<_, _>> = lines.map(|line| names.iter().cloned().zip(cells(line)).collect()).collect();
    assert_eq!(rows.len(), 2 * 10, "ten families under two laws");
    for row in &rows {
        let number = |name: &str| row[name].parse::<f64>().expect("a number");
        // An episode ends early when all has come to lie in the air, or blew up.
        assert!(number("problems") >= 0.8 * EACH, "{row:?}");
        assert_eq!(number("unsolved"), 0.0, "{row:?}");
        assert!(number("natural map") <= 1e-10, "{row:?}");
        assert_eq!(number("fallbacks"), 0.0, "{row:?}");
        assert!(number("p99.9 per pair") <= 4.0, "{row:?}"); // of the five that are allowed
        assert!(number("warm") > 0.2, "{row:?}");
    }
    let most = |name: &str| rows.iter().map(|row| row[name].parse::<f64>().expect("a number")).fold(0.0, f64::max);
    assert_eq!(most("rows"), 192.0, "64 corners with three rows each");
}
