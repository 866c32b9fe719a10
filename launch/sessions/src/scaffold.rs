//! `biped new`: a controller, plant, comparison, scene or robot of one's own to begin from. All files come out of this program.

mod native;
mod python;
mod rust;
mod template;

pub use template::NewFile;

use crate::export::toml;
use clap::{Args, Subcommand};
use messages::load::{SCENES, load};
use messages::robot::canonical_biped;
use shared::exit::Failure;
use shared::output::{create_folder, print_text, write_atomically, write_failure};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use template::{Template, shell_word, usage};

/// Kind of file or folder to make.
#[derive(Subcommand)]
pub enum NewArgs {
    /// Make a folder with a controller in Python, Rust, C or C++
    Controller(ControllerArgs),
    /// Make a folder with MuJoCo as the plant, in Python
    Plant(PlantArgs),
    /// Make a folder with the scripts that run other simulators on the comparison scenes
    Peers(PeersArgs),
    /// Make a file with a scene to edit
    Scene(FileArgs),
    /// Make a file with a robot to edit
    Robot(FileArgs),
}

/// Arguments of `biped new controller`.
#[derive(Args)]
pub struct ControllerArgs {
    /// Folder to make
    folder: PathBuf,
    /// Controller to begin from; `walk` is there in Python, Rust and C
    #[arg(long, value_enum, default_value = "stand")]
    from: Template,
    #[command(flatten)]
    language: LanguageArgs,
    /// Clone of the repository of biped that has the Rust crates or the C library. Without it, the crates come from crates.io,
    /// and `make` asks for the library
    #[arg(long, value_name = "FOLDER", conflicts_with = "python")]
    tree: Option<PathBuf>,
}

/// The language of a controller.
#[derive(Args)]
#[group(multiple = false)]
struct LanguageArgs {
    /// In Python, the default
    #[arg(long)]
    python: bool,
    /// In Rust
    #[arg(long)]
    rust: bool,
    /// In C
    #[arg(long)]
    c: bool,
    /// In C++
    #[arg(long)]
    cpp: bool,
}

/// Arguments of `biped new plant`.
#[derive(Args)]
pub struct PlantArgs {
    /// Folder to make
    folder: PathBuf,
    /// With MuJoCo; this is the default and the only choice
    #[arg(long)]
    mujoco: bool,
}

/// Arguments of `biped new peers`.
#[derive(Args)]
pub struct PeersArgs {
    /// Folder to make
    folder: PathBuf,
}

/// Arguments of `biped new scene` and `biped new robot`.
#[derive(Args)]
pub struct FileArgs {
    /// File to make; without an extension, .toml is added
    file: PathBuf,
    /// Built-in scene (see `biped list`) or path of a TOML file to begin from
    #[arg(long, default_value = "walk")]
    from: String,
}

/// Makes it. `peers` are the files of `biped new peers`, for a folder with the name that it gets.
///
/// # Errors
/// Something that is there already, a scene that is refused, or a place that cannot be written.
pub fn run(args: &NewArgs, peers: impl Fn(&Path) -> Result<Vec<NewFile>, Failure>) -> Result<(), Failure> {
    check(args.place())?;
    match args {
        NewArgs::Controller(args) => {
            let (from, tree) = (args.from, args.tree.as_deref());
            let files = match args.language {
                LanguageArgs { rust: true, .. } => rust::controller(&args.folder, from, tree)?,
                LanguageArgs { c: true, .. } => native::c(&args.folder, from, tree)?,
                LanguageArgs { cpp: true, .. } => native::cpp(&args.folder, from, tree)?,
                _ if tree.is_some() => {
                    return Err(usage("--tree is for --rust, --c and --cpp: Python needs nothing from there"));
                }
                _ => python::controller(&args.folder, from)?,
            };
            write(&args.folder, &files)
        }
        NewArgs::Plant(args) => write(&args.folder, &python::plant(&args.folder)?),
        NewArgs::Peers(args) => write(&args.folder, &peers(&args.folder)?),
        NewArgs::Scene(args) => {
            let scene = load(&args.from, &[], SCENES)?;
            let path = file(&args.file, &messages::load::text(&scene))?;
            print_text(format!(
                "{}: run it with `biped run {}`; `biped list --keys` explains every key\n",
                path.display(),
                shell_word(&path)
            ));
            Ok(())
        }
        NewArgs::Robot(args) => {
            let scene = load(&args.from, &[], SCENES)?;
            let path = file(&args.file, &toml::text(&scene))?;
            let word = shell_word(&path);
            let command = match canonical_biped(&scene.bodies) {
                Ok(_) => format!("let it walk with `biped run walk --robot {word}`"),
                Err(_) => format!("a scene, because it is no biped that walks: run it with `biped run {word}`"),
            };
            print_text(format!("{}: {command}\n", path.display()));
            Ok(())
        }
    }
}

impl NewArgs {
    /// The file or folder to make.
    fn place(&self) -> &Path {
        match self {
            NewArgs::Controller(args) => &args.folder,
            NewArgs::Plant(args) => &args.folder,
            NewArgs::Peers(args) => &args.folder,
            NewArgs::Scene(args) | NewArgs::Robot(args) => &args.file,
        }
    }
}

/// Whether a file or folder can be made there, under a name that every shell, Makefile and manifest can hold.
fn check(place: &Path) -> Result<(), Failure> {
    if place.to_str().is_none_or(|text| text.contains(char::is_control)) {
        let words = "has a control character or a byte that is no text: choose a name of letters, digits and hyphens";
        return Err(usage(format!("{place:?} {words}")));
    }
    if place.file_name().is_none() {
        return Err(usage(format!("`{}` names no new file or folder: add a name to it", place.display())));
    }
    match place.parent().filter(|parent| !parent.as_os_str().is_empty() && !parent.is_dir()) {
        Some(parent) => {
            let words = "make it first, or choose a place in a folder that is there";
            Err(usage(format!("{}: there is no folder {}: {words}", place.display(), parent.display())))
        }
        None => Ok(()),
    }
}

/// Makes a folder with these files.
fn write(folder: &Path, files: &[NewFile]) -> Result<(), Failure> {
    fs::create_dir(folder).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => there(folder),
        _ => write_failure(folder, &error),
    })?;
    for (name, text) in files {
        let path = folder.join(name);
        create_folder(path.parent().unwrap_or(folder))?;
        write_atomically(&path, text).map_err(|error| write_failure(folder, &error))?;
    }
    print_text(format!("{}: README.md says how to run it\n", folder.display()));
    Ok(())
}

/// Writes a new file, and gives its name.
fn file(path: &Path, text: &str) -> Result<PathBuf, Failure> {
    let path = if path.extension().is_none() { path.with_extension("toml") } else { path.into() };
    if path.exists() {
        return Err(there(&path));
    }
    write_atomically(&path, text).map_err(|error| write_failure(&path, &error))?;
    Ok(path)
}

fn there(path: &Path) -> Failure {
    usage(format!("{} is there already: choose another name, or remove it", path.display()))
}
