//! Builds the fuzz targets in `xtask/fuzz` and runs them.
//!
//! The targets are compiled with the stable compiler: coverage is a pass of LLVM, and the code contains no `unsafe`, so
//! no sanitizer is needed. Inputs are stored in two folders for each target: `xtask/fuzz/corpus` contains a small
//! selection, and `target/fuzz/corpus` contains everything that earlier runs found.

mod corpus;
mod program;
mod run;

use clap::Args;

use self::corpus::Corpus;
use self::program::Program;
use self::run::Run;
use crate::paths::repository;

/// Arguments of `fuzz`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Targets to run [default: all]
    #[arg(value_name = "TARGET")]
    targets: Vec<String>,
    /// Duration of each target's run, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
    seconds: u64,
    /// Seed of the random changes. With the same seed and inputs, a run makes the same changes [default: random]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    seed: Option<u32>,
    /// After each run, replace the inputs in xtask/fuzz/corpus with the smallest selection with the same coverage
    #[arg(long)]
    minimise: bool,
    /// List the targets
    #[arg(long)]
    list: bool,
}

/// Runs the targets. Returns false if an input violates a property.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let program = Program::build(repository())?;
    let known = program.targets()?;
    if arguments.list {
        println!("{}", known.join("\n"));
        return Ok(true);
    }
    if let Some(unknown) = arguments.targets.iter().find(|name| !known.contains(name)) {
        return Err(format!("unknown target `{unknown}`; list all targets with --list"));
    }
    let is_selected = |name: &&String| arguments.targets.is_empty() || arguments.targets.contains(name);
    println!("{}", run::HEAD);
    let mut is_ok = true;
    for target in known.iter().filter(is_selected) {
        let corpus = Corpus::of(repository(), target)?;
        program.write_seeds(target, &corpus.found)?;
        let run = Run::new(&program, target, &corpus, arguments)?;
        println!("{}", run.row(target));
        if let Some(failure) = run.failure {
            eprintln!("{failure}");
            is_ok = false;
        } else if arguments.minimise {
            corpus.minimise(&program, target)?;
        }
    }
    Ok(is_ok)
}
