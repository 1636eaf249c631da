//! Tests of complete books: links resolve, text is escaped, and pictures are well-formed XML.

mod translated;

use std::collections::{BTreeMap, BTreeSet};

use pulldown_cmark::{Event, Parser, Tag};
use uavspec_lint::RULES;
use uavspec_lint::release::{ReleaseText, Releases};
use uavspec_lint::report::rule_page;
use uavspec_schema::diagnostic::Problem;
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::SourceMap;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Form, PackageInput, Schema, read};

use super::{Options, emit};
use crate::file::OutputFile;

const SAIL: &str = "\
# Trim of a sail, see RigStatus for the mast
#
# The crew sets it; sheet_length follows.
# - port tack first
# - Boat.HULL_RED is no flag

uint32 MESSAGE_VERSION = 2  # Raised with each change
uint64 timestamp  # [us] Since launch
Boat[2] boats  # Both hulls

# Sheets
float32 sheet_length  # [m] [@range 0, 20] [@invalid NaN first seconds] Rope paid out, unlike twist_angle
float32 twist_angle  # [rad] [@range -pi, pi] [@frame NED] Of the sail

uint8 TACK_PORT = 1  # Wind from the left
uint8 TACK_STARBOARD = 2
uint8 TACK_BACKBOARD = 1  # Old name
uint8 FLAG_WET = 1  # Soaked
uint8 FLAG_TORN = 4
uint8 tack  # [@enum TACK] Where the wind is
uint8 state  # [@flags FLAG] What is wrong
uint8 hull  # [@enum Boat.HULL] Whose sail
uint8 num_knots  # [@count knots] Knots tied
uint16[40] knots  # Their numbers
char[12] maker  # Sailmaker
uint8 SPARE_REEFS = 3  # Reefs left
uint8 ORB_QUEUE_LENGTH = 4
# TOPICS sail_trim sail_trim_backup
";

const BOAT: &str = "\
uint8 HULL_RED = 0 # Red
uint8 HULL_BLUE = 1 # Blue
uint64 timestamp
uint8 hull # [@enum HULL] Colour
";

const RIG_STATUS: &str = "uint64 timestamp\nSail sail # Held sail\nuint8[2000] log\n";

const ORDER: &str = "\
uint64 timestamp
uint16 ORDER_TACK = 10 # Go about. |[@enum SPEED] How|[deg] [@range 0, 90] New course|Unused|Unused|Unused|Unused|Unused|
uint16 ORDER_ANCHOR = 20 # Drop anchor. |[m] Depth|Unused|Unused|Unused|Unused|Unused|Unused|
uint16 ORDER_WAIT = 30 # Stay
uint8 SPEED_SLOW = 0
uint8 SPEED_FAST = 1
float32 param1
";

const CODES: &str = "\
# Codes

## Warnings (codes 64-127)

| Code | Abbr | Description |
|-----:|------|-------------|
| 64 | DAMP | Bilge damp. Use it only if the pumps run; otherwise use code 128. See also code 65. |
| 65 | `LEE` | Near a lee shore, 65 fathoms. |

## Errors (codes 128-191)

| Code | Abbr | Description |
|-----:|------|-------------|
| 128 | FLOOD | Water above the boards. Use it only if the pumps fail; otherwise use code 64. |
";

/// A package: its name, its form, and its sources as paths and texts.
type Input<'i> = (&'i str, Form, &'i [(&'i str, &'i str)]);

fn book(packages: &[Input<'_>]) -> Vec<OutputFile> {
    book_with(packages, &Options::default())
}

fn book_with(packages: &[Input<'_>], options: &Options) -> Vec<OutputFile> {
    let (sources, schema) = definitions(packages);
    emit(&schema, &Translations::default(), &sources, options)
}

fn definitions(packages: &[Input<'_>]) -> (SourceMap, Schema) {
    let mut sources = SourceMap::default();
    let mut inputs = Vec::new();
    for (name, form, files) in packages {
        let ids =
            files.iter().map(|(path, text)| sources.add(*path, text.as_bytes().to_vec()).expect("readable"));
        inputs.push(PackageInput {
            name: (*name).to_owned(),
            form: *form,
            ros_package: None,
            origin: Some("https://example.org/boats".to_owned()),
            revision: Some("v1".to_owned()),
            select: None,
            sources: ids.collect(),
        });
    }
    let (schema, diagnostics) = read(&sources, &inputs);
    let errors = uavspec_schema::diagnostic::has_errors(&diagnostics);
    assert!(!errors, "{diagnostics:?}");
    (sources, schema)
}

const PX4: Form = Form::Msg(Dialect::Px4);
const ROS2: Form = Form::Msg(Dialect::Ros2);

fn boats() -> Vec<OutputFile> {
    book(BOATS)
}

const BOATS: &[Input<'static>] = &[
    (
        "boats",
        PX4,
        &[("Sail.msg", SAIL), ("Boat.msg", BOAT), ("RigStatus.msg", RIG_STATUS), ("Order.msg", ORDER)],
    ),
    ("codes", Form::Table, &[("codes.md", CODES)]),
    (
        "harbour",
        ROS2,
        &[
            ("Berth.msg", "string<=8 name\nBerth2[<=3] next\n"),
            ("Berth2.msg", "# Neighbour\nfloat64 width 2.5 # Of the berth\n"),
            (
                "Moor.srv",
                "# Ask for a berth\nuint8 SIDE_PORT=1\nBerth wish\n---\nbool granted # If berth is free\n",
            ),
            ("Sail.action", "uint8 goal\n---\nuint8 goal\n---\nuint8 goal\n"),
        ],
    ),
];

fn one_message(text: &str) -> String {
    text_of(&book(&[("p", PX4, &[("Kite.msg", text)])]), "p/Kite.md").to_owned()
}

fn text_of<'f>(files: &'f [OutputFile], path: &str) -> &'f str {
    let file = files.iter().find(|file| file.path == path);
    &file
        .unwrap_or_else(|| {
            panic!("no {path} in {:?}", files.iter().map(|file| &file.path).collect::<Vec<_>>())
        })
        .text
}

fn is(file: &OutputFile, extension: &str) -> bool {
    file.path.rsplit_once('.').is_some_and(|(_, found)| found == extension)
}

/// A book with one message and the rules of uavspec.
fn rules() -> Vec<OutputFile> {
    let options = Options { rules: true, ..Options::default() };
    book_with(&[("boats", PX4, &[("Boat.msg", BOAT)])], &options)
}

/// The Markdown events of a page, with the extensions of GitHub and mdBook.
fn events(text: &str) -> Vec<Event<'_>> {
    Parser::new_ext(
        text,
        pulldown_cmark::Options::ENABLE_TABLES | pulldown_cmark::Options::ENABLE_STRIKETHROUGH,
    )
    .collect()
}

fn anchors(text: &str) -> Vec<&str> {
    text.split("<a id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// All link targets, by page.
fn targets(files: &[OutputFile]) -> BTreeMap<&str, BTreeSet<String>> {
    let of_file = |file: &OutputFile| {
        // Headings are link targets too.
        let headings =
            file.text.lines().filter_map(|line| line.strip_prefix("## ").or(line.strip_prefix("# ")));
        let headings = headings.map(|heading| heading.to_lowercase().replace(' ', "-").replace('`', ""));
        anchors(&file.text).into_iter().map(str::to_owned).chain(headings).collect()
    };
    files.iter().map(|file| (file.path.as_str(), of_file(file))).collect()
}

#[test]
fn resolves_every_link() {
    let count = check_links(&boats());
    assert!(count > 100, "{count} links");
    let count = check_links(&rules());
    assert!(count > RULES.len() * 2, "{count} links");
}

#[track_caller]
fn check_links(files: &[OutputFile]) -> usize {
    let targets = targets(files);
    let mut count = 0;
    for file in files.iter().filter(|file| is(file, "md")) {
        for event in events(&file.text) {
            let Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) = event else {
                continue;
            };
            if dest_url.starts_with("https://") {
                continue;
            }
            count += 1;
            let (path, anchor) = dest_url.split_once('#').unwrap_or((&dest_url, ""));
            let path = if path.is_empty() { file.path.clone() } else { resolved(&file.path, path) };
            let anchors = targets.get(path.as_str());
            assert!(anchors.is_some(), "{}: {dest_url} has no target page", file.path);
            let is_found = anchor.is_empty() || anchors.is_some_and(|anchors| anchors.contains(anchor));
            assert!(is_found, "{}: {dest_url} has no target anchor", file.path);
        }
    }
    count
}

#[test]
fn creates_the_rule_pages_that_reports_link_to() {
    let files = rules();
    let targets = targets(&files);
    let ids = RULES.iter().map(|rule| rule.id).chain(Problem::KINDS.iter().map(|kind| kind.code));
    for id in ids {
        let url = rule_page(id);
        let (path, anchor) = url.split_once('#').unwrap_or((&url, ""));
        let path =
            path.strip_prefix("docs/rules/").and_then(|path| path.strip_suffix(".html")).expect("a page");
        let anchors = targets.get(format!("rules/{path}.md").as_str()).unwrap_or_else(|| panic!("{url}"));
        assert!(anchor.is_empty() || anchors.contains(anchor), "{url}");
    }
}

#[test]
fn rule_pages_have_all_sections() {
    let files = rules();
    let page = text_of(&files, "rules/annotation-near-miss.md");
    for expected in [
        "\n# `annotation-near-miss`\n",
        "\nText that resembles an annotation but deviates from the standard form.\n",
        "\nLevel: warning in all presets · Fixed by `lint --fix` · ",
        "\n## Why it matters\n\nuavspec treats this text as the annotation that it resembles.",
        "\n## Example\n\n```text\nwarning[annotation-near-miss]: ",
        "\n## How to fix\n\nWrite the annotation in its standard form, such as `[@enum PREFIX]`, ",
        "\n- float32 flaps     # [-] (@range 0, 1) Flap deflection\n",
        "\n+ float32 flaps     # [-] [@range 0, 1] Flap deflection\n",
        "\n## Configuration\n\nTo ignore a finding, add `# uavspec:ignore annotation-near-miss REASON` to the line. ",
    ] {
        assert!(page.contains(expected), "{expected}\nis not in\n{page}");
    }
    let all = text_of(&files, "rules/README.md");
    assert!(all.contains("\n| [`annotation-near-miss`](annotation-near-miss.md) | Text that"), "{all}");
    for rule in RULES {
        let page = text_of(&files, &format!("rules/{}.md", rule.id));
        assert!(page.contains(&format!("[{}]: ", rule.id)), "the example has no output:\n{page}");
        assert!(!page.contains("{{") && !page.contains("{%"), "{page}");
        let texts = [rule.statement, rule.why, rule.fix];
        assert!(texts.iter().all(|text| text.ends_with('.')), "{}: {texts:?}", rule.id);
        assert!(page.lines().count() <= 60, "{}: {} lines", rule.id, page.lines().count());
    }
}

#[test]
fn parser_errors_are_on_one_page() {
    let files = rules();
    let page = text_of(&files, "rules/reading.md");
    for expected in [
        "\n## `invalid-utf8`\n\n- error: byte 0x&#123;byte} is not valid UTF-8\n- help: save the file as UTF-8\n",
        "\n## `missing-name`\n\n- error: expected a name after <code>&#123;type name&#125;</code>\n",
        "\n- [`annotation-near-miss`](annotation-near-miss.md)\n",
    ] {
        assert!(page.contains(expected), "{expected}\nis not in\n{page}");
    }
}

#[test]
fn includes_rule_pages_only_on_request() {
    assert!(boats().iter().all(|file| !file.path.starts_with("rules/") && !file.text.contains("rules/")));
    let files = rules();
    let overview = text_of(&files, "README.md");
    assert!(
        overview.contains("\n## Rules of lint and breaking\n\n[All rules](rules/README.md)"),
        "{overview}"
    );
    let paths: BTreeSet<String> = files.iter().map(|file| file.path.to_lowercase()).collect();
    assert_eq!(paths.len(), files.len(), "two rules share a page");
}

/// Resolves the relative path `link` on the page `from`.
fn resolved(from: &str, link: &str) -> String {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in link.split('/') {
        if part == ".." {
            parts.pop().expect("a folder above");
        } else {
            parts.push(part);
        }
    }
    parts.join("/")
}

#[test]
fn creates_unique_anchors() {
    for file in boats().into_iter().chain(rules()) {
        let mut seen = BTreeSet::new();
        for anchor in anchors(&file.text) {
            assert!(seen.insert(anchor), "{}: {anchor}", file.path);
        }
    }
}

#[test]
fn lists_every_page_in_the_table_of_contents() {
    let files = boats();
    for files in [&files, &rules()] {
        let summary = text_of(files, "SUMMARY.md");
        for file in files.iter().filter(|file| is(file, "md") && file.path != "SUMMARY.md") {
            assert!(summary.contains(&format!("]({})", file.path)), "{}", file.path);
        }
    }
    let summary = text_of(&files, "SUMMARY.md");
    let ordered = "- [boats](boats/README.md)\n  - [Boat](boats/Boat.md)\n  - [Order](boats/Order.md)\n";
    assert!(summary.contains(ordered), "{summary}");
}

#[test]
fn starts_every_file_with_a_notice() {
    for file in boats().into_iter().chain(rules()) {
        let first = file.text.lines().next().unwrap_or_default();
        assert!(
            first.contains("Generated by uavspec-codegen from the definitions. Do not edit"),
            "{}",
            file.path
        );
    }
}

#[test]
fn documents_all_properties_of_a_message() {
    let files = boats();
    let page = text_of(&files, "boats/Sail.md");
    for expected in [
        "\n# Sail\n\nTrim of a sail, see [`RigStatus`](RigStatus.md) for the mast\n",
        "\nThe crew sets it; [`sheet_length`](#field-sheet_length) follows.\n- port tack first\n",
        "[`Boat.HULL_RED`](Boat.md#constant-hull_red) is no flag",
        "| Topics | `sail_trim`, `sail_trim_backup` |",
        "| Message&nbsp;version | 2 |",
        "| Queue&nbsp;length | 4 |",
        "from <https://example.org/boats> at `v1`",
        "| <a id=\"field-boats\"></a>`boats` | [`Boat[2]`](Boat.md) |",
        "\n### Sheets\n",
        "| <a id=\"field-sheet_length\"></a>`sheet_length` | `float32` | m | 0&nbsp;to&nbsp;20<br>`NaN`:&nbsp;no&nbsp;data (first seconds) | Rope paid out, unlike [`twist_angle`](#field-twist_angle) |",
        "| -π&nbsp;to&nbsp;π<br>frame: NED |",
        "one of [`TACK`](#enum-tack)",
        "bits of [`FLAG`](#enum-flag)",
        "one of [`Boat.HULL`](Boat.md#enum-hull)",
        "number of used entries in [`knots`](#field-knots), at most 40",
        "used entries: the first [`num_knots`](#field-num_knots)",
        "| text | Sailmaker |",
        "Used by [`tack`](#field-tack). Other values may occur.",
        "`TACK_BACKBOARD` | Old name<br>Alias of `TACK_PORT`. |",
        "| `0x04` | 2 | <a id=\"constant-flag_torn\"></a>`FLAG_TORN` |",
        "`SPARE_REEFS` | `uint8` | 3 | Reefs left |",
        "[![Memory layout of Sail](Sail.svg)](Sail.svg)",
        "\n## Used by\n\n- [`RigStatus.sail`](RigStatus.md#field-sail)\n",
    ] {
        assert!(page.contains(expected), "{expected}\nis not in\n{page}");
    }
    assert!(!page.contains("MESSAGE_VERSION"), "MESSAGE_VERSION is shown as a fact");
    let boat = text_of(&files, "boats/Boat.md");
    assert!(boat.contains("Used by [`hull`](#field-hull), [`Sail.hull`](Sail.md#field-hull)."), "{boat}");
}

#[test]
fn documents_the_parameters_of_commands() {
    let files = boats();
    let page = text_of(&files, "boats/Order.md");
    for expected in [
        "`ORDER_TACK`](#command-order_tack) | Go about. |",
        "| 30 | <a id=\"constant-order_wait\"></a>`ORDER_WAIT` | Stay |",
        "\n### `ORDER_TACK` (10)\n\nGo about.\n",
        "| 1 |  | one of [`SPEED`](#enum-speed) | How |\n| 2 | deg | 0&nbsp;to&nbsp;90 | New course |\n",
        "Used by parameter 1 of [`ORDER_TACK`](#command-order_tack).",
    ] {
        assert!(page.contains(expected), "{expected}\nis not in\n{page}");
    }
    assert!(!page.contains("Unused"), "{page}");
}

#[test]
fn documents_the_parts_of_a_service_on_one_page() {
    let files = boats();
    let page = text_of(&files, "harbour/Moor.srv.md");
    for expected in [
        "# Moor service\n",
        "\n## Request\n\nAsk for a berth\n",
        "id=\"request-field-wish\"",
        "id=\"response-field-granted\"",
        "`SIDE_PORT`",
    ] {
        assert!(page.contains(expected), "{expected}\nis not in\n{page}");
    }
    let berth = text_of(&files, "harbour/Berth.md");
    assert!(berth.contains("[`Moor_Request.wish`](Moor.srv.md#request-field-wish)"), "{berth}");
    assert!(berth.contains("[`Berth2[<=3]`](Berth2.md)"), "{berth}");
    assert!(!berth.contains("Offset"), "ROS has no uORB layout");
    assert!(text_of(&files, "harbour/Berth2.md").contains("default `2.5`"));
}

#[test]
fn links_error_codes_to_each_other() {
    let files = boats();
    let page = text_of(&files, "codes/error-codes/warnings.md");
    for expected in [
        "Range: 64 to 127 (warning). This table lists 2 codes, defined in `codes.md:3`.",
        "\n<a id=\"code-64\"></a>\n\n## 64 DAMP\n\nBilge damp.",
        "otherwise use code [128](errors.md#code-128). See also code [65](#code-65).",
        "\nSeverity: <span class=\"severity-warning\" aria-hidden=\"true\">◔</span>&nbsp;warning · Alternatives: ",
        ">◑</span>&nbsp;[128](errors.md#code-128) · See also: ",
        ">◔</span>&nbsp;[65](#code-65)\n",
        "lee shore, 65 fathoms.",
    ] {
        assert!(page.contains(expected), "{expected}\nis not in\n{page}");
    }
    let all = text_of(&files, "codes/error-codes.md");
    assert!(
        all.contains("| [64](error-codes/warnings.md#code-64) | `DAMP` | ")
            && all.contains("| Bilge damp. Use it"),
        "{all}"
    );
}

const GLIDERS: &str = include_str!("../../../schema/tests/fixtures/ok/type-tables/gliders.md");

#[test]
fn links_types_and_messages_to_each_other() {
    let book = book(&[("gliders", Form::Table, &[("gliders.md", GLIDERS)])]);
    assert!(check_links(&book) > 60);
    let glider = text_of(&book, "gliders/types/Glider.md");
    for expected in [
        "| <a id=\"field-time\"></a>`time` | yes | [`Instant`](Instant.md) |  |  | When that was |",
        "| no | list of number | m/s | \\-20&nbsp;to&nbsp;20<br>length 1&nbsp;to&nbsp;60 | Each of the last seconds |",
        "| no | [`Fix`](Fix.md) or null |",
        "one of `\"north\"`, `\"south\"`, `\"the middle\"`",
        "Other fields are not allowed.",
        "- [`GLIDER-INF.status`](../messages/GLIDER-INF.md#response-status), response",
        "| Definition | `gliders.md:50` |",
    ] {
        assert!(glider.contains(expected), "{expected}\n{glider}");
    }
    let request = text_of(&book, "gliders/messages/FIELD-CLOSE.md");
    assert!(
        request.contains("Responses: [`TOWER-ACK`](TOWER-ACK.md), [`GLIDER-INF`](GLIDER-INF.md)."),
        "{request}"
    );
    let phase = text_of(&book, "gliders/types/Phase.md");
    assert!(
        phase.contains("| `\"final glide\"` | On the way home |\n\nOther values are allowed."),
        "{phase}"
    );
    let index = text_of(&book, "gliders/README.md");
    assert!(index.contains("| [`Mark`](types/Mark.md) | array | 2 | A turning point. |"), "{index}");
}

#[test]
fn escapes_text_of_definitions() {
    let page = one_message(
        "# [x](javascript:alert(1)) <script>alert(1)</script> {{#include /etc/passwd}} *b* | c\n\
         #\n\
         # <img src=x onerror=alert(1)>\n\
         # ## no heading\n\
         # {% raw %} and \u{202e}desrever\n\
         \n\
         uint8 a # [m] ![x](y) | <b> `code` __z__ {{#include x}}\n\
         \n\
         # Group | <i> {#id} ## #\n\
         uint8 b # {{{%\u{202e}</td></table><script>\n\
         uint8 c\n",
    );
    let allowed = |html: &str| {
        let is_composer =
            html.starts_with("<div class=\"composer\" data-message=\"") && html.matches('<').count() == 1;
        html.starts_with("<!--")
            || html.starts_with("<a id=\"")
            || is_composer
            || matches!(html, "</a>" | "<br>" | "</div>")
    };
    for event in events(&page) {
        match event {
            Event::Html(html) | Event::InlineHtml(html) => assert!(allowed(html.trim()), "{html}\n{page}"),
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                assert!(!dest_url.contains("javascript") && &*dest_url != "y", "{dest_url}");
            }
            Event::Start(Tag::Emphasis | Tag::Strong) => panic!("{page}"),
            _ => {}
        }
    }
    assert!(!page.contains("{{") && !page.contains("{%"), "{page}");
    assert!(!page.contains('\u{202e}'), "{page}");
    // Each row of the field table has the right number of cells.
    let widths: BTreeSet<usize> = page
        .lines()
        .filter(|line| line.contains("field-a") || line.contains("field-b"))
        .map(|line| line.replace("\\|", "").matches('|').count())
        .collect();
    assert!(widths.iter().all(|width| (5..=7).contains(width)), "{widths:?}\n{page}");
    assert!(text_in(&page).contains("{{#include /etc/passwd}}"), "the text is legible");
}

/// The text of a page, without markup.
fn text_in(page: &str) -> String {
    let texts = events(page).into_iter().filter_map(|event| match event {
        Event::Text(text) | Event::Code(text) => Some(text.to_string()),
        _ => None,
    });
    texts.collect()
}

#[test]
fn escapes_strings_of_definitions() {
    let files =
        book(&[("p", ROS2, &[("Kite.msg", "string NAME=\"a|`b`{{#include c}}<d>\"\nstring text 'x|y'\n")])]);
    let page = text_of(&files, "p/Kite.md");
    assert!(!page.contains("{{") && !page.contains("<d>"), "{page}");
    assert!(text_in(page).contains("a|`b`{{#include c}}<d>"), "{page}");
    assert!(text_in(page).contains("x|y"), "{page}");
}

#[test]
fn avoids_reserved_page_names() {
    let files = book(&[("p", PX4, &[("Readme.msg", "uint8 a\n"), ("Index.msg", "uint8 a\n")])]);
    let paths: BTreeSet<String> = files.iter().map(|file| file.path.to_lowercase()).collect();
    assert_eq!(paths.len(), files.len(), "{paths:?}");
    assert!(paths.contains("p/readme.msg.md") && paths.contains("p/readme.msg.svg"), "{paths:?}");
}

#[test]
fn creates_an_empty_book_for_an_empty_schema() {
    let files = emit(
        &uavspec_schema::Schema::default(),
        &Translations::default(),
        &SourceMap::default(),
        &Options::default(),
    );
    let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
    assert_eq!(paths, ["book.toml", "book.css", "SUMMARY.md", "README.md", "composer.js", "error-codes.js"]);
}

#[test]
fn does_not_depend_on_the_order_of_files() {
    let files = [("Sail.msg", SAIL), ("Boat.msg", BOAT), ("RigStatus.msg", RIG_STATUS), ("Order.msg", ORDER)];
    let mut reversed = files;
    reversed.reverse();
    assert_eq!(book(&[("boats", PX4, &files)]), book(&[("boats", PX4, &reversed)]));
}

#[test]
fn draws_small_well_formed_pictures() {
    let files = boats();
    let pictures: Vec<&OutputFile> = files.iter().filter(|file| is(file, "svg")).collect();
    assert_eq!(pictures.len(), 4);
    for picture in pictures {
        assert_well_formed(&picture.text);
        assert!(picture.text.len() < 8_000, "{}: {} bytes", picture.path, picture.text.len());
    }
    let sail = text_of(&files, "boats/Sail.svg");
    assert!(sail.contains("<title>Memory layout of Sail: "), "{sail}");
    assert!(sail.contains("<title>float32 sheet_length [m]: 4 bytes at 8</title>"), "{sail}");
    assert!(text_of(&files, "boats/RigStatus.svg").contains("… 1,984 bytes more …"));
}

#[test]
fn draws_well_formed_pictures_of_unusual_layouts() {
    for text in [
        String::new(),
        "uint8 a\n".to_owned(),
        "uint16 a # [<&\"]\nuint8[7] b\nuint64[9] c\nuint32[3] d\n".to_owned(),
        (0..3000)
            .map(|index| format!("bool a_rather_long_name_of_a_flag_{index}"))
            .collect::<Vec<_>>()
            .join("\n"),
        "uint8[1000000] a\nuint8 b\n".to_owned(),
    ] {
        let files = book(&[("p", PX4, &[("Kite.msg", &text)])]);
        let picture = text_of(&files, "p/Kite.svg");
        assert_well_formed(picture);
    }
}

/// Checks that elements are closed in order, attributes are quoted, and `&` and `<` are escaped.
fn assert_well_formed(xml: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = xml.strip_prefix("<!-- ").and_then(|rest| rest.split_once("-->")).expect("a comment").1;
    while let Some((text, after)) = rest.split_once('<') {
        assert!(!text.contains('>') && is_escaped(text), "{text}");
        let (tag, after) = after.split_once('>').expect("an end of the tag");
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
            continue;
        }
        assert!(is_escaped(tag) && tag.matches('"').count() % 2 == 0, "{tag}");
        if !tag.ends_with('/') {
            open.push(tag.split(' ').next().unwrap_or_default());
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?}, {rest}");
}

fn is_escaped(text: &str) -> bool {
    let entities = ["amp;", "lt;", "gt;", "quot;"];
    text.split('&').skip(1).all(|rest| entities.iter().any(|entity| rest.starts_with(entity)))
}

/// The data of the composer on a page.
fn composer(page: &str) -> serde_json::Value {
    let (_, rest) = page.split_once("data-message=\"").expect("a composer");
    let (data, _) = rest.split_once('"').expect("an end");
    let text = data.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn embeds_the_data_of_the_composer() {
    let files = boats();
    let sail = composer(text_of(&files, "boats/Sail.md"));
    assert_eq!((&sail["name"], &sail["size"]), (&"Sail".into(), &144.into()));
    let field = |name: &str| {
        let fields = sail["fields"].as_array().expect("fields");
        fields.iter().find(|field| field["name"] == name).unwrap_or_else(|| panic!("{name} in {sail}"))
    };
    let length = field("sheet_length");
    assert_eq!(
        (&length["type"], &length["unit"], &length["group"]),
        (&"float32".into(), &"m".into(), &"Sheets".into())
    );
    assert_eq!(
        field("tack")["values"],
        serde_json::json!([["1", "PORT", "Wind from the left"], ["2", "STARBOARD", ""]])
    );
    assert_eq!(field("state")["flags"][1], serde_json::json!(["4", "TORN", ""]));
    assert_eq!((&field("maker")["type"], &field("maker")["count"]), (&"text".into(), &12.into()));
    let boats = field("boats");
    assert_eq!((&boats["count"], &boats["size"]), (&2.into(), &16.into()));
    assert_eq!(boats["fields"][1]["offset"], 8);
    // The data is plain text without Markdown escapes.
    let kite = composer(&one_message(
        "uint64 timestamp # [us] Time\nfloat32 pull # [V*s] Pull\nuint8 knots # [-] Knots\n",
    ));
    assert_eq!(kite["fields"][1]["unit"], "V*s");
    assert_eq!(kite["fields"][2].get("unit"), None);
    // A message without fields or without a layout has no composer.
    assert!(!one_message("uint8 TOW = 1\n").contains("composer"));
}

#[test]
fn message_pages_show_the_history_in_the_releases() {
    let release = |name: &str, definitions: &[(&str, &str)]| {
        let definition = |(kind, text): &(&str, &str)| format!("{}\n{kind}/{text}", "=".repeat(80));
        ReleaseText { name: name.to_owned(), text: definitions.iter().map(definition).collect() }
    };
    let old = ("MSG: boats/msg", "Boat\nuint64 timestamp\nfloat32 speed # [m/s]\n");
    let new = ("MSG: boats/msg", "Boat\nuint64 timestamp\nfloat32 speed # [m/s]\nbool is_moored\n");
    let tow = ("SRV: boats/srv", "Tow\nuint64 timestamp\n---\nuint64 timestamp\n");
    let releases = vec![release("1.9", &[old]), release("1.10", &[new, tow]), release("main", &[new, tow])];
    let options =
        Options { releases: Releases::from([("boats".to_owned(), releases)]), ..Options::default() };
    let form = Form::Msg(Dialect::Px4);
    let boat = "uint64 timestamp\nfloat32 speed # [m/s]\n";
    let files =
        [("Boat.msg", boat), ("Mast.msg", boat), ("Tow.srv", "uint64 timestamp\n---\nbool is_done\n")];
    let book = book_with(&[("boats", form, &files)], &options);
    let history = |path: &str| {
        let page = book.iter().find(|file| file.path == path).expect("a page");
        page.text.split_once("## History\n").map(|(_, history)| history.to_owned())
    };
    let boat = history("boats/Boat.md").expect("a history");
    assert!(boat.contains("\nThis page shows the fields of `1.9`.\n"), "{boat}");
    assert!(
        boat.contains("\n| `1.9` | oldest known release |\n| `1.10` | `is_moored` (bool) was added |"),
        "{boat}"
    );
    assert!(boat.contains("\n| `main` | no changes |\n"), "{boat}");
    let tow = history("boats/Tow.srv.md").expect("a history");
    assert!(tow.contains("\nNo release has exactly the fields on this page.\n"), "{tow}");
    assert!(tow.contains("\n| `1.10` | the service `Tow` was added |\n"), "{tow}");
    assert_eq!(history("boats/Mast.md"), None);
}
