//! `vrcs completions` and `vrcs man`: what a shell and `man` need to know of the program, made from its own arguments.

use std::path::PathBuf;

use clap::CommandFactory;

use super::{Failure, files, talk};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  vrcs completions bash > ~/.local/share/bash-completion/completions/vrcs
  vrcs completions fish > ~/.config/fish/completions/vrcs.fish")]
pub(super) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  vrcs man ~/.local/share/man/man1 && man vrcs-rewrite")]
pub(super) struct Man {
    /// The folder for the pages: `vrcs.1`, and one for each command.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

pub(super) fn completions(arguments: &Completions) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut super::Arguments::command(),
        "vrcs",
        &mut script,
    );
    files::to_stdout(&script)
}

pub(super) fn man(arguments: &Man) -> Result<(), Failure> {
    let folder = &arguments.folder;
    std::fs::create_dir_all(folder).map_err(|error| files::unwritable(folder, &error))?;
    // a page for `help` would be named in `vrcs.1`, and there is none: `--help` says the same
    let program = super::Arguments::command().disable_help_subcommand(true);
    let mut pages = vec![(program.clone(), "vrcs.1".to_owned())];
    for command in program.get_subcommands().filter(|c| !c.is_hide_set()) {
        let name = format!("vrcs-{}", command.get_name());
        pages.push((
            command.clone().display_name(name.clone()),
            format!("{name}.1"),
        ));
    }
    for (command, file) in pages {
        let mut page = Vec::new();
        let path = folder.join(file);
        clap_mangen::Man::new(command)
            .render(&mut page)
            .map_err(|error| files::unwritable(&path, &error))?;
        files::prepare(&path, &page)?
            .appear()
            .map_err(|error| files::unwritable(&path, &error))?;
        talk::data(&path.display().to_string())?;
    }
    Ok(())
}
