//! The binary `bake`: parses the command line, runs one command, turns its end into an exit code.

mod cli;
mod commands;

use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory, Parser};
use cli::{Cli, Command};
use relume_bake::job::{self, Voice};
use relume_formats::error::in_plain_words;
use relume_formats::name::{one_line, plain_lines};
use relume_formats::near::what_there_is;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => {
            // Help and version: a reader that closes the pipe early has seen enough.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        Err(error) => return fail(&usage_line(&error), 2),
    };
    if let Err(error) = job::outlive_file_limits() {
        return fail(&format!("signals cannot be watched: {error}"), 1);
    }
    let voice = if cli.quiet {
        Voice::Quiet
    } else if cli.verbose {
        Voice::Verbose
    } else {
        Voice::Usual
    };
    job::speak(voice);
    let result = match &cli.command {
        Command::New(args) => commands::new(args),
        Command::Run(args) => commands::run(args),
        Command::Merge(args) => commands::merge(args),
        Command::Plan(args) => commands::plan(args),
        Command::Info(args) => commands::info(args),
        Command::Verify(args) => commands::verify(args),
        Command::Export(args) => commands::export(args),
        Command::Tables(args) => commands::tables(args),
        Command::Spheres(args) => commands::spheres(args),
        Command::Reference(args) => commands::reference(args),
        Command::Chart(args) => commands::chart(args),
        Command::Gallery(args) => commands::gallery(args),
        Command::Completions(args) => Ok(commands::completions(args)),
        Command::Man(args) => commands::man(args),
    };
    match result {
        // A closed pipe is the reader's choice, not a failure.
        Ok(text) => match if cli.quiet && cli.command.writes_files() { Ok(()) } else { print(&text) } {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => fail(&format!("standard output: {e}"), 1),
            _ => ExitCode::SUCCESS,
        },
        Err(error) => fail(&error.to_string(), error.exit_code()),
    }
}

/// Prints what a command has to say, whatever names it has in it.
fn print(text: &str) -> std::io::Result<()> {
    let mut output = std::io::stdout().lock();
    output.write_all(plain_lines(text).as_bytes())?;
    output.flush()
}

fn fail(message: &str, code: u8) -> ExitCode {
    job::say(&format!("error: {}", one_line(message)));
    ExitCode::from(code)
}

/// Which command was meant by one that there is not; clap itself sees only the nearest.
fn meant_command(error: &clap::Error) -> Option<String> {
    let given = error
        .get(ContextKind::InvalidSubcommand)
        .filter(|_| error.get(ContextKind::SuggestedSubcommand).is_none())?
        .to_string();
    let cli = Cli::command();
    let names: Vec<&str> = cli.get_subcommands().map(clap::Command::get_name).collect();
    Some(what_there_is(&given, &names))
}

/// What an option is that the command has not, but another one.
fn of_other_command(error: &clap::Error) -> Option<String> {
    let given = error.get(ContextKind::InvalidArg).filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    let given = given.to_string();
    let name = given.strip_prefix("--")?;
    let cli = Cli::command();
    let has = |command: &&clap::Command| command.get_arguments().any(|arg| arg.get_long() == Some(name));
    let own: Vec<String> =
        cli.get_subcommands().filter(has).map(|command| format!("`bake {}`", command.get_name())).collect();
    let of_scene = if name == "reflections" { "; for a bake the scene says it, in [render]" } else { "" };
    (!own.is_empty())
        .then(|| format!("{given} is an option of {}{of_scene} (see bake --help)", own.join(", ")))
}

/// clap's message on one line, without its own prefix and usage.
fn usage_line(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "no command is given, such as `bake run SCENE` (see bake --help)".to_owned();
    }
    if let Some(text) = of_other_command(error) {
        return text;
    }
    let text = error.to_string();
    let mut lines =
        text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more"));
    let first = lines.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    let rest: Vec<&str> = lines.filter(|l| !l.is_empty()).collect();
    let meant = meant_command(error).unwrap_or_default();
    format!("{}{meant} (see bake --help)", in_plain_words(&[&[first.as_str()], &rest[..]].concat().join(" ")))
}
