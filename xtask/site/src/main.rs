//! Builds the documentation site: gathers what is generated and what is written by hand into a folder, and has mdBook
//! make pages of it.
//!
//! The site holds `docs/`, `schemas/` and `vectors/` as they stand in `generated/`, so that their links to each other
//! hold, and so that the address of a schema is where the site has it.

mod chapters;
mod gather;
mod links;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use mdbook_driver::MDBook;
use mdbook_driver::config::Config;

/// Build the documentation site, which needs no server and no network.
#[derive(Parser)]
struct Arguments {
    /// The folder of the repository.
    #[arg(long)]
    repository: PathBuf,
    /// The folder of the site.
    #[arg(long)]
    output: PathBuf,
    /// Show the site when it is built.
    #[arg(long)]
    open: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(mistakes) => {
            for mistake in &mistakes {
                eprintln!("error: {mistake}");
            }
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Vec<String>> {
    let started = Instant::now();
    let gathered = arguments.output.with_extension("source");
    let pages = gather::gather(&arguments.repository, &gathered)?;
    build(&gathered, &arguments.output).map_err(|mistake| vec![mistake])?;
    let index = arguments.output.join("index.html");
    eprintln!("docs: {pages} pages in {} ({} ms)", index.display(), started.elapsed().as_millis());
    if arguments.open {
        opener::open(&index).map_err(|error| vec![format!("{}: {error}", index.display())])?;
    }
    Ok(())
}

fn build(gathered: &Path, output: &Path) -> Result<(), String> {
    let of_book = |error: &dyn std::fmt::Display| format!("mdBook: {error}");
    let mut config: Config = include_str!("../book.toml").parse().map_err(|error| of_book(&error))?;
    config.build.build_dir = std::path::absolute(output).map_err(|error| of_book(&error))?;
    let book = MDBook::load_with_config(gathered, config).map_err(|error| of_book(&error))?;
    book.build().map_err(|error| of_book(&error))
}
