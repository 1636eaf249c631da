//! Tests of the `lint` rules, with the rules' examples and with other definitions that violate the rules.
//!
//! `fixtures/lint/<rule>.txt` contains the expected findings for a rule's bad example. The rule must have no findings
//! in the good example. If the rule has a fix, the fix must turn the bad example into the good one. Each folder
//! `fixtures/lint/<rule>-<case>/` contains the definitions of another case, and the rule's expected findings in
//! `expected.txt`. If any of the findings can be fixed, `fixed.txt` contains the fixed text. To accept intended
//! changes: `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-lint lint::`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use support::{differs, extent, files_below, package, shared};
use uavspec_dynamic::conversion::Request;
use uavspec_lint::{Check, Preset, RULES, Rule, Settings, apply, lint, rule};
use uavspec_schema::diagnostic::{Level, Problem, ProblemKind};
use uavspec_schema::example::{CONVERTED, Example, catalogues, hints, is_catalogue, is_hints, packages};
use uavspec_schema::finding::Finding;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::{Form, PackageInput, SourceMap, read, render};
use uavspec_test_definitions as support;

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/lint")
}

/// Enables all rules, including rules that `strict` omits.
fn all() -> Settings {
    let others = RULES.iter().filter(|rule| rule.levels.strict.is_none());
    let levels = others.map(|rule| (rule.id.to_owned(), rule.levels.px4)).collect();
    Settings { preset: Preset::Strict, levels, ..Settings::default() }
}

/// Checks the files with all rules. Returns the sources and the findings.
fn judge(files: &[File]) -> (SourceMap, Vec<Finding>) {
    let mut sources = SourceMap::default();
    let files = files.iter().map(|(path, text)| (path.as_str(), text.as_str()));
    let packages = packages(files.clone(), "", &mut sources);
    let catalogues = catalogues(files.clone(), "", &mut sources);
    let hints = hints(files, "", &mut sources);
    let [from, to] = CONVERTED.map(|example| example.package().to_owned());
    let conversions = hints.map(|hints| Request { from, to, hints: Some(hints) });
    let settings = Settings { conversions: conversions.into_iter().collect(), ..all() };
    let findings = lint(&sources, &packages, &catalogues, &settings);
    (sources, findings)
}

fn judge_example(example: Example) -> (SourceMap, Vec<Finding>) {
    let files = example.files().into_iter().map(|(path, text)| (path.to_owned(), text.to_owned()));
    judge(&files.collect::<Vec<_>>())
}

fn of_rule(findings: Vec<Finding>, rule: &str) -> Vec<Finding> {
    findings.into_iter().filter(|finding| finding.rule == rule).collect()
}

fn check_examples(rule: &Rule) -> Vec<String> {
    let mut failures = Vec::new();
    let (sources, findings) = judge_example(rule.bad);
    let findings = of_rule(findings, rule.id);
    if findings.is_empty() {
        failures.push(format!("{}: no finding in the bad example", rule.id));
    }
    let found = render::findings(&findings, &sources, false);
    failures.extend(differs(&fixtures().join(format!("{}.txt", rule.id)), &found));
    if findings.iter().any(|finding| !finding.fix.is_empty()) {
        let fixed: Vec<String> = apply(&findings, &sources).into_values().collect();
        if fixed != [rule.good.text] {
            failures.push(format!("{}: the fix results in\n{}", rule.id, fixed.concat()));
        }
    }
    let (sources, findings) = judge_example(rule.good);
    let findings = of_rule(findings, rule.id);
    if !findings.is_empty() {
        failures.push(format!(
            "{}: the good example has findings: {}",
            rule.id,
            render::findings(&findings, &sources, false)
        ));
    }
    failures
}

#[test]
fn each_rule_finds_its_bad_example_and_not_its_good_one() {
    let failures: Vec<String> = RULES.iter().flat_map(|rule| check_examples(rule)).collect();
    assert!(
        failures.is_empty(),
        "{}\nUAVSPEC_UPDATE_FIXTURES=1 accepts the current findings",
        failures.join("\n")
    );
}

/// The rule that a folder is named after: the longest matching id, because an id may be the prefix of another.
fn rule_of(case: &str) -> Option<&'static Rule> {
    let starts = |rule: &&&Rule| case.strip_prefix(rule.id).is_some_and(|rest| rest.starts_with('-'));
    RULES.iter().filter(starts).max_by_key(|rule| rule.id.len()).copied()
}

#[test]
fn each_further_case_has_the_expected_findings() {
    let mut failures = String::new();
    for entry in fs::read_dir(fixtures()).expect("fixtures") {
        let folder = entry.expect("an entry").path();
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        if !folder.is_dir() {
            assert!(RULES.iter().any(|rule| name == format!("{}.txt", rule.id)), "{name}: no such rule");
            continue;
        }
        let rule = rule_of(&name).unwrap_or_else(|| panic!("{name}: no such rule"));
        let files: Vec<File> = files_below(&folder, &["msg", "srv", "action", "md", "adoc", "po"])
            .iter()
            .map(|file| {
                let path = file.strip_prefix(&folder).expect("a prefix").to_string_lossy().replace('\\', "/");
                (path, fs::read_to_string(file).expect("a text"))
            })
            .collect();
        let (sources, findings) = judge(&files);
        let findings = of_rule(findings, rule.id);
        let found = render::findings(&findings, &sources, false);
        let fixed: String = apply(&findings, &sources)
            .iter()
            .map(|(source, text)| format!("== {}\n{text}", sources.path(*source)))
            .collect();
        let fixed = (!fixed.is_empty()).then(|| differs(&folder.join("fixed.txt"), &fixed)).flatten();
        for failure in differs(&folder.join("expected.txt"), &found).into_iter().chain(fixed) {
            writeln!(failures, "{failure}").expect("a string");
        }
    }
    assert!(failures.is_empty(), "{failures}UAVSPEC_UPDATE_FIXTURES=1 accepts the current findings");
}

#[test]
fn an_ignore_comment_applies_to_its_own_line_and_to_the_declaration_below() {
    let text = "# Glider\n\nuint64 timestamp  # [us] Time\n\n\
                # Old notes. # uavspec:ignore comment-lost still useful\n\n\
                # uavspec:ignore unit-missing not known\n\
                float32 sink  # Sink rate\n";
    let (sources, findings) = judge(&[("Glider.msg".to_owned(), text.to_owned())]);
    let ids = ["comment-lost", "unit-missing", "unused-ignore", "invalid-ignore"];
    let found: Vec<Finding> = findings.into_iter().filter(|finding| ids.contains(&finding.rule)).collect();
    assert!(found.is_empty(), "{}", render::findings(&found, &sources, false));
}

#[test]
fn each_parser_warning_is_a_rule_and_no_parser_error_is() {
    for ProblemKind { code, level, .. } in Problem::KINDS {
        let is_rule = rule(code).map(|rule| matches!(rule.check, Check::Reader(_)));
        let expected = (*level != Level::Error).then_some(true);
        assert_eq!(is_rule, expected, "{code}");
    }
}

/// A path and the content of the file.
type File = (String, String);

/// Definitions in memory: packages, each with its files.
#[derive(Clone)]
struct Definitions {
    packages: Vec<(String, Form, Vec<File>)>,
}

impl Definitions {
    /// Reads the definitions below a folder as one package.
    fn of_folder(folder: &Path, form: Form) -> Self {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        Self { packages: vec![(name, form, texts_below(folder))] }
    }

    /// Reads each subfolder of a folder as a ROS 2 package.
    fn of_ros(folder: &Path) -> Self {
        let folders = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let mut folders: Vec<PathBuf> = folders.filter(|path| path.is_dir()).collect();
        folders.sort();
        let form = Form::Msg(Dialect::Ros2);
        Self { packages: folders.iter().flat_map(|folder| Self::of_folder(folder, form).packages).collect() }
    }

    /// Keeps some of the files of each package in a quick run.
    fn sampled(mut self) -> Self {
        for (_, _, files) in &mut self.packages {
            *files = std::mem::take(files).into_iter().step_by(extent(1, 8)).collect();
        }
        self
    }

    fn load(&self) -> (SourceMap, Vec<PackageInput>) {
        let mut sources = SourceMap::default();
        let mut packages = Vec::new();
        for (name, form, files) in &self.packages {
            let mut package = package(name, *form);
            for (path, text) in files {
                package.sources.push(sources.add(path.as_str(), text.clone().into_bytes()).expect("a text"));
            }
            packages.push(package);
        }
        (sources, packages)
    }

    /// The number of findings for each rule.
    fn counts(&self) -> BTreeMap<&'static str, usize> {
        let (sources, packages) = self.load();
        let mut counts = BTreeMap::new();
        for finding in lint(&sources, &packages, &[], &all()) {
            *counts.entry(finding.rule).or_default() += 1;
        }
        counts
    }

    /// The model of the definitions, without locations.
    fn model(&self) -> String {
        let (sources, packages) = self.load();
        let (schema, _) = read(&sources, &packages);
        let text = format!("{schema:#?}");
        let mut lines = text.lines();
        let mut model = String::with_capacity(text.len());
        while let Some(line) = lines.next() {
            if line.ends_with(": Span {") {
                // Skip the start, the end and the closing brace.
                lines.by_ref().take(3).for_each(drop);
            } else {
                // A fix turns text that resembles an annotation into an annotation.
                model.push_str(&line.replace("is_enum_exact: false", "is_enum_exact: true"));
                model.push('\n');
            }
        }
        model
    }

    /// Applies all automatic fixes once. Returns `None` if there are none.
    fn fixed(&self) -> Option<Self> {
        let (sources, packages) = self.load();
        let fixed = apply(&lint(&sources, &packages, &[], &all()), &sources);
        if fixed.is_empty() {
            return None;
        }
        let mut definitions = self.clone();
        for ((_, _, files), package) in definitions.packages.iter_mut().zip(&packages) {
            for ((_, text), source) in files.iter_mut().zip(&package.sources) {
                if let Some(new) = fixed.get(source) {
                    assert_ne!(text, new, "a fix must change the text");
                    text.clone_from(new);
                }
            }
        }
        Some(definitions)
    }
}

fn texts_below(folder: &Path) -> Vec<File> {
    files_below(folder, &["msg", "srv", "action", "md"])
        .iter()
        .map(|file| (file.to_string_lossy().into_owned(), fs::read_to_string(file).expect("a text")))
        .collect()
}

/// The maximum number of passes. Even the worst known definitions need at most this many passes.
const MAX_PASSES: usize = 12;

fn check_mending(name: &str, definitions: &Definitions) {
    let model = definitions.model();
    let mut current = definitions.clone();
    for _ in 0..MAX_PASSES {
        let Some(fixed) = current.fixed() else { return };
        current = fixed;
        assert!(current.model() == model, "{name}: a fix changes the meaning");
    }
    assert!(current.fixed().is_none(), "{name}: fixes remain after {MAX_PASSES} passes");
}

#[test]
fn fixes_preserve_the_meaning_of_real_definitions() {
    let px4 = Form::Msg(Dialect::Px4);
    if let Some(corpus) = shared("corpus") {
        for release in ["main", "1.16", "1.15"] {
            let definitions = Definitions::of_folder(&corpus.join("px4").join(release), px4);
            check_mending(release, &definitions.sampled());
        }
        check_mending("ros2", &Definitions::of_ros(&corpus.join("ros2")).sampled());
        for edit in fs::read_dir(corpus.join("breaking")).expect("a folder").step_by(extent(1, 8)) {
            let edit = edit.expect("an entry").path();
            for side in ["old", "new"].map(|side| edit.join(side)).iter().filter(|side| side.exists()) {
                check_mending(&side.to_string_lossy(), &Definitions::of_folder(side, px4));
            }
        }
    }
    // Catalogues and hints have no automatic fixes.
    let is_definition = |rule: &&&Rule| !is_catalogue(rule.bad.path) && !is_hints(rule.bad.path);
    for rule in RULES.iter().filter(is_definition) {
        let example = rule.bad;
        let dialect = if example.path.starts_with("ros2/") { Dialect::Ros2 } else { Dialect::Px4 };
        let form = Kind::of(example.path).map_or(Form::Table, |_| Form::Msg(dialect));
        let files = vec![(example.path.to_owned(), example.text.to_owned())];
        check_mending(rule.id, &Definitions { packages: vec![("demo".to_owned(), form, files)] });
    }
    for entry in fs::read_dir(fixtures()).expect("fixtures") {
        let folder = entry.expect("an entry").path();
        if folder.is_dir() {
            check_mending(&folder.to_string_lossy(), &Definitions::of_folder(&folder, px4));
        }
    }
}

/// Random definitions, composed of fragments that rules react to.
fn odd_definitions() -> impl Strategy<Value = String> {
    let pieces = vec![
        "[@range 1, 0]",
        "(@invalid NaN)",
        "[meters]",
        "[m]",
        "[FRD]",
        "[0, 1]",
        "[@enum A]",
        "[@todo]",
        "(@see x)",
        "[@count a]",
        "[enum A]",
        "[@range 2 (x), 1 (y)]",
        "[",
        "]",
        "(",
        ")",
        "(@",
        "[@",
        "@range 1, 0",
        "|",
        ":",
        ",",
        " ",
        "  ",
        "\t",
        "text",
        "a",
        "#",
        "uavspec:ignore unit-missing why",
        ".",
        "[@frame ",
        "[@invalid 0 [x]]",
        "(@invalid 0 [x])",
    ];
    let comment =
        prop::collection::vec(prop::sample::select(pieces), 0..9).prop_map(|pieces| pieces.concat());
    let lines = vec![
        "",
        "",
        "# TOPICS glider",
        "# TOPICS a glider a",
        "# TOPICS a  a",
        "# TOPICS  b uavspec:ignore x y",
        "#",
        "# text",
        "  # more",
        "# TOPICS",
        "uint8\tA_X = 0x1 #",
        "uint16  A_Y=2",
        "uint8 B_Z = 0b1  # go |",
        "float32 f #",
        "  float32[8]  a #",
        "uint8 num_a #",
        "uint8 a_count",
        "uint8 e",
        "uint64 timestamp #",
        "bool C = true",
        " ",
        "# x \t",
    ];
    let line = (prop::sample::select(lines), comment, any::<bool>()).prop_map(
        |(line, comment, has_carriage_return)| {
            let comment = if line.ends_with(['#', '|']) { comment.as_str() } else { "" };
            format!("{line}{comment}{}\n", if has_carriage_return { "\r" } else { "" })
        },
    );
    prop::collection::vec(line, 0..12).prop_map(|lines| lines.concat())
}

proptest! {
    #![proptest_config(support::config(1_000))]

    #[test]
    fn fixes_preserve_the_meaning_of_odd_definitions(text in odd_definitions()) {
        let files = vec![("Glider.msg".to_owned(), text.clone())];
        let packages = vec![("demo".to_owned(), Form::Msg(Dialect::Px4), files)];
        check_mending(&text, &Definitions { packages });
    }
}

#[test]
fn measured_counts_are_up_to_date() {
    let Some(main) = shared("corpus/px4/main") else { return };
    let counts = Definitions::of_folder(&main, Form::Msg(Dialect::Px4)).counts();
    for rule in RULES {
        let found = counts.get(rule.id).copied().unwrap_or_default();
        let measured = rule.measured.map_or(0, |measured| measured.findings);
        assert_eq!(found, measured, "findings of {}", rule.id);
        if let Some(measured) = rule.measured {
            assert!(measured.sample == measured.findings.min(30), "{}", rule.id);
            // A note may concern something intentional, but most warnings and errors must be correct.
            let is_note =
                [rule.levels.px4, rule.levels.strict].into_iter().flatten().max() == Some(Level::Note);
            let is_mostly_right = is_note || 10 * measured.right >= 8 * measured.sample;
            assert!(measured.right <= measured.sample && is_mostly_right, "{}", rule.id);
        }
    }
}

#[test]
fn ros_definitions_are_not_checked_against_the_px4_standard() {
    let Some(folder) = shared("corpus/ros2") else { return };
    let counts = Definitions::of_ros(&folder).counts();
    assert_eq!(counts.into_keys().collect::<Vec<_>>(), ["trailing-white-space"]);
}

#[test]
fn checks_unusual_definitions_in_linear_time() {
    let many = extent(20_000, 1_000);
    let lines = |line: &dyn Fn(usize) -> String| (0..many).map(line).collect::<String>();
    let head = "# Glider\n\nuint64 timestamp  # [us] Time\n";
    let texts = [
        lines(&|at| format!("uint8 f{at} # [@enum A] bits\n"))
            + &lines(&|at| format!("uint16 A_{at} = {}\n", at % 300)),
        lines(&|at| format!("float32 f{at} # [@frame @x{at}] a [@range 1, 0] b [m]\n")),
        lines(&|at| format!("# TOPICS a{at} glider\n\n")),
        format!("# TOPICS {}\n", "gliders ".repeat(many)),
        format!("# TOPICS {}\n", "glider ".repeat(many)),
        lines(&|at| format!("   uint8\t  num_a{at}\nuint8[9] a{at}\n")),
        format!("uint8 x{}A = 1\n", " ".repeat(100 * many)),
        format!("uint8 a # {}\n", "x [@range 2, 1] [meters] ".repeat(many)),
        format!("uint8 A=1 # {}\n", "|".repeat(many)),
        "\n".repeat(many) + "uint8 a\n",
        lines(&|at| format!("# a{at}\n\n")),
        lines(&|at| format!("uint8 a{at}_COUNT = 1\n  # b\n")),
        format!("uint8 {}=1\n", "A_".repeat(many)),
        lines(&|at| format!("uint8 a{at}_{}\n", "b_".repeat(50))),
        format!("\n# {}\n", "1 0 ".repeat(many)) + &lines(&|at| format!("float32 f{at} # x\n")),
    ];
    for (path, text) in ["VehicleCommand.msg", "FailsafeFlags.msg"].into_iter().cycle().zip(texts) {
        let (sources, findings) = judge(&[(path.to_owned(), format!("{head}{text}"))]);
        render::findings(&findings, &sources, false);
        apply(&findings, &sources);
    }
    let rows = lines(&|at| format!("| {} | FATAL{at} | Warning: \u{200b} |\n", 512 + at % 256));
    let page = format!("# Errors of a vendor (codes 512-767)\n\n|Code|Abbr|Description|\n|-|-|-|\n{rows}");
    let (sources, findings) = judge(&[("page.md".to_owned(), page)]);
    render::findings(&findings, &sources, false);
}

#[test]
fn the_definitions_of_this_project_satisfy_all_strict_rules() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../definitions");
    let mut messages = Definitions::of_folder(&folder.join("px4"), Form::Msg(Dialect::Px4));
    messages.packages.append(&mut Definitions::of_folder(&folder.join("flockwave"), Form::Table).packages);
    let counts = messages.counts();
    let found: Vec<&&str> =
        counts.keys().filter(|id| rule(id).is_none_or(|rule| rule.levels.strict.is_some())).collect();
    assert_eq!(found, Vec::<&&str>::new());
}
