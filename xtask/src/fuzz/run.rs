//! A run of a target, with the figures that libFuzzer prints.

use std::ffi::OsString;
use std::path::Path;

use super::Arguments;
use super::corpus::Corpus;
use super::program::Program;

/// The maximum duration of an execution, in seconds.
const MAX_EXECUTION: u64 = 10;

/// The maximum memory of a run, in MiB. libFuzzer and the definitions need less than a tenth.
const MAX_MEMORY: u64 = 1024;

/// The number of lines of output that are printed for an input that violates a property.
const SHOWN: usize = 40;

/// The maximum length of a printed line, in characters.
const MAX_LINE: usize = 400;

/// The head of the table of all runs.
pub(super) const HEAD: &str = "target             executions       per s       edges    features      inputs";

/// The executions of a run, the executions per second, and the edges, features and inputs at its end.
type Figures = [u64; 5];

/// The result of a run.
pub(super) struct Run {
    figures: Figures,
    /// The message about an input that violates a property.
    pub(super) failure: Option<String>,
}

impl Run {
    /// Runs a target.
    pub(super) fn new(
        program: &Program,
        target: &str,
        corpus: &Corpus,
        arguments: &Arguments,
    ) -> Result<Self, String> {
        let mut prefix = corpus.artifacts.clone().into_os_string();
        prefix.push("/");
        let options = [
            option("-max_total_time", arguments.seconds.to_string()),
            // If the seed is 0, libFuzzer chooses a random seed.
            option("-seed", arguments.seed.unwrap_or_default().to_string()),
            option("-timeout", MAX_EXECUTION.to_string()),
            option("-rss_limit_mb", MAX_MEMORY.to_string()),
            option("-artifact_prefix", prefix),
            option("-print_final_stats", "1"),
        ];
        // New inputs are written to the first folder.
        let folders = [&corpus.found, &corpus.committed].map(|folder| folder.clone().into_os_string());
        let output = program.run(target, options.into_iter().chain(folders))?;
        let log = String::from_utf8_lossy(&output.stderr);
        let failure = (!output.status.success()).then(|| failure(target, &log, &corpus.artifacts));
        Ok(Self { figures: figures(&log), failure })
    }

    /// The row of the table.
    pub(super) fn row(&self, target: &str) -> String {
        let [executions, others @ ..] = self.figures;
        let others = others.map(|figure| format!(" {figure:>11}"));
        format!("{target:<18} {executions:>10}{}", others.concat())
    }
}

fn option(name: &str, value: impl Into<OsString>) -> OsString {
    let mut option = OsString::from(name);
    option.push("=");
    option.push(value.into());
    option
}

/// The message about an input that violates a property.
fn failure(target: &str, log: &str, artifacts: &Path) -> String {
    let lines: Vec<&str> = log.lines().collect();
    let start =
        lines.iter().position(|line| line.contains("panicked at") || line.contains("ERROR: libFuzzer"));
    let shown = &lines[start.unwrap_or_default()..];
    let shown = shown.iter().take(SHOWN).map(|line| match line.char_indices().nth(MAX_LINE) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => (*line).to_owned(),
    });
    format!(
        "error: {target}: an input violates a property: see {}\n{}",
        artifacts.display(),
        shown.collect::<Vec<_>>().join("\n")
    )
}

/// Reads the figures at the end of the log, and the coverage in the last line of progress.
fn figures(log: &str) -> Figures {
    let stat = |name: &str| log.lines().rev().find_map(|line| line.strip_prefix(name)?.trim().parse().ok());
    let progress = log.lines().rev().find(|line| line.starts_with('#') && line.contains(" cov: "));
    let words: Vec<&str> = progress.unwrap_or_default().split_whitespace().collect();
    let figure = |name: &str| {
        let at = words.iter().position(|word| *word == name)?;
        words.get(at + 1)?.split('/').next()?.parse().ok()
    };
    [
        stat("stat::number_of_executed_units:"),
        stat("stat::average_exec_per_sec:"),
        figure("cov:"),
        figure("ft:"),
        figure("corp:"),
    ]
    .map(Option::unwrap_or_default)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_figures_of_libfuzzer() {
        let log = "#2\tINITED cov: 10 ft: 11 corp: 1/5b exec/s: 0 rss: 30Mb\n\
                   #524288\tDONE   cov: 1893 ft: 6021 corp: 411/12Kb lim: 4096 exec/s: 8738 rss: 110Mb\n\
                   Done 524288 runs in 60 second(s)\n\
                   stat::number_of_executed_units: 524288\n\
                   stat::average_exec_per_sec:     8738\n";
        assert_eq!(figures(log), [524_288, 8738, 1893, 6021, 411]);
        assert_eq!(figures(""), [0; 5]);
    }

    #[test]
    fn shows_the_message_of_a_violated_property() {
        let log = "INFO: Seed: 1\nthread '<unnamed>' panicked at src/a.rs:1:\nthe reason\n";
        let text = failure("ulog", log, Path::new("artifacts"));
        assert_eq!(
            text,
            "error: ulog: an input violates a property: see artifacts\n\
             thread '<unnamed>' panicked at src/a.rs:1:\nthe reason"
        );
        let text = failure("ulog", &format!("panicked at\n{}", "é".repeat(500)), Path::new("artifacts"));
        assert!(text.ends_with(&format!("panicked at\n{}…", "é".repeat(MAX_LINE))), "{text}");
    }
}
