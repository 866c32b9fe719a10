//! The header is made of the functions.

use cbindgen::{Builder, Config, DocumentationStyle, Language, Style};

#[test]
fn the_header_is_made_of_the_functions() {
    let mut config = Config { language: Language::C, style: Style::Type, cpp_compat: true, ..Config::default() };
    config.header = Some(
        "/* A controller's end of a session. Made by this crate's test `header`: do not edit.\n *\n * A result below zero \
         is an error, minus the exit code to end with; biped_last_error() says it in a sentence.\n */"
            .into(),
    );
    config.include_guard = Some("BIPED_CONTROLLER_H".into());
    config.no_includes = true;
    config.includes = vec!["biped.h".into()];
    config.documentation_style = DocumentationStyle::C99;
    config.tab_width = 4;
    for name in ["Controller", "Status", "Encoders", "Torques", "Telemetry"] {
        config.export.rename.insert(name.into(), format!("biped_{name}"));
    }
    let root = env!("CARGO_MANIFEST_DIR");
    let sources = ["lib.rs", "end.rs", "failure.rs"].map(|file| format!("{root}/src/{file}"));
    let builder = sources.iter().fold(Builder::new().with_config(config), |builder, file| builder.with_src(file));
    let mut made = vec![];
    builder.generate().expect("plain C").write(&mut made);
    let made = String::from_utf8(made).expect("text").replace("// # Safety\n", "");
    let path = format!("{root}/controller.h");
    if std::env::var_os("BIPED_MAKE").is_some() {
        std::fs::write(&path, &made).expect("our own file");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(made == found, "run: BIPED_MAKE=1 cargo test --release -p biped_c --test header");
}
