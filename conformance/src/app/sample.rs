//! `uavspec sample`.

use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_model::text::{command_line, terminal};
use uavspec_rules::sample::story;
use uavspec_schema::Failure;

use super::new_files::{NewFiles, shown};
use super::{Exit, Status};

const EXAMPLES: &str = "Example:
  uavspec sample
  uavspec check flight.ulg
  uavspec explain flight.ulg

Nothing is written if one of the files exists.";

/// Arguments of `sample`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct SampleArgs {
    /// Folder for the files. It is created if necessary.
    #[arg(value_name = "FOLDER", default_value = ".")]
    folder: PathBuf,
}

/// Runs `uavspec sample`.
pub(super) fn run(args: &SampleArgs) -> Exit {
    sample(&args.folder).map_or_else(|failure| Err(Status::Usage.failed(&failure)), |()| Ok(Status::Conforms))
}

fn sample(folder: &Path) -> Result<(), Failure> {
    let sample = story::files()?;
    let mut files = NewFiles::default();
    for story::File { name, content, .. } in &sample {
        files.add(name, content.as_slice());
    }
    files.write(folder)?;
    for story::File { name, about, .. } in &sample {
        terminal::println!("wrote {}: {about}", shown(folder, Path::new(name)));
    }
    terminal::println!("\nNext:");
    if folder != Path::new(".") {
        terminal::println!("  {}", command_line(["cd", &terminal::path(folder)]));
    }
    for command in [
        "check flight.ulg",
        "explain flight.ulg",
        "explain flight.mcap --report html=flight.html",
        "check session.jsonl",
        "convert flight.ulg --to px4@1.16 -o converted.ulg",
    ] {
        terminal::println!("  uavspec {command}");
    }
    Ok(())
}
