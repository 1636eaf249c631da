//! Builds the documentation site: collects generated and handwritten documents in a folder, and runs mdBook on it.
//!
//! The site contains `docs/`, `schemas/` and `vectors/` as in `generated/`. The relative links in these folders
//! therefore work, and each schema is available at the path in its address.

mod chapters;
mod gather;
mod links;
mod schemas;
mod sections;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use mdbook_driver::MDBook;
use mdbook_driver::config::Config;

use self::gather::Gathered;

/// The name of a file that marks a folder as a built site.
const MARK: &str = ".uavspec-site";

/// Build the documentation site
#[derive(Parser)]
struct Arguments {
    /// Folder of the repository
    #[arg(long)]
    repository: PathBuf,
    /// Folder for the site
    #[arg(long)]
    out: PathBuf,
    /// Open the site in a browser
    #[arg(long)]
    open: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(errors) => {
            for error in &errors {
                eprintln!("error: {error}");
            }
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Vec<String>> {
    let started = Instant::now();
    own(&arguments.out).map_err(|error| vec![error])?;
    let folder = tempfile::tempdir().map_err(|error| vec![format!("a temporary folder: {error}")])?;
    let gathered = gather::gather(&arguments.repository, folder.path())?;
    let built = build(folder.path(), &gathered, &arguments.out);
    // mdBook removes the mark as well, so mark the folder again.
    let marked = mark(&arguments.out);
    built.and(marked).map_err(|error| vec![error])?;
    let index = arguments.out.join("index.html");
    let time = started.elapsed().as_millis();
    eprintln!("docs: {} pages in {} ({time} ms)", gathered.count, index.display());
    if arguments.open {
        opener::open(&index).map_err(|error| vec![format!("{}: {error}", index.display())])?;
    }
    Ok(())
}

/// Checks that the folder is empty or contains a site, because mdBook deletes the folder's contents. Then marks the
/// folder.
fn own(output: &Path) -> Result<(), String> {
    let of_folder = |error: io::Error| format!("{}: {error}", output.display());
    fs::create_dir_all(output).map_err(of_folder)?;
    let is_empty = fs::read_dir(output).map_err(of_folder)?.next().is_none();
    if !is_empty && !output.join(MARK).is_file() {
        let folder = output.display();
        return Err(format!(
            "{folder} contains files other than a site\n  help: choose another folder with --out"
        ));
    }
    mark(output)
}

fn mark(output: &Path) -> Result<(), String> {
    fs::write(output.join(MARK), "").map_err(|error| format!("{}: {error}", output.display()))
}

/// Runs mdBook on the collected documents.
fn build(folder: &Path, gathered: &Gathered, output: &Path) -> Result<(), String> {
    let of_book = |error: &dyn std::fmt::Display| format!("mdBook: {error:#}");
    let unsearched = |page: &String| format!("\n[output.html.search.chapter.\"{page}\"]\nenable = false\n");
    let text: String = gathered.translated.iter().map(unsearched).collect();
    let text = include_str!("../book.toml").to_owned() + &text;
    let mut config: Config = text.parse().map_err(|error| of_book(&error))?;
    config.build.build_dir = std::path::absolute(output).map_err(|error| of_book(&error))?;
    let book = MDBook::load_with_config(folder, config).map_err(|error| of_book(&error))?;
    book.build().map_err(|error| of_book(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_a_folder_with_other_files() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(own(folder.path()), Ok(()), "empty");
        assert_eq!(own(folder.path()), Ok(()), "its own");
        fs::remove_file(folder.path().join(MARK)).expect("the mark");
        fs::write(folder.path().join("flight.ulg"), "kept").expect("a file");
        assert!(own(folder.path()).is_err_and(|error| error.contains("other than a site")));
        assert!(folder.path().join("flight.ulg").is_file());
    }
}
