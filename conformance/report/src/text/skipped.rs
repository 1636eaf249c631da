//! The files that weren't checked, as text.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::Path;

use uavspec_capture::names::NOT_A_CAPTURE;
use uavspec_check::names;
use uavspec_model::text::thousands;

use crate::Unreadable;

/// The maximum number of failures to list.
const MAX_FAILURES: usize = 100;

/// The maximum number of file extensions to list.
const MAX_EXTENSIONS: usize = 8;

/// The paths that couldn't be read, with the reasons.
pub(super) fn failures(files: &[Unreadable]) -> Vec<String> {
    let listed = files.iter().take(MAX_FAILURES);
    let mut lines: Vec<String> = listed.map(|file| format!("{}: {}", file.path, file.message)).collect();
    if let Some(more) = files.len().checked_sub(MAX_FAILURES).filter(|more| *more > 0) {
        lines.push(format!("… and {} more; the JSON report lists all of them", thousands(more)));
    }
    lines
}

/// A line for each reason why files weren't checked. It contains the first files, the reason, and the number of files
/// with each extension.
pub(super) fn lines(files: &[Unreadable]) -> Vec<String> {
    let mut by_reason: Vec<(&str, Vec<&str>)> = Vec::new();
    for Unreadable { path, message } in files {
        match by_reason.iter_mut().find(|(reason, _)| reason == message) {
            Some((_, paths)) => paths.push(path),
            None => by_reason.push((message, vec![path])),
        }
    }
    let line = |(reason, paths): (&str, Vec<&str>)| {
        let is_by_extension = reason == NOT_A_CAPTURE && paths.len() > 1;
        let extensions = if is_by_extension { format!(": {}", extensions(&paths)) } else { String::new() };
        format!("{} ({reason}{extensions})", names(paths.iter().copied()))
    };
    by_reason.into_iter().map(line).collect()
}

/// The number of files with each extension, starting with the most frequent.
fn extensions(paths: &[&str]) -> String {
    let mut counts: BTreeMap<String, u64> = BTreeMap::new();
    for path in paths {
        let extension =
            Path::new(path).extension().map(|extension| format!(".{}", extension.to_string_lossy()));
        *counts.entry(extension.unwrap_or_else(|| "without extension".to_owned())).or_default() += 1;
    }
    let mut counts: Vec<(String, u64)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| Reverse(*count));
    let rest: u64 = counts.iter().skip(MAX_EXTENSIONS).map(|(_, count)| count).sum();
    let mut parts: Vec<String> = counts
        .iter()
        .take(MAX_EXTENSIONS)
        .map(|(extension, count)| format!("{} {extension}", thousands(count)))
        .collect();
    if rest > 0 {
        parts.push(format!("{} others", thousands(rest)));
    }
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: String, message: &str) -> Unreadable {
        Unreadable { path, message: message.to_owned() }
    }

    #[test]
    fn many_files_are_counted_by_kind() {
        let mut files: Vec<Unreadable> =
            (0..100_000).map(|number| file(format!("bags/{number}.db3"), NOT_A_CAPTURE)).collect();
        files.extend((0..20).map(|number| file(format!("{number}.x{number}"), NOT_A_CAPTURE)));
        files.push(file("Makefile".to_owned(), NOT_A_CAPTURE));
        files.push(file("pipe.json".to_owned(), "a named pipe"));
        let lines = lines(&files);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].starts_with("bags/0.db3, bags/1.db3"), "{}", lines[0]);
        assert!(lines[0].contains(" more ("), "{}", lines[0]);
        assert!(lines[0].contains("extension: 100,000 .db3, 1 .x0"), "{}", lines[0]);
        assert!(lines[0].ends_with(", 14 others)"), "{}", lines[0]);
        assert_eq!(lines[1], "pipe.json (a named pipe)");
    }

    #[test]
    fn failures_are_bounded() {
        let files: Vec<Unreadable> = (0..5_000).map(|number| file(format!("{number}.ulg"), "gone")).collect();
        let lines = failures(&files);
        assert_eq!((lines.len(), lines[0].as_str()), (101, "0.ulg: gone"));
        assert_eq!(lines[100], "… and 4,900 more; the JSON report lists all of them");
        assert_eq!(failures(&files[..100]).len(), 100);
    }
}
