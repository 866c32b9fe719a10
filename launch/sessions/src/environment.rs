//! `biped session`: prints the environment variables that a program started by hand needs to join a running session.

use clap::{Args, ValueEnum};
use messages::peer_environment::PeerEnvironment;
use messages::session::Session;
use serde_json::{Map, Value, json};
use shared::args::{DEFAULT_PATIENCE, parse_within, single_named};
use shared::exit::{Failure, check_interrupt};
use shared::output::print_text;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Arguments of `biped session`.
#[derive(Args)]
pub struct EnvironmentArgs {
    /// Name of the session; by default the only named session that is running
    name: Option<String>,
    /// Output format of the environment variables
    #[arg(long, value_enum, default_value = "shell")]
    format: EnvironmentFormat,
    /// Time to wait for the session to start [s]
    #[arg(long, default_value_t = 0.0, value_name = "SECONDS", requires = "name", value_parser = wait)]
    wait: f64,
}

/// Output format of the environment variables.
#[derive(Clone, Copy, ValueEnum)]
enum EnvironmentFormat {
    /// For a shell: eval "$(biped session NAME)"
    Shell,
    /// As one JSON object of strings
    Json,
    /// As an entry of .vscode/launch.json that debugs the open Python file
    Vscode,
}

fn wait(text: &str) -> Result<f64, String> {
    parse_within(text, "a number of seconds", 0.0..=1e6)
}

/// Prints the environment.
///
/// # Errors
/// If there is no such session.
pub fn run(args: &EnvironmentArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let name = match &args.name {
        Some(name) => name.clone(),
        None => single_named(Session::running())?.name().into(),
    };
    let found = PeerEnvironment::attach(&name, Duration::from_secs_f64(args.wait), || !stop.load(Relaxed));
    check_interrupt(stop)?;
    // Our wait is for the session. The program that gets the environment has patience of its own.
    let variables = PeerEnvironment { patience: Duration::from_secs_f64(DEFAULT_PATIENCE), ..found? }.variables();
    let object = || variables.iter().map(|(key, value)| (key.to_string(), Value::from(value.as_str()))).collect();
    print_text(match args.format {
        EnvironmentFormat::Shell => {
            variables.iter().map(|(key, value)| format!("export {key}={}\n", quoted(value))).collect()
        }
        EnvironmentFormat::Json => pretty(&Value::Object(object())),
        EnvironmentFormat::Vscode => pretty(&launch_entry(&name, object())),
    });
    Ok(())
}

/// A word of a shell.
fn quoted(value: &str) -> String {
    format!("'{}'", value.replace('\'', r"'\''"))
}

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}

fn launch_entry(name: &str, environment: Map<String, Value>) -> Value {
    json!({
        "name": format!("biped: {name}"),
        "type": "debugpy",
        "request": "launch",
        "program": "${file}",
        "console": "integratedTerminal",
        "env": environment,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quoted_word_is_one_word_of_the_shell() {
        for value in ["plain", "two\nlines", "it's \"so\" $HOME `x`", ""] {
            let echo = std::process::Command::new("sh").args(["-c", &format!("printf %s {}", quoted(value))]).output();
            assert_eq!(String::from_utf8(echo.expect("a shell").stdout).as_deref(), Ok(value));
        }
    }
}
