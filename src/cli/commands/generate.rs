//! `generate`: manual pages and completions of shells, made from the command line itself.

use clap_complete::Shell;
use clap_mangen::Man;

use crate::cli::args::{GenerateArgs, GenerateWhat, command_line};
use crate::cli::base::{Exit, Problem, print};

const PROGRAM: &str = "slo-rt";

/// Prints what is asked for to standard output.
pub(crate) fn run(args: &GenerateArgs) -> Result<(), Problem> {
    if let (Some(command), true) = (&args.command, args.what != GenerateWhat::Man) {
        let message = format!("completions are for all commands; `{command}` can't be chosen");
        return Err(Problem::new(Exit::Usage, message));
    }
    let text = match args.what {
        GenerateWhat::Man => manual(args.command.as_deref())?,
        GenerateWhat::Bash => completions(Shell::Bash),
        GenerateWhat::Elvish => completions(Shell::Elvish),
        GenerateWhat::Fish => completions(Shell::Fish),
        GenerateWhat::Powershell => completions(Shell::PowerShell),
        GenerateWhat::Zsh => completions(Shell::Zsh),
    };
    print(&text)
        .map_err(|error| Problem::new(Exit::Failed, format!("can't print the text: {error}")))
}

/// The manual page of the program, or of one of its commands.
fn manual(command: Option<&str>) -> Result<Vec<u8>, Problem> {
    let mut program = command_line();
    program.build();
    let page = match command {
        None => program,
        Some(name) => {
            let found = program.find_subcommand(name).cloned();
            // Its name is that of the page: `man slo-rt-merge`.
            let named = |found: clap::Command| {
                found.name(format!("{PROGRAM}-{name}")).version(env!("CARGO_PKG_VERSION"))
            };
            found.map(named).ok_or_else(|| {
                let names: Vec<_> =
                    program.get_subcommands().map(clap::Command::get_name).collect();
                Problem::new(Exit::Usage, format!("slo-rt has no command `{name}`"))
                    .with_help(format!("its commands: {}", names.join(", ")))
            })?
        }
    };
    let mut text = Vec::new();
    Man::new(page)
        .render(&mut text)
        .map_err(|error| Problem::new(Exit::Failed, format!("can't make the page: {error}")))?;
    Ok(text)
}

fn completions(shell: Shell) -> Vec<u8> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut command_line(), PROGRAM, &mut text);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page() {
        for command in command_line().get_subcommands() {
            let page = manual(Some(command.get_name())).unwrap();
            let page = String::from_utf8(page).unwrap();
            assert!(page.contains(&format!(".TH slo-rt-{} 1", command.get_name())), "{page}");
        }
        let page = String::from_utf8(manual(None).unwrap()).unwrap();
        assert!(page.contains(".TH slo-rt 1") && page.contains("Exit codes"), "{page}");
        assert!(page.contains(concat!("\"slo-rt ", env!("CARGO_PKG_VERSION"))), "{page}");
        assert_eq!(manual(Some("bakes")).unwrap_err().exit, Exit::Usage);
    }

    #[test]
    fn every_shell_completes_options_and_commands() {
        for shell in [Shell::Bash, Shell::Elvish, Shell::Fish, Shell::PowerShell, Shell::Zsh] {
            let text = String::from_utf8(completions(shell)).unwrap();
            for word in ["cost-map", "relight", "photon_map"] {
                assert!(text.contains(word), "{shell}: {word}");
            }
        }
    }
}
