//! A self-contained page: styles, scripts, libraries and data are inline, so it opens from disk without a network.

use crate::report::plot::escaped;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// Style sheet of every page that the program writes.
const STYLE: &str = include_str!("../../page/page.css");
/// Style sheet of the 3-D view.
const VIEW_STYLE: &str = concat!(include_str!("../../page/vendor/uplot.min.css"), include_str!("../../page/view.css"));
/// Third-party libraries; see `page/vendor/README.md`.
const LIBRARIES: &str = concat!(
    include_str!("../../page/vendor/three.min.js"),
    ";\n",
    include_str!("../../page/vendor/uplot.min.js"),
    ";\n"
);
/// The page's own scripts, in the order of their dependencies.
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

/// Script that restores the token after a reload.
const RELOAD: &str = include_str!("../../page/reload.js");

/// The page of a refusal. A tab that had the token before reloads with it.
pub fn refusal(why: &str) -> String {
    format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><title>biped</title>\n<p>{}</p>\n<script>{RELOAD}</script>\n",
        escaped(why)
    )
}

/// Content security policy: only the scripts above may run, and only their own server may be contacted.
pub fn policy() -> String {
    let scripts = [LIBRARIES, SCRIPTS, RELOAD]
        .map(|script| format!(" 'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(script))));
    format!(
        "default-src 'none'; script-src{}; style-src 'unsafe-inline'; img-src 'self' data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'",
        scripts.concat()
    )
}

/// Contents of the page.
pub struct ViewPage<'a> {
    /// Title.
    pub title: &'a str,
    /// Description of the scene.
    pub description: &'a str,
    /// Description of the run, see [`super::frame::run_info`].
    pub run_info: &'a Value,
    /// Frames in base 64.
    pub trajectory: &'a str,
    /// HTML below the 3-D view.
    pub below: &'a str,
    /// The scene as TOML.
    pub scene: &'a str,
}

impl ViewPage<'_> {
    /// The page as HTML.
    pub fn html(&self) -> String {
        // A scene may contain `</script>`, which would close the script element.
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

/// A page without the 3-D view. `article` is its HTML from below the heading on, with placeholders for `parts`.
pub fn article(title: &str, article: &str, parts: &[(&str, String)]) -> String {
    let parts = [("title", title.into()), ("style", STYLE.into()), ("article", fill(article, parts))];
    fill(include_str!("../../page/article.html"), &parts)
}

/// Replaces placeholders such as `{{title}}`. The inserted text is not searched for placeholders.
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
