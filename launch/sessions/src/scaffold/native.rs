//! A new controller in C or C++.

use super::template::{NewFile, Template, code, in_clone, shell_word, usage};
use controller::foreign;
use messages::describe;
use shared::exit::Failure;
use std::path::Path;

/// A language that is compiled against the C library.
struct Language {
    /// In words.
    name: &'static str,
    /// Its source file.
    source: &'static str,
    /// Variables of `make` for its compiler and its options, and the standard.
    make: [&'static str; 3],
    /// Debian's package with the compiler.
    package: &'static str,
    /// Headers of the library.
    headers: &'static [foreign::File],
}

const C: Language = Language {
    name: "C",
    source: "controller.c",
    make: ["CC", "CFLAGS", "c11"],
    package: "gcc",
    headers: &[foreign::C_HEADER],
};
const CPP: Language = Language {
    name: "C++",
    source: "controller.cpp",
    make: ["CXX", "CXXFLAGS", "c++17"],
    package: "g++",
    headers: &[foreign::C_HEADER, foreign::CPP_HEADER],
};

/// A controller in C.
pub fn c(folder: &Path, from: Template, tree: Option<&Path>) -> Result<Vec<NewFile>, Failure> {
    let (scene, text) = match from {
        Template::Stand => ("stand", foreign::C_STAND),
        Template::Walk => ("walk", foreign::C_WALK),
    };
    let head = "/* A controller for biped. README.md says how to build and run it. */\n";
    C.files(folder, scene, format!("{head}{}", code(text, "#include")), tree)
}

/// A controller in C++.
pub fn cpp(folder: &Path, from: Template, tree: Option<&Path>) -> Result<Vec<NewFile>, Failure> {
    if matches!(from, Template::Walk) {
        return Err(usage("--from walk is there in Python, Rust and C: in C++, call biped_plan as the walk in C does"));
    }
    let head = "// A controller for biped. README.md says how to build and run it.\n";
    CPP.files(folder, "stand", format!("{head}{}", code(foreign::CPP_STAND, "#include")), tree)
}

impl Language {
    fn files(&self, folder: &Path, scene: &str, code: String, tree: Option<&Path>) -> Result<Vec<NewFile>, Failure> {
        let library = match tree {
            Some(tree) => {
                in_clone(tree, "controller/foreign/c/Cargo.toml")?.join("target/release").display().to_string()
            }
            None => String::new(),
        };
        let texts = [
            (self.source, code),
            ("biped.h", describe::c_header()),
            ("Makefile", self.makefile(&library)),
            ("README.md", self.readme(folder, scene, &library)),
        ];
        let headers = self.headers.iter().map(|(name, text)| (*name, text.to_string()));
        Ok(texts.into_iter().chain(headers).collect())
    }

    /// Rules that name what is missing in one sentence.
    fn makefile(&self, library: &str) -> String {
        let [compiler, options, standard] = self.make;
        let Language { name, source, package, .. } = self;
        format!(
            "# The folder with libbiped_c.so. `cargo build --release -p biped-c` in a clone of biped puts it into target/release.\n\
             BIPED_LIB ?= {library}\n{options} ?= -O2 -Wall -Wextra\n\n\
             controller: {source} $(wildcard *.h *.hpp) | needed\n\
             \t$({compiler}) -std={standard} $({options}) {source} -o controller -L\"$(BIPED_LIB)\" -lbiped_c -lm \
             -Wl,-rpath,\"$$(realpath \"$(BIPED_LIB)\")\"\n\n\
             test: controller\n\tbiped conform --controller ./controller\n\n\
             needed:\n\
             \t@test -e \"$(BIPED_LIB)/libbiped_c.so\" || {{ echo \"error: there is no libbiped_c.so in BIPED_LIB='$(BIPED_LIB)': run \
             cargo build --release -p biped-c in a clone of biped, then make BIPED_LIB=CLONE/target/release here\" >&2; exit 2; }}\n\
             \t@command -v $({compiler}) >/dev/null || {{ echo \"error: there is no {name} compiler '$({compiler})': install \
             {package}\" >&2; exit 2; }}\n\n\
             .PHONY: test needed\n"
        )
    }

    /// The commands for this folder, with a library that the makefile knows or the reader names.
    fn readme(&self, folder: &Path, scene: &str, library: &str) -> String {
        let (program, folder) = (shell_word(&folder.join("controller")), shell_word(folder));
        let build = match library {
            "" => "BIPED_LIB=CLONE/target/release   # CLONE is a clone of biped, after cargo build --release -p biped-c there".into(),
            known => format!("  # with the library in {known}, after cargo build --release -p biped-c in that clone"),
        };
        format!(
            "# A controller for biped\n\n\
             make -C {folder} {build}\n\
             biped run {scene} --controller \"{program}\"   # started by biped\n\
             biped plant {scene} --session lab & BIPED_SESSION=lab {program}   # started by hand, for example in a debugger\n\
             make -C {folder} test                              # checks it against the rules of the wire; `biped` has to be in PATH\n"
        )
    }
}
