//! `uavspec init`.

mod files;

use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_codegen::load::{FoundPackage, find_packages, package_name};
use uavspec_model::text::{command_line, terminal};
use uavspec_schema::Failure;
use uavspec_schema::msg::Dialect;

use self::files::RUNTIME;
use super::new_files::{NewFiles, shown};
use super::{Exit, Status};

const EXAMPLES: &str = "Examples:
  uavspec init                  for the definitions in the current folder
  uavspec init --rust wind      with a crate for the generated code

Nothing is written if one of the files exists.";

/// Arguments of `init`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct InitArgs {
    /// Folder of the workspace. It is created if necessary.
    #[arg(value_name = "FOLDER", default_value = ".")]
    folder: PathBuf,
    /// Add a Cargo workspace with a crate for the generated code.
    #[arg(long)]
    rust: bool,
    /// Generate only JSON Schemas.
    #[arg(long, conflicts_with = "rust")]
    schemas_only: bool,
}

/// Runs `uavspec init`.
pub(super) fn run(args: &InitArgs) -> Exit {
    init(args).map_or_else(|failure| Err(Status::Usage.failed(&failure)), |()| Ok(Status::Conforms))
}

fn init(args: &InitArgs) -> Result<(), Failure> {
    let folder = &args.folder;
    let found = if folder.is_dir() { find_packages(folder)? } else { Vec::new() };
    let files = files(args, &found);
    files.write(folder)?;
    report(args, &found, &files);
    Ok(())
}

/// The files of a workspace for the packages that were found, or for an example.
fn files(args: &InitArgs, found: &[FoundPackage]) -> NewFiles {
    let mut files = NewFiles::default();
    let example = || FoundPackage {
        name: package_name(&args.folder),
        dialect: Dialect::Px4,
        include: vec!["msg/*.msg".to_owned()],
    };
    if found.is_empty() {
        files.add_example();
        files.add_configuration(args.outputs(), &[example()]);
    } else {
        files.add_configuration(args.outputs(), found);
    }
    if args.rust {
        files.add_crate();
    }
    files
}

impl InitArgs {
    /// The lines of the configuration that specify the outputs.
    fn outputs(&self) -> &'static [&'static str] {
        match self {
            Self { rust: true, .. } => &[
                r#"rust = "messages/src/generated""#,
                r#"json_schema = "generated/schemas""#,
                r#"docs = "generated/docs""#,
            ],
            Self { schemas_only: true, .. } => &[r#"json_schema = "generated/schemas""#],
            _ => &[
                r#"json_schema = "generated/schemas""#,
                r#"docs = "generated/docs""#,
                r#"typescript = "generated/typescript""#,
                r#"python = "generated/python""#,
            ],
        }
    }
}

/// Prints the packages that were found, the new files, and the next commands.
fn report(args: &InitArgs, found: &[FoundPackage], files: &NewFiles) {
    for FoundPackage { name, dialect, include } in found {
        terminal::println!("found package {name} ({dialect}): {}", terminal::shown(&include.join(", ")));
    }
    let shown = |path: &Path| shown(&args.folder, path);
    let (copied, written): (Vec<&Path>, Vec<&Path>) =
        files.paths().partition(|path| path.starts_with(RUNTIME));
    for path in written {
        terminal::println!("wrote {}", shown(path));
    }
    if !copied.is_empty() {
        let count = copied.len();
        terminal::println!(
            "wrote {}: a copy of the crate that generated code requires ({count} files)",
            shown(Path::new(RUNTIME))
        );
    }
    terminal::println!("\nNext:");
    if args.folder != Path::new(".") {
        terminal::println!("  {}", command_line(["cd", &terminal::path(&args.folder)]));
    }
    terminal::println!("  uavspec codegen");
    if args.rust {
        terminal::println!("  cargo check");
    }
}
