//! `bake completions` and `bake man`: the command line as shells and `man` read it.

use crate::cli::{Cli, CompletionsArgs, ManArgs};
use clap::CommandFactory as _;
use relume_bake::error::Result;
use relume_bake::output::create_folder;
use relume_formats::{Error, Place};

/// `bake completions`.
pub fn completions(args: &CompletionsArgs) -> String {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "bake", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// `bake man`.
pub fn man(args: &ManArgs) -> Result<String> {
    create_folder(&args.output)?;
    clap_mangen::generate_to(Cli::command(), &args.output)
        .map_err(|e| Error::output(&Place::file(&args.output), e))?;
    Ok(format!("{}\n", args.output.join("bake.1").display()))
}
