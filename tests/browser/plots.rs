//! The plots of the page with their marks and labels, the text beside the view, and the keys.

use super::{open, report, report_of, screenshot};
use crate::chromium::Browser;
use crate::common::fresh_path;
use serde_json::{Value, json};

/// A point in the first plot, at a fraction of its width [px].
fn place(page: &mut Browser, across: f64) -> [f64; 2] {
    let place = format!(
        "(() => {{ const {{ left, top, width, height }} = plots.panels[0].plot.over.getBoundingClientRect(); \
         return [left + {across} * width, top + height / 2]; }})()"
    );
    serde_json::from_value(page.value(&place)).unwrap()
}

/// The times of the cursors of all plots.
fn heads(page: &mut Browser) -> Vec<f64> {
    let heads = "plots.panels.map(({ plot, head }) => plot.posToVal(new DOMMatrix(head.style.transform).e, 'x'))";
    serde_json::from_value(page.value(heads)).unwrap()
}

/// The time range of the first plot [s].
fn span(page: &mut Browser) -> [f64; 2] {
    serde_json::from_value(page.value("[plots.panels[0].plot.scales.x.min, plots.panels[0].plot.scales.x.max]"))
        .unwrap()
}

/// The labels of all axes. Asserts that no axis has two equal labels.
fn labels(page: &mut Browser) -> Vec<Vec<String>> {
    page.until("!player.isStale && new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
    let all = "plots.panels.flatMap(({ plot }) => plot.axes.map((axis) => axis._values.filter((label) => label !== null && label !== '')))";
    let all: Vec<Vec<String>> = serde_json::from_value(page.value(all)).unwrap();
    for labels in &all {
        let different: std::collections::HashSet<&String> = labels.iter().collect();
        assert!(different.len() == labels.len() && !labels.is_empty(), "{labels:?}");
    }
    all
}

#[test]
fn zooming_keeps_the_time_and_distinct_ticks_and_a_double_click_resets_only_the_zoom() {
    let (folder, address) = report(&[], &[]);
    let mut page = open(&address, 1280, 720);
    page.value("player.play(false), player.seek(5)");
    page.until("!player.isStale");
    let (whole, [from, to]) = (span(&mut page), [place(&mut page, 0.25), place(&mut page, 0.75)]);
    page.drag(&[from, [from[0] + 9.0, from[1]], to]);
    page.drop_at(to);
    page.until("plots.panels.every(({ plot }) => plot.scales.x.max < 12)");
    let is_now = |heads: &[f64], time: f64| heads.iter().all(|head| (head - time).abs() < 1e-3);
    let marked = heads(&mut page);
    assert!(page.number("player.time") == 5.0 && is_now(&marked, 5.0), "{marked:?}");
    labels(&mut page);
    screenshot(&mut page, "zoomed");

    // Zoomed into less than a frame away from the current time: neither the zoom nor the time moves.
    page.value("plots.panels.forEach(({ plot }) => plot.setScale('x', { min: 9.0001, max: 9.0002 }))");
    page.value("player.step(0)");
    labels(&mut page);
    let ([from, to], marked) = (span(&mut page), heads(&mut page));
    assert!(from > 8.9 && to < 9.1 && to - from < 0.011 && is_now(&marked, 5.0), "{from} {to} {marked:?}");
    screenshot(&mut page, "zoomed-far");
    // When the current time is visible and leaves the range, the plot scrolls with it.
    page.value("player.seek(9)");
    page.until("!player.isStale");
    page.value("player.seek(10)");
    page.until("!player.isStale");
    let [from, to] = span(&mut page);
    assert!(from < 10.0 && to > 10.0, "{from} {to}");

    // A click sets the time. A double click resets the zoom and does not change the playback.
    let middle = place(&mut page, 0.5);
    page.value("player.seek(5), player.play(true)");
    page.click(middle, 2);
    page.until(&format!(
        "plots.panels.every(({{ plot }}) => plot.scales.x.max - plot.scales.x.min > {})",
        whole[1] - whole[0] - 0.1
    ));
    assert_eq!(page.value("player.isPlaying && player.time > 4.9 && player.time < 7"), json!(true));
    page.value("player.play(false)");
    page.click(middle, 1);
    assert!((page.number("player.time") - (whole[0] + whole[1]) / 2.0).abs() < 0.1);

    // Each torque has the name of its joint, and enough space for it.
    let caption = "globalThis.caption = plots.panels[2].plot.root.closest('figure').querySelector('h3')";
    page.value(&format!("{caption}, 0"));
    let names = "[...caption.querySelectorAll('span')].map((key) => [key.title, key.textContent.split(' ')[0]])";
    let names: Vec<[String; 2]> = serde_json::from_value(page.value(names)).unwrap();
    let joints: Vec<String> = serde_json::from_value(page.value("runInfo.joints")).unwrap();
    assert!(names.iter().map(|[joint, _]| joint).eq(&joints), "{names:?}");
    let left = ["left ankle roll", "left ankle pitch", "left knee", "left hip"];
    let right = ["right hip", "right knee", "right ankle pitch", "right ankle roll"];
    assert_eq!(joints, [left, right].concat());
    assert!(names.iter().all(|[joint, name]| joint.ends_with(&format!(" {name}"))), "{names:?}");
    let room = "[...caption.querySelectorAll('span')].every((key) => { const [a, b] = [key, caption].map((part) => part.getBoundingClientRect()); \
                return a.right <= b.right + 6 && a.bottom <= b.bottom + 1; })";
    page.until("!player.isStale");
    for time in [3.0, 5.1, 7.2] {
        page.value(&format!("player.seek({time})"));
        page.until("!player.isStale");
        assert_eq!(page.value(room), json!(true), "at {time}");
    }
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

/// The parts of the phase portrait's trail that are not where its plot is: its size, and the dot at the current time.
fn trail_defects(page: &mut Browser) -> Value {
    page.value(
        "(() => { const { trail, plot, trajectory } = plots.portrait, [x, y] = trajectory.all(trajectory.row(player.time), 'lateral'); \
           const sizes = [trail.width - plot.over.clientWidth * devicePixelRatio, trail.height - plot.over.clientHeight * devicePixelRatio]; \
           const [left, top] = [plot.valToPos(x, 'x'), plot.valToPos(y, 'y')].map((place) => Math.round(place * devicePixelRatio)); \
           const dot = trail.getContext('2d').getImageData(left - 1, top - 1, 3, 3).data.filter((_, index) => index % 4 === 3); \
           return [...sizes.filter((size) => Math.abs(size) > 1), ...dot.filter((opacity) => opacity < 250)]; })()",
    )
}

#[test]
fn the_marks_and_the_trail_follow_the_size_and_the_ranges_of_their_plots() {
    let (folder, address) = report(&["duration=5"], &[]);
    let mut page = open(&address, 1280, 720);
    page.value("player.play(false), player.seek(4)");
    page.until("!player.isStale && !stage.isStale");
    let drawn = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))";
    for (width, height) in [(1280, 720), (1600, 1000), (390, 844), (1000, 700)] {
        page.resize(width, height);
        page.until(&format!("innerWidth === {width} && !player.isStale && !stage.isStale"));
        page.value(drawn);
        assert_eq!(trail_defects(&mut page), json!([]), "{width} x {height}");
        let marked = heads(&mut page);
        assert!(marked.iter().all(|head| (head - 4.0).abs() < 0.01), "{width} x {height}: {marked:?}");
    }
    page.value("plots.portrait.plot.setScale('x', { min: .0, max: .08 })");
    page.value(drawn);
    assert_eq!(trail_defects(&mut page), json!([]), "other ranges");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn text_does_not_cover_the_view_and_keys_jump_to_both_ends_and_open_the_help() {
    let (folder, address) = report(&["duration=2"], &[]);
    let mut page = open(&address, 1280, 720);
    for (width, height) in [(1280, 720), (390, 844)] {
        page.resize(width, height);
        page.until(&format!("innerWidth === {width} && !stage.isStale"));
        let overlap = "[...document.querySelectorAll('#facts, #cameras, #player')].some((part) => { \
             const [a, b] = [part, stage.renderer.domElement].map((part) => part.getBoundingClientRect()); \
             return a.top < b.bottom - 1 && b.top < a.bottom - 1 && a.left < b.right && b.left < a.right; })";
        assert_eq!(page.value(overlap), json!(false), "{width}");
    }
    page.value("player.play(false), player.seek(1)");
    page.press("End");
    assert_eq!(page.value("player.time === trajectory.end"), json!(true));
    page.press("Home");
    assert_eq!(page.value("player.time === trajectory.begin && !player.isPlaying"), json!(true));
    page.press("?");
    assert_eq!(page.value("byId('help').open && byId('help').textContent.includes('Home End')"), json!(true));
    page.press("End");
    assert_eq!(page.value("player.time === trajectory.begin"), json!(true), "while it is read, keys are its own");
    screenshot(&mut page, "help");
    page.press("Escape");
    page.until("!byId('help').open");
    assert_eq!(page.complaints, Vec::<String>::new());
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_fall_is_marked_at_its_time_and_only_if_there_was_one() {
    let (folder, address) = report(&["plant.push_impulse=[0,9,0]", "plant.push_time=4"], &[]);
    let summary: Value = serde_json::from_slice(&std::fs::read(folder.join("summary.json")).unwrap()).unwrap();
    let fall = summary["fall_time_s"].as_f64().unwrap();
    let mut page = open(&address, 1280, 720);
    assert!((0.0..0.006).contains(&(page.number("trajectory.fall") - fall)), "{fall}");
    let marks = "plots.panels.map(({ plot, fall }) => plot.posToVal(new DOMMatrix(fall.style.transform).e, 'x'))";
    let marks: Vec<f64> = serde_json::from_value(page.value(marks)).unwrap();
    assert!(marks.len() == 5 && marks.iter().all(|mark| (mark - fall).abs() < 0.01), "{marks:?}");
    assert!((page.number("Number(byId('falls').options[0].value)") - fall).abs() < 0.01);
    for (time, is_over) in [(fall - 0.1, false), (fall + 0.1, true)] {
        page.value(&format!("player.play(false), player.seek({time})"));
        page.until("!player.isStale && !stage.isStale");
        let words = page.value("byId('facts').textContent");
        assert_eq!(words.as_str().unwrap().starts_with(&format!("fell at {fall:.1}")), is_over, "{words}");
    }
    screenshot(&mut page, "fall");
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();

    let (folder, address) = report(&["duration=2"], &[]);
    let mut page = open(&address, 1280, 720);
    assert_eq!(
        page.value("trajectory.fall === undefined && plots.panels.every(({ fall }) => fall.hidden)"),
        json!(true)
    );
    assert_eq!(page.number("byId('falls').options.length"), 0.0);
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
}

/// A sliding cube. All of its names are HTML.
const HOSTILE: &str = "description = '</title></script><img src=x onerror=alert(1)><script>globalThis.isHurt = true</script>'\nduration = 0.5\n\
    [initial]\nvelocity = [1.0, 0.0, 0.0]\n[[bodies]]\nname = '<script>globalThis.isHurt = true</script>'\nmass = 1.0\n\
    size = [0.1, 0.1, 0.1]\ncontacts = [[0.05, 0.05, -0.05], [0.05, -0.05, -0.05], [-0.05, 0.0, -0.05]]\n\
    [[bodies]]\nname = '</script><img src=x onerror=alert(1)>'\nmass = 0.1\nsize = [0.1, 0.1, 0.1]\n\
    joint = { parent = '<script>globalThis.isHurt = true</script>', at = [0.0, 0.0, 0.1], axis = [0.0, 1.0, 0.0], stiffness = 10.0 }\n";

#[test]
fn a_scene_without_a_controller_has_its_own_plots_and_its_name_is_escaped() {
    let scene = fresh_path("<b>hostile<b>&.toml");
    std::fs::write(&scene, HOSTILE).unwrap();
    let (folder, address) = report_of(scene.to_str().unwrap(), &[], &[]);
    let mut page = open(&address, 1280, 720);
    page.value("player.play(false), player.seek(.2)");
    page.until("!player.isStale && !stage.isStale");
    let titles = page.value("[...document.querySelectorAll('#plots h3 b')].map((title) => title.textContent)");
    let own = [
        "Centre of gravity [m]",
        "Its velocity [m/s]",
        "Force of the ground [N]",
        "Contact residuals",
        "Joints [rad, m]",
    ];
    assert_eq!(titles, json!(own));
    assert!(page.value("byId('facts').textContent").as_str().unwrap().starts_with("no controller\n"));
    let weight = page.number("trajectory.get(trajectory.row(.4), 'ground', 2)");
    assert!((weight - 1.1 * 9.81).abs() < 2.0, "{weight} N carry 1.1 kg");
    labels(&mut page);
    screenshot(&mut page, "passive");

    assert_eq!(
        page.value("[typeof isHurt, document.querySelectorAll('img, header b').length]"),
        json!(["undefined", 0])
    );
    let shown =
        "[document.querySelector('.lead').textContent, runInfo.joints[0], document.querySelector('h1').textContent]";
    let description = HOSTILE.lines().next().unwrap().split('\'').nth(1).unwrap();
    let name = format!("biped: {}", scene.display());
    assert_eq!(page.value(shown), json!([description, "</script><img src=x onerror=alert(1)>", name]));
    // Even unescaped HTML could not execute, by the content security policy.
    page.value("document.body.append(Object.assign(document.createElement('script'), { textContent: 'globalThis.isHurt = true' }))");
    assert_eq!(page.value("typeof isHurt"), json!("undefined"));
    assert!(
        page.complaints.iter().all(|complaint| complaint.contains("Content Security Policy"))
            && page.complaints.len() == 1
    );
    drop(page);
    std::fs::remove_dir_all(folder).unwrap();
    std::fs::remove_file(scene).unwrap();
}
