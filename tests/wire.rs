//! Claims about the description of the wire format: header, Python module and tables match the declaration, and a C compiler confirms the
//! layout.

#![expect(clippy::expect_used, reason = "a test may panic")]

use messages::describe;
use std::process::Command;

fn read(path: &str) -> String {
    std::fs::read_to_string(path).expect("a file of this repository")
}

#[test]
fn the_header_and_the_tables_match_the_declaration() {
    let header = read("messages/include/biped.h");
    assert!(header == describe::c_header(), "run: biped wire c > messages/include/biped.h");
    let module = read("controller/foreign/python/wire.py");
    assert!(module == describe::python_module(), "run: biped wire python > controller/foreign/python/wire.py");
    let page = read("docs/WIRE.md");
    let tables = describe::markdown();
    assert!(page.ends_with(&tables), "replace the end of docs/WIRE.md by what `biped wire markdown` prints");
}

#[test]
fn c_and_python_have_the_same_message_layout() {
    let folder = std::env::temp_dir().join(format!("biped-wire-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (c, python) = (folder.join("layout.c"), folder.join("wire.py"));
    let header = std::path::absolute("messages/include/biped.h").expect("a path");
    std::fs::write(&c, format!("#include \"{}\"\n", header.display())).expect("a file");
    std::fs::write(&python, describe::python_module()).expect("a file");
    // both files assert sizes and offsets
    let compiler = Command::new("cc").args(["-std=c11", "-Wall", "-Werror", "-fsyntax-only"]).arg(&c).output();
    let compiler = compiler.expect("the C compiler that Rust links with");
    assert!(compiler.status.success(), "{}", String::from_utf8_lossy(&compiler.stderr));
    let wrong = describe::c_header().replacen("uint64_t run;", "uint64_t run[2];", 1);
    std::fs::write(&c, wrong).expect("a file");
    let refused = Command::new("cc").args(["-std=c11", "-fsyntax-only"]).arg(&c).output().expect("the compiler");
    assert!(!refused.status.success(), "negative case: a changed layout has to be refused");
    let python = Command::new("python3").arg(&python).output().expect("Python");
    assert!(python.status.success(), "{}", String::from_utf8_lossy(&python.stderr));
    std::fs::remove_dir_all(folder).expect("our own folder");
}
