//! Findings as diagnostics of the protocol.

use std::collections::BTreeMap;
use std::path::PathBuf;

use lsp_types::{Code, Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Message};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;

use super::project::{Project, Root};
use super::snapshot::Snapshot;

/// The name of the program in diagnostics.
const SOURCE: &str = "uavspec";

/// The diagnostics of a project, by file. Contains only files that have diagnostics.
pub(super) fn of_project(project: &Project) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
    let mut found: BTreeMap<PathBuf, Vec<Diagnostic>> = BTreeMap::new();
    if let Some(snapshot) = project.snapshot() {
        let sources = &snapshot.loaded.sources;
        let in_same_file =
            |left: &Finding, right: &Finding| sources.source_of(left.span) == sources.source_of(right.span);
        for findings in snapshot.findings.chunk_by(in_same_file) {
            let id = sources.source_of(findings[0].span);
            let path = match (snapshot.path(id), &project.root) {
                (Some(path), _) => path,
                // A finding about the configuration.
                (None, Root::Config(file)) => file,
                (None, Root::Folder(_)) => continue,
            };
            let lines = snapshot.lines(id);
            let diagnostics = findings.iter().map(|finding| {
                diagnostic(snapshot, finding, lines.range(snapshot.offsets(id, finding.span)))
            });
            found.entry(path.to_path_buf()).or_default().extend(diagnostics);
        }
    }
    if let (Some(failure), Root::Config(file)) = (project.failure(), &project.root) {
        let text = failure.to_string();
        let message = text.strip_prefix("error: ").unwrap_or(&text).to_owned();
        found.entry(file.clone()).or_default().push(Diagnostic {
            severity: Some(DiagnosticSeverity::Error),
            source: Some(SOURCE.to_owned()),
            message: Message::String(message),
            ..Diagnostic::default()
        });
    }
    found
}

/// The diagnostic of a finding.
pub(super) fn diagnostic(snapshot: &Snapshot, finding: &Finding, range: lsp_types::Range) -> Diagnostic {
    let related = |(span, label): &(_, String)| {
        Some(DiagnosticRelatedInformation { location: snapshot.location(*span)?, message: label.clone() })
    };
    let related: Vec<_> = finding.related.iter().filter_map(related).collect();
    let help = if finding.help.is_empty() { String::new() } else { format!("\n{}", finding.help) };
    Diagnostic {
        range,
        severity: Some(match finding.level {
            Level::Error => DiagnosticSeverity::Error,
            Level::Warning => DiagnosticSeverity::Warning,
            Level::Note => DiagnosticSeverity::Information,
        }),
        code: Some(Code::String(finding.rule.to_owned())),
        source: Some(SOURCE.to_owned()),
        message: Message::String(format!("{}{help}", finding.message)),
        related_information: Some(related).filter(|related| !related.is_empty()),
        ..Diagnostic::default()
    }
}
