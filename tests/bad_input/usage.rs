//! Options, values and combinations that no command takes.

use super::refused;

#[test]
fn wrong_usage_is_refused() {
    refused(&["fly"], &["fly"]);
    refused(&["run", "walk", "--patience", "0"], &["seconds"]);
    refused(&["run", "walk", "--in-process", "--realtime"], &["--in-process"]);
    refused(&["run", "walk", "--in-process", "--speed", "0.5"], &["--in-process", "--speed"]);
    refused(&["run", "walk", "--in-process", "--patience", "3"], &["--in-process", "--patience"]);
    for output in ["--table", "--csv", "--mcap"] {
        refused(&["convert", "a.mcap", output, "-"], &[output, "name a file, or ./-"]);
    }
    refused(&["run", "slide", "--smallest"], &["required", "--in-process"]);
    refused(
        &["run", "slide", "--smallest", "--in-process", "--full"],
        &["--smallest", "cannot be used with", "--full"],
    );
    refused(&["model", "missing.toml"], &["missing.toml", "walk-literal"]);
    refused(&["plant", "walk", "--session", "../x"], &["../x", "letters"]);
    refused(&["faults", "--only", "nosuch"], &["--only"]);
    refused(&["study", "problems", "--count", "0"], &["--count", "a whole number from 1 to 4294967296 is needed"]);
    refused(&["reset", "0"], &["[SEED]", "a whole number of 1 or more is needed"]);
    refused(&["study", "laws", "--count", "5"], &["--count works only with `study problems`"]);
    refused(&["study", "laws", "--phases", "5"], &["--phases works only with `study pushes`"]);
    refused(&["study", "pushes", "--offset", "1"], &["--offset must be at least 0 and less than 1"]);
    refused(&["study", "pushes", "--offset", "NaN"], &["--offset must be at least 0 and less than 1"]);
    refused(&["study", "pushes", "--directions", "up"], &["up", "forward"]);
    refused(&["study", "pushes", "--set", "controller.sped=1"], &["sped"]);
    for (setting, instead) in [
        ("duration=5", "every walk lasts until some time after its last push"),
        ("plant.push_time=1", "--phases and --offset"),
        ("plant.push_impulse.1=1", "--directions"),
        ("plant.push_duration=0.1", "every push lasts 0.05 s"),
        ("plant.push_body=right foot", "every push is of the base"),
        (" controller.speed = 0.4", "the robot walks and steps in place"),
        ("controller.gait=stand", "the robot walks and steps in place"),
        ("controller.stop_time=5", "every walk lasts"),
        ("controller={speed=0.4}", "the robot walks and steps in place"),
    ] {
        let (key, _) = setting.trim().split_once(['=', ' ']).expect("a setting");
        let key = key.trim_end_matches(".1");
        refused(&["study", "pushes", "--set", setting], &["`study pushes` sets", key, instead]);
    }
    refused(&["study", "pushes", "--count", "5"], &["--count works only with `study problems`"]);
    refused(&["view", "--session", "a", "--out", "b.html"], &["--out"]);
    refused(&["view", "a.mcap", "--listen", "0.0.0.0", "--out", "b.html"], &["--listen", "--out"]);
    refused(&["view", "a.mcap", "--port", "80", "--out", "b.html"], &["--port", "--out"]);
    let never = std::env::temp_dir().join(format!("biped-test-{}-never", std::process::id()));
    let out = never.display().to_string();
    refused(&["faults", "--only", "nosuch", "--out", &out], &["--only"]);
    refused(&["study", "laws", "--count", "5", "--out", &out], &["--count"]);
    assert!(!never.exists(), "a refused command creates no folder");
    refused(&["run", "slide", "--controller", "true"], &["slide has no controller"]);
    refused(&["run", "slide", "--swap", "0.1=true"], &["slide has no controller"]);
    refused(&["run", "walk", "--swap", "20=biped controller"], &["--swap 20", "the run ends at 14 s"]);
    refused(&["run", "walk", "--controller", ""], &["--controller"]);
    refused(&["soak", "--minutes", "-1"], &["a number of minutes"]);
    refused(&["chart", "--peers=nosuch.csv"], &["nosuch.csv"]);
    refused(&["view", "README.md", "--out", "./README.md"], &["README.md is the input file"]);
    refused(&["run", "walk", "--swap", "1e300=biped controller"], &["--swap 1e300: the run ends"]);
    refused(&["run", "walk", "--swap", "inf=biped controller"], &["a simulated time"]);
}
