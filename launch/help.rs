//! `biped --help`: the commands, grouped by purpose.

use clap::{Command, CommandFactory};

/// Headings, and the commands below each. A test checks that every visible command is in exactly one group.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Run", &["run", "list", "model"]),
    ("Look at a run", &["view", "top", "info", "convert", "replay"]),
    ("Control a running session", &["pause", "resume", "step", "reset", "push", "set", "rearm"]),
    (
        "Use your own controller, plant or robot",
        &["new", "plant", "controller", "session", "wire", "conform", "export", "tunnel"],
    ),
    ("Measure", &["chart", "study", "sweep", "robustness", "latency", "faults", "soak", "contact"]),
    ("Check and clean the machine", &["doctor", "clean"]),
];

/// The command line with grouped help.
pub fn grouped<Cli: CommandFactory>() -> Command {
    let command = Cli::command();
    let width = command.get_subcommands().map(|known| known.get_name().len()).max().unwrap_or(0);
    let about = |name: &str| {
        let known = command.find_subcommand(name);
        known.and_then(Command::get_about).map_or(String::new(), ToString::to_string)
    };
    let line = |name: &&str| format!("  {name:<width$}  {}\n", about(name));
    let groups: String = GROUPS
        .iter()
        .map(|(heading, names)| format!("{heading}:\n{}\n", names.iter().map(line).collect::<String>()))
        .collect();
    let template =
        format!("{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n{{options}}{{after-help}}");
    with_negative_numbers(command.help_template(template))
}

/// The same command line, in which `-1` is a value and not an option. A value that must not be negative is then refused by its own rule.
fn with_negative_numbers(command: Command) -> Command {
    let command = command.mut_args(|arg| match arg.get_action().takes_values() && !arg.is_allow_hyphen_values_set() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    });
    command.mut_subcommands(with_negative_numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cli;

    #[test]
    fn every_visible_command_is_in_exactly_one_group() {
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let command = Cli::command();
        let mut known: Vec<&str> =
            command.get_subcommands().filter(|known| !known.is_hide_set()).map(Command::get_name).collect();
        grouped.sort_unstable();
        known.sort_unstable();
        assert_eq!(grouped, known);
    }
}
