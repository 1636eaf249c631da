//! Tools for definitions that need no code generator. The linter reports definitions that are valid but misleading,
//! incomplete or inconsistent. [`mod@format`] formats definitions, [`release`] keeps the definitions of all releases,
//! [`report`] writes findings for other programs, and [`baseline`] reads and updates lists of known findings.
//!
//! Each rule has a file with its text, examples and check, and an entry in [`RULES`]. Parser warnings are rules as well
//! (`Check::Reader`), so users can configure their level, ignore them and fix them. Parser errors are always reported.
//!
//! A comment `# uavspec:ignore RULE reason` ignores a finding. The comment applies to its own line. If it is above a
//! declaration, it applies to that declaration as well. If the comment is in the description at the start of a file, it
//! applies to the whole file. Pages use HTML comments: `<!-- uavspec:ignore RULE reason -->`.
//!
//! ```
//! use uavspec_lint::{Settings, lint};
//! use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect};
//!
//! let mut sources = SourceMap::default();
//! let text = "# Wind\n\nuint64 timestamp  # [us] Time\nfloat32 speed  # Speed\n";
//! let id = sources.add("Wind.msg", text.into()).unwrap();
//! let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! let findings = lint(&sources, &packages, &[], &Settings::default());
//! assert_eq!(findings[0].rule, "unit-missing");
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod baseline;
mod fix;
pub mod format;
mod ignore;
mod prelude;
pub mod release;
pub mod report;
mod rule;
mod settings;
mod subject;
mod topics;

mod annotation_after_text;
mod annotation_near_miss;
mod blank_start;
mod command_parameters;
mod comment_continued;
mod comment_lost;
mod constant_comment_missing;
mod constant_without_enum;
mod conversion_undecided;
mod count_missing;
mod description_missing;
mod duplicate_topic;
mod enum_alias;
mod enum_of_bits;
mod enum_type;
mod event_argument_unused;
mod event_enum_differs;
mod event_mode_missing;
mod field_comment_missing;
mod frame_unknown;
mod header_end;
mod header_missing;
mod hint_invalid;
mod hint_unused;
mod leading_white_space;
mod not_portable;
mod parser_warnings;
mod px_fsf_01;
mod px_fsf_02;
mod quantity;
mod queue_length;
mod range_reversed;
mod repeated_white_space;
mod severity_bits;
mod timestamp_missing;
mod timestamp_type;
mod topic_default_absent;
mod topic_list_empty;
mod topic_redundant;
mod trailing_white_space;
mod unit_alias;
mod unit_missing;
mod unit_missing_integer;
mod unit_unlisted;
mod unknown_escape;
mod version_type;

use std::collections::BTreeSet;

use uavspec_dynamic::conversion;
use uavspec_schema::diagnostic::{Diagnostic, Level, has_errors};
pub use uavspec_schema::example::Example;
use uavspec_schema::finding::Finding;
use uavspec_schema::parallel::in_parts;
use uavspec_schema::read::{PackageInput, parse_all};
use uavspec_schema::resolve::{PackageSource, resolve, resolve_formats};
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::{Schema, translation};

pub use self::fix::{apply, edited};
pub use self::rule::{Check, Levels, Measured, Preset, Rule, Scope};
use self::rule::{Converted, Sink};
pub use self::settings::{Ignore, Settings};

/// All rules, sorted by id.
pub const RULES: &[&Rule] = &[
    &px_fsf_01::RULE,
    &px_fsf_02::RULE,
    &annotation_after_text::RULE,
    &annotation_near_miss::RULE,
    &parser_warnings::ANNOTATION_VALUE_TYPE,
    &blank_start::RULE,
    &command_parameters::RULE,
    &comment_continued::RULE,
    &comment_lost::RULE,
    &constant_comment_missing::RULE,
    &constant_without_enum::RULE,
    &conversion_undecided::RULE,
    &count_missing::RULE,
    &description_missing::RULE,
    &duplicate_topic::RULE,
    &enum_alias::RULE,
    &enum_of_bits::RULE,
    &parser_warnings::ENUM_ON_NON_INTEGER,
    &enum_type::RULE,
    &parser_warnings::ENUM_VALUE_OUT_OF_RANGE,
    &event_argument_unused::RULE,
    &parser_warnings::EVENT_BIT,
    &event_enum_differs::RULE,
    &parser_warnings::EVENT_ID,
    &event_mode_missing::RULE,
    &parser_warnings::EVENT_VERSION,
    &field_comment_missing::RULE,
    &frame_unknown::RULE,
    &header_end::RULE,
    &header_missing::RULE,
    &hint_invalid::RULE,
    &hint_unused::RULE,
    &ignore::INVALID,
    &parser_warnings::INVISIBLE_CHARACTER,
    &leading_white_space::RULE,
    &parser_warnings::MALFORMED_ANNOTATION,
    &parser_warnings::MESSAGE_NAME_STYLE,
    &parser_warnings::MISPLACED_ANNOTATION,
    &parser_warnings::MISSING_ABBREVIATION,
    &parser_warnings::MISSING_ANSWER,
    &parser_warnings::NAME_STYLE,
    &parser_warnings::NEAR_TYPE_TABLE,
    &not_portable::RULE,
    &parser_warnings::ONE_SIDED_ALTERNATIVE,
    &queue_length::RULE,
    &range_reversed::RULE,
    &repeated_white_space::RULE,
    &severity_bits::RULE,
    &timestamp_missing::RULE,
    &timestamp_type::RULE,
    &topic_default_absent::RULE,
    &topic_list_empty::RULE,
    &topic_redundant::RULE,
    &trailing_white_space::RULE,
    &parser_warnings::TRANSLATION_FUZZY,
    &parser_warnings::TRANSLATION_MISSING,
    &parser_warnings::TRANSLATION_STALE,
    &unit_alias::RULE,
    &unit_missing::RULE,
    &unit_missing_integer::RULE,
    &unit_unlisted::RULE,
    &parser_warnings::UNKNOWN_ANNOTATION,
    &parser_warnings::UNKNOWN_CONSTANT,
    &parser_warnings::UNKNOWN_ENUM,
    &unknown_escape::RULE,
    &parser_warnings::UNKNOWN_MEMBER,
    &parser_warnings::UNKNOWN_TRANSLATION,
    &parser_warnings::UNKNOWN_UNIT,
    &ignore::UNUSED,
    &version_type::RULE,
];

/// Finds a rule by its id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

/// Checks `packages` and their translation catalogues. The findings are sorted by location.
///
/// A source without a selected message is present only because other packages refer to it. For such a source, only
/// errors are reported.
pub fn lint(
    sources: &SourceMap,
    packages: &[PackageInput],
    catalogues: &[SourceId],
    settings: &Settings,
) -> Vec<Finding> {
    // Resolve without the hashes of messages and types, which no rule needs.
    resolve_and_lint(resolve_formats, sources, packages, catalogues, settings).1
}

/// Like [`lint`], but also returns the schema. The schema is incomplete if the definitions contain errors.
pub fn read_and_lint(
    sources: &SourceMap,
    packages: &[PackageInput],
    catalogues: &[SourceId],
    settings: &Settings,
) -> (Schema, Vec<Finding>) {
    resolve_and_lint(resolve, sources, packages, catalogues, settings)
}

fn resolve_and_lint(
    resolve: fn(&[PackageSource<'_>]) -> (Schema, Vec<Diagnostic>),
    sources: &SourceMap,
    packages: &[PackageInput],
    catalogues: &[SourceId],
    settings: &Settings,
) -> (Schema, Vec<Finding>) {
    let (parsed, mut diagnostics) = parse_all(sources, packages);
    let (schema, mut resolved) = resolve(&parsed);
    diagnostics.append(&mut resolved);
    // If a definition has errors, its translations would be reported as unknown.
    if !has_errors(&diagnostics) {
        diagnostics.append(&mut translation::resolve(sources, &schema, catalogues).1);
    }
    let linter = Linter { sources, schema: &schema, settings };
    let mut findings = linter.parser_findings(&diagnostics);
    linter.check(&parsed, &diagnostics, &mut findings);
    let mut selected = selected(sources, &schema, &parsed);
    selected.extend(catalogues);
    selected.extend(settings.conversions.iter().filter_map(|request| request.hints));
    findings.retain(|finding| {
        finding.level == Level::Error && rule(finding.rule).is_none()
            || selected.contains(&sources.source_of(finding.span))
    });
    ignore::apply(sources, &parsed, (RULES, settings), &selected, &mut findings);
    findings.sort_by(|left, right| {
        (left.span, left.rule, &left.message).cmp(&(right.span, right.rule, &right.message))
    });
    (schema, findings)
}

struct Linter<'s> {
    sources: &'s SourceMap,
    schema: &'s Schema,
    settings: &'s Settings,
}

impl Linter<'_> {
    /// The findings of the parser, with the configured levels.
    fn parser_findings(&self, diagnostics: &[Diagnostic]) -> Vec<Finding> {
        let mut findings = Vec::new();
        for diagnostic in diagnostics {
            let mut finding = Finding::from(diagnostic);
            if let Some(rule) = rule(finding.rule) {
                let Some(level) = self.settings.level(rule) else { continue };
                finding.level = level;
                if let Check::Reader(fix) = rule.check {
                    finding.fix = fix(diagnostic, self.sources);
                }
            }
            findings.push(finding);
        }
        findings
    }

    /// Adds the findings of the rules. Messages in files with errors are skipped, because these messages are
    /// incomplete.
    fn check(&self, parsed: &[PackageSource<'_>], diagnostics: &[Diagnostic], findings: &mut Vec<Finding>) {
        let invalid: BTreeSet<SourceId> = diagnostics
            .iter()
            .filter(|diagnostic| diagnostic.level() == Level::Error)
            .map(|diagnostic| self.sources.source_of(diagnostic.span))
            .collect();
        let subjects = subject::subjects(self.sources, self.schema, parsed, &invalid);
        let texts = subject::texts(self.sources, parsed);
        // If definitions can't be read, messages would appear to be missing.
        let requests = if has_errors(diagnostics) { &[] } else { self.settings.conversions.as_slice() };
        let answers = conversion::answer(self.sources, self.schema, requests);
        let of_texts = in_parts(&texts, |texts| {
            self.apply(|check, sink| {
                if let Check::Text(check) = check {
                    for text in texts {
                        check(text, sink);
                    }
                }
            })
        });
        let of_messages = in_parts(&subjects, |subjects| {
            self.apply(|check, sink| {
                if let Check::Message(scope, check) = check {
                    for subject in subjects.iter().filter(|subject| subject.is_in(scope)) {
                        check(subject, sink);
                    }
                }
            })
        });
        let of_packages = self.apply(|check, sink| match check {
            Check::Package(check) => {
                self.schema.packages.iter().for_each(|package| check(package, self.sources, sink));
            }
            Check::Schema(check) => check(self.schema, sink),
            Check::Conversion(check) => {
                let converted = answers.iter().map(|answer| Converted { schema: self.schema, answer });
                converted.for_each(|converted| check(&converted, sink));
            }
            Check::Text(_) | Check::Message(..) | Check::Reader(_) | Check::Ignores => {}
        });
        findings.extend(of_texts.into_iter().chain(of_messages).chain([of_packages]).flatten());
    }

    /// Calls `run` with the check of each rule that is on. Returns the findings, with the configured levels.
    fn apply(&self, run: impl Fn(Check, &mut Sink<'_>)) -> Vec<Finding> {
        let mut findings = Vec::new();
        for rule in RULES {
            let Some(level) = self.settings.level(rule) else { continue };
            let first = findings.len();
            run(rule.check, &mut Sink { rule: rule.id, findings: &mut findings });
            findings[first..].iter_mut().for_each(|finding| finding.level = level);
        }
        findings
    }
}

/// The sources that contain a selected message.
fn selected(sources: &SourceMap, schema: &Schema, parsed: &[PackageSource<'_>]) -> BTreeSet<SourceId> {
    let mut selected = BTreeSet::new();
    for (package, source) in schema.packages.iter().zip(parsed) {
        if source.input.select.is_some() {
            let messages = package.messages.iter().map(|id| schema.message(*id).span);
            let spans = messages.chain(package.interfaces.iter().map(|interface| interface.span));
            selected.extend(spans.map(|span| sources.source_of(span)));
        } else {
            let spans = source.files.iter().map(|(_, _, span, _)| *span);
            let spans = spans.chain(source.pages.iter().map(|page| page.span));
            let spans = spans.chain(source.events.iter().map(|file| file.span));
            selected.extend(spans.map(|span| sources.source_of(span)));
        }
    }
    selected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_sorted_by_id() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }
}
