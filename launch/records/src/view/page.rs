//! The page, complete in itself: styles, scripts, libraries and data inline, so that it opens from disk and fetches nothing.

use crate::report::plot::escaped;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// Looks of every page that the program writes.
pub const STYLE: &str = include_str!("../../page/page.css");
/// Looks of the 3-D view.
const VIEW_STYLE: &str = concat!(include_str!("../../page/vendor/uplot.min.css"), include_str!("../../page/view.css"));
/// Libraries that others keep; see `launch/page/vendor/README.md`.
const LIBRARIES: &str = concat!(
    include_str!("../../page/vendor/three.min.js"),
    ";\n",
    include_str!("../../page/vendor/uplot.min.js"),
    ";\n"
);
/// The page's own scripts, one after the other.
const SCRIPTS: &str = concat!(
    "\"use strict\";\n",
    include_str!("../../page/theme.js"),
    include_str!("../../page/trajectory.js"),
    include_str!("../../page/robot.js"),
    include_str!("../../page/markers.js"),
    include_str!("../../page/stage.js"),
    include_str!("../../page/plots.js"),
    include_str!("../../page/phase_portrait.js"),
    include_str!("../../page/player.js"),
    include_str!("../../page/live.js"),
    include_str!("../../page/drag.js"),
    include_str!("../../page/main.js"),
);

const RELOAD: &str = include_str!("../../page/reload.js");
/// A refusal as a page, from which a tab that was let in before finds back.
pub fn refusal(why: &str) -> String {
    format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><title>biped</title>\n<p>{}</p>\n<script>{RELOAD}</script>\n",
        escaped(why)
    )
}

/// What a page may do: run the scripts above and no others, and fetch from where it came from.
pub fn policy() -> String {
    let scripts = [LIBRARIES, SCRIPTS, RELOAD]
        .map(|script| format!(" 'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(script))));
    format!(
        "default-src 'none'; script-src{}; style-src 'unsafe-inline'; img-src 'self' data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'",
        scripts.concat()
    )
}

/// What the page has.
pub struct ViewPage<'a> {
    /// Its heading.
    pub title: &'a str,
    /// One sentence on the scene.
    pub description: &'a str,
    /// The robot, and how frames are laid out.
    pub run_info: &'a Value,
    /// Frames, in base 64.
    pub trajectory: &'a str,
    /// What is said of the run, as HTML.
    pub below: &'a str,
    /// The scene as its user would write it.
    pub scene: &'a str,
}

impl ViewPage<'_> {
    /// As HTML.
    pub fn html(&self) -> String {
        // Whatever a scene contains cannot end the script that it stands in.
        let run_info = self.run_info.to_string().replace('<', "\\u003c");
        let parts = [
            ("policy", policy()),
            ("title", escaped(self.title)),
            ("description", escaped(self.description)),
            ("style", [STYLE, VIEW_STYLE].concat()),
            ("run_info", run_info),
            ("trajectory", self.trajectory.into()),
            ("below", self.below.into()),
            ("scene", escaped(self.scene)),
            ("libraries", LIBRARIES.into()),
            ("scripts", SCRIPTS.into()),
        ];
        fill(include_str!("../../page/page.html"), &parts)
    }
}

/// Fills places such as `{{title}}` in; what is filled in is not searched for more.
pub fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut pieces = template.split("{{");
    let mut page = String::from(pieces.next().unwrap_or(""));
    for piece in pieces {
        let known =
            piece.split_once("}}").and_then(|(name, rest)| Some((parts.iter().find(|part| part.0 == name)?, rest)));
        match known {
            Some((part, rest)) => page.extend([&part.1, rest]),
            None => page.extend(["{{", piece]),
        }
    }
    page
}
