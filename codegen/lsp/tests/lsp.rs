//! Tests of the language server, driven by an editor in the same process.

mod editor;
mod events;
mod growth;

use std::fs;

use serde_json::{Value, json};

use self::editor::Editor;
pub(crate) use self::growth::edit_all;

const CONFIG: &str = "[lint]\npreset = \"strict\"\n\n[[package]]\nname = \"glide\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\nselect = [\"Tow\", \"Mark\"]\n";

const MARK: &str = "# A turning point\n\nuint64 timestamp  # [us] Time since system start\nfloat32 height  # [m] [@range 0, 9000] Height of the point\n";

const TOW: &str = "\
# A tow

uint32 MESSAGE_VERSION = 2

uint64 timestamp  # [us] Time since system start

uint8 PHASE_IDLE = 0  # On the ground
uint8 PHASE_LIFT = 1  # Lifting off

uint8 phase  # [@enum PHASE] Phase of the tow
Mark[3] marks  # Turning points
uint8 num_marks  # [@count marks] Used turning points
";

const WINCH: &str = "# A winch\n\nuint64 timestamp  # [us] Time since system start\nuint8 phase  # [@enum Tow.PHASE] Phase of the tow\nfloat32 force  # [N] Force in the cable\n";

const PX4: &[(&str, &str)] = &[("uavspec.toml", CONFIG), ("msg/Mark.msg", MARK), ("msg/Tow.msg", TOW)];

fn with_winch() -> Vec<(&'static str, &'static str)> {
    let config = "[[package]]\nname = \"glide\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\n";
    vec![("uavspec.toml", config), ("msg/Mark.msg", MARK), ("msg/Tow.msg", TOW), ("msg/Winch.msg", WINCH)]
}

/// Two ROS packages. One package uses the other.
const ROS: &[(&str, &str)] = &[
    ("src/sky_msgs/msg/Mark.msg", "# A turning point\n\nfloat64 height  # [m] Height\n"),
    (
        "src/tow_msgs/msg/Tow.msg",
        "# A tow\n\nsky_msgs/Mark[<=3] marks  # Turning points\nstring<=10 name \"tüp 𝄞\"  # Name\nuint8 num  # [@count marks] Used\n",
    ),
    ("src/tow_msgs/srv/Start.srv", "Tow tow  # The tow\n---\nsky_msgs/Mark at  # Where\n"),
];

const PAGE: &str = "\
# Errors

## Warnings (codes 64-127)

| Code | Abbr | Description |
|-----:|------|-------------|
| 64 | LOW | Battery low. Use this code only if full; otherwise use code 66 |
| 66 | LOWER | Battery lower. Use this code only if empty; otherwise use code 64 |

## Wind

| Field | Required | Type | Description |
|---|---|---|---|
| speed | yes | number | [m/s] Speed |
| next | no | Wind | The wind after |
";

#[test]
fn findings_follow_the_text_of_open_documents() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Mark.msg");
    editor.expect_codes("msg/Mark.msg", &[]);
    editor.edit("msg/Mark.msg", "float32 height", "float32 heigh\nfloat3");
    editor.expect_codes("msg/Mark.msg", &["missing-name"]);
    let found = &editor.diagnostics("msg/Mark.msg")[0];
    assert_eq!((&found["severity"], &found["source"]), (&json!(1), &json!("uavspec")));
    assert_eq!(found["range"]["start"], json!({ "line": 4, "character": 0 }));
    editor.edit("msg/Mark.msg", "float32 heigh\nfloat3", "float32 height");
    editor.expect_codes("msg/Mark.msg", &[]);
    // Once a document is closed, its file is read.
    editor.open("msg/Tow.msg");
    editor.edit("msg/Tow.msg", "Mark[3]", "Marks[3]");
    editor.expect_codes("msg/Tow.msg", &["unknown-type", "unknown-count-target"]);
    editor.close("msg/Tow.msg");
    editor.expect_codes("msg/Tow.msg", &[]);
}

#[test]
fn files_that_change_are_read_again() {
    let mut editor = Editor::new(PX4);
    editor.expect_codes("msg/Tow.msg", &[]);
    fs::remove_file(editor.path("msg/Mark.msg")).expect("removed");
    editor.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    editor.expect_codes("uavspec.toml", &["unknown-type"]);
    fs::write(editor.path("msg/Mark.msg"), MARK).expect("written");
    editor.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    editor.expect_codes("uavspec.toml", &[]);
}

#[test]
fn errors_in_the_configuration_are_reported_there() {
    let mut editor = Editor::new(PX4);
    editor.open("uavspec.toml");
    editor.edit("uavspec.toml", "dialect = \"px4\"", "dialect = \"px5\"");
    editor.expect_codes("uavspec.toml", &[""]);
    let message = editor.diagnostics("uavspec.toml")[0]["message"].as_str().expect("a text").to_owned();
    assert!(message.contains("px5"), "{message}");
    editor.edit("uavspec.toml", "px5", "px4");
    editor.expect_codes("uavspec.toml", &[]);
}

#[test]
fn columns_count_in_the_units_of_the_editor() {
    let place = |editor: &mut Editor| {
        editor.open("src/tow_msgs/msg/Tow.msg");
        // The unknown unit follows strings with characters of two and four bytes.
        editor.edit("src/tow_msgs/msg/Tow.msg", "  # Name", "  # [parsec] Näme");
        editor.expect_codes("src/tow_msgs/msg/Tow.msg", &["unknown-unit"]);
        editor.diagnostics("src/tow_msgs/msg/Tow.msg")[0]["range"]["start"]["character"].clone()
    };
    let mut utf16 = Editor::new(ROS);
    assert_eq!(place(&mut utf16), json!(28));
    assert_eq!(utf16.initialized["capabilities"]["positionEncoding"], json!("utf-16"));
    let general = json!({ "general": { "positionEncodings": ["utf-8", "utf-16"] } });
    let utf8 = Editor::with_capabilities(ROS, &general);
    assert_eq!(utf8.initialized["capabilities"]["positionEncoding"], json!("utf-8"));
}

#[test]
fn texts_describe_the_item_under_the_cursor() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Tow.msg");
    editor.open("msg/Mark.msg");
    for (path, place, expected) in [
        (
            "msg/Mark.msg",
            "hei^ght",
            &[
                "`float32 height`",
                "Height of the point",
                "unit: m (metres)",
                "range: 0 to 9000",
                "offset 8, 4 of 16 bytes",
                "since 1.0: glide/msg/Mark height",
            ][..],
        ),
        (
            "msg/Tow.msg",
            "Ma^rk[3]",
            &["`glide/Mark`", "A turning point", "uORB size: 16 bytes", "hash: 0x", "type hash: RIHS01"],
        ),
        ("msg/Tow.msg", "uint8 pha^se", &["Phase of the tow", "`PHASE_LIFT` | 1 | Lifting off"]),
        ("msg/Tow.msg", "PHASE_LI^FT", &["`PHASE_LIFT = 1`", "Lifting off", "value of: `phase`"]),
        ("msg/Tow.msg", "[@enum PH^ASE]", &["`Tow.PHASE`", "`PHASE_IDLE` | 0 | On the ground"]),
        ("msg/Tow.msg", "[@co^unt", &["[@count field]"]),
        ("msg/Tow.msg", "[u^s]", &["`[us]`", "microseconds"]),
    ] {
        let text = editor.hover(path, place).replace('\\', "");
        for part in expected {
            assert!(text.contains(part), "{place}: {part} in {text}");
        }
    }
    editor.edit("msg/Tow.msg", "# Turning points", "# Turning points uavspec:ignore unit-missing why");
    assert!(editor.hover("msg/Tow.msg", "ignore unit-mis^sing").contains("unit-missing"));
    assert_eq!(editor.hover("msg/Tow.msg", "On the gro^und"), "", "plain text");
    editor.edit("msg/Mark.msg", "[@range 0, 9000]", "[@range -inf, inf]");
    let text = editor.hover("msg/Mark.msg", "hei^ght");
    assert!(text.contains("Height of the point") && !text.contains("empty"), "{text}");
}

#[test]
fn hover_of_a_constant_names_the_fields_of_its_enum() {
    let winch = "uint64 timestamp  # [us] Time\nuint8 PHASE_IDLE = 0  # Idle\nuint8 PHASE_REEL_IN = 1  # In\n\
        uint8 PHASE_REEL_OUT = 2  # Out\nuint8 phase  # [@enum PHASE] Phase\nuint8 reel  # [@enum PHASE_REEL] Reel\n";
    let gauge = "uint64 timestamp  # [us] Time\nuint8 phase  # [@enum Winch.PHASE] Phase of the winch\n";
    let files = [with_winch()[0], ("msg/Winch.msg", winch), ("msg/Gauge.msg", gauge)];
    let mut editor = Editor::new(&files);
    for path in ["msg/Winch.msg", "msg/Gauge.msg"] {
        editor.open(path);
    }
    let mut users = |place: &str| {
        let text = editor.hover("msg/Winch.msg", place).replace('\\', "");
        let users = text.lines().find_map(|line| line.split_once("value of: "));
        users.unwrap_or_else(|| panic!("no fields in {text:?}")).1.to_owned()
    };
    assert_eq!(users("PHASE_ID^LE"), "`Gauge.phase`, `phase`");
    assert_eq!(users("PHASE_REEL_^OUT"), "`reel`");
}

#[test]
fn definitions_and_references_cross_packages() {
    let mut editor = Editor::new(ROS);
    let (tow, start) = ("src/tow_msgs/msg/Tow.msg", "src/tow_msgs/srv/Start.srv");
    editor.open(tow);
    editor.open(start);
    let definition = editor.at("definition", start, "sky_msgs/Ma^rk", json!({})).expect("an answer");
    assert_eq!(definition["uri"], json!(editor.uri("src/sky_msgs/msg/Mark.msg")));
    let definition = editor.at("definition", tow, "@count mar^ks", json!({})).expect("an answer");
    assert_eq!(definition["range"]["start"], json!({ "line": 2, "character": 19 }));
    let mut places = |path: &str, place: &str, with_definition: bool| -> Vec<(String, u64)> {
        let context = json!({ "context": { "includeDeclaration": with_definition } });
        let found = editor.at("references", path, place, context).expect("an answer");
        let place = |found: &Value| {
            let name =
                found["uri"].as_str().expect("a URI").rsplit('/').next().unwrap_or_default().to_owned();
            (name, found["range"]["start"]["line"].as_u64().expect("a number"))
        };
        found.as_array().expect("a list").iter().map(place).collect()
    };
    let at = |name: &str, line| (name.to_owned(), line);
    assert_eq!(places(start, "sky_msgs/Ma^rk", false), [at("Tow.msg", 2), at("Start.srv", 2)]);
    assert_eq!(places(start, "sky_msgs/Ma^rk", true).len(), 3);
    assert_eq!(places(tow, "^marks  #", true), [at("Tow.msg", 2), at("Tow.msg", 4)]);
    assert_eq!(places(start, "T^ow tow", false), [at("Start.srv", 0)]);
}

#[test]
fn a_constant_is_referenced_by_its_prefix() {
    let mut editor = Editor::new(&with_winch());
    editor.open("msg/Tow.msg");
    let context = json!({ "context": { "includeDeclaration": true } });
    let found = editor.at("references", "msg/Tow.msg", "PHASE_LI^FT", context).expect("an answer");
    assert_eq!(found.as_array().map(Vec::len), Some(3), "{found}");
}

#[test]
fn a_rename_changes_every_place() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Tow.msg");
    editor.edit("msg/Tow.msg", "uint32 MESSAGE_VERSION = 2\n\n", "");
    let name = |name: &str| json!({ "newName": name });
    let field = editor.at("rename", "msg/Tow.msg", "^marks  #", name("points")).expect("renamed");
    let edits = &field["documentChanges"][0]["edits"];
    let text = editor.apply("msg/Tow.msg", edits);
    assert_eq!(
        text,
        editor.text("msg/Tow.msg").replace(" marks  ", " points  ").replace("@count marks", "@count points")
    );
    let constant = editor.at("rename", "msg/Tow.msg", "PHASE_LI^FT", name("PHASE_UP")).expect("renamed");
    assert_eq!(constant["documentChanges"][0]["edits"].as_array().map(Vec::len), Some(1));
    let message = editor.at("rename", "msg/Tow.msg", "Ma^rk[3]", name("Point")).expect("renamed");
    let changes = message["documentChanges"].as_array().expect("changes");
    let uris: Vec<&Value> = changes.iter().map(|change| &change["textDocument"]["uri"]).collect();
    assert_eq!(uris[..2], [&json!(editor.uri("uavspec.toml")), &json!(editor.uri("msg/Tow.msg"))]);
    assert_eq!(
        changes[0]["edits"][0]["range"]["start"],
        json!({ "line": 7, "character": 18 }),
        "in `select`"
    );
    assert_eq!(changes[2]["kind"], json!("rename"));
    assert_eq!(changes[2]["newUri"], json!(editor.uri("msg/Point.msg")));
}

#[test]
fn a_rename_is_refused_with_a_reason() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Tow.msg");
    for (place, name, reason) in [
        ("uint8 pha^se", "stage", "version"),
        ("Ma^rk[3]", "Point", "version"),
        ("^marks  #", "timestamp", "duplicate field"),
        ("^marks  #", "no name", "not a valid name"),
        ("PHASE_LI^FT", "STAGE_LIFT", "keep its prefix"),
        ("Ma^rk[3]", "Tow", "exists"),
        ("[@enum PH^ASE]", "STAGE", "prefix"),
        ("# A ^tow", "b", "no name here"),
    ] {
        let error = editor.at("rename", "msg/Tow.msg", place, json!({ "newName": name }));
        let error = error.expect_err(place);
        assert!(error.contains(reason), "{place}: {error}");
    }
    let whole = editor.at("prepareRename", "msg/Tow.msg", "^marks  #", json!({})).expect("a name");
    assert_eq!(whole["placeholder"], json!("marks"));
    let mut simple = Editor::with_capabilities(PX4, &json!({}));
    simple.open("msg/Tow.msg");
    let error = simple.at("rename", "msg/Tow.msg", "Ma^rk[3]", json!({ "newName": "Point" }));
    assert!(error.expect_err("refused").contains("rename files"));
}

#[test]
fn items_complete_what_is_typed() {
    let mut editor = Editor::new(&with_winch());
    let path = "msg/Mark.msg";
    editor.open(path);
    editor.edit(path, "float32 height", "^\nfloat32 height");
    let mut typed = "^".to_owned();
    for (new, label, line) in [
        ("T^", "Tow", "Tow"),
        ("uin^", "uint8", "uint8"),
        ("uint8 a  # [m^", "m/s", "uint8 a  # [m/s"),
        ("uint8 a  # [^", "@range", "uint8 a  # [@range ${1:low}, ${2:high}"),
        ("uint8 a  # [@fra^", "@frame", "uint8 a  # [@frame ${1:name}"),
        ("uint8 a  # [@enum ^", "Tow.", "uint8 a  # [@enum Tow."),
        ("uint8 a  # [@enum \u{a0}^", "Tow.", "uint8 a  # [@enum \u{a0}Tow."),
        ("uint8 a  # [@enum Tow.^", "PHASE", "uint8 a  # [@enum Tow.PHASE"),
        ("uint8 a  # [@frame N^", "NED", "uint8 a  # [@frame NED"),
        ("uint8 a  # [@invalid ^", "NaN", "uint8 a  # [@invalid NaN"),
        ("# TOPICS ^", "mark", "# TOPICS mark"),
        ("uint8 a  # uavspec:ignore unit^", "unit-missing", "uint8 a  # uavspec:ignore unit-missing"),
    ] {
        editor.edit(path, &typed, new.trim_end_matches('^'));
        new.trim_end_matches('^').clone_into(&mut typed);
        let place = format!("{new}\nfloat32");
        let items = editor.at("completion", path, &place, json!({})).expect("an answer");
        let item = items.as_array().expect("a list").iter().find(|item| item["label"] == json!(label));
        let item = item.unwrap_or_else(|| panic!("{new}: {items}"));
        let text = editor.apply(path, &json!([item["textEdit"]]));
        assert!(text.lines().any(|found| found == line), "{new}: {text}");
        typed.push_str("\nfloat32");
        editor.edit(path, &typed, "^\nfloat32");
        "^".clone_into(&mut typed);
    }
    editor.edit(path, &typed, "uint8 ");
    let items = editor.at("completion", path, "uint8 ^\n", json!({})).expect("an answer");
    assert_eq!(items, json!([]), "names of fields are free");
}

#[test]
fn items_without_placeholders_suit_simple_editors() {
    let mut editor = Editor::with_capabilities(PX4, &json!({}));
    editor.open("msg/Mark.msg");
    editor.edit("msg/Mark.msg", "[@range 0, 9000]", "[@");
    let items = editor.at("completion", "msg/Mark.msg", "[@^", json!({})).expect("an answer");
    let texts: Vec<&Value> =
        items.as_array().expect("a list").iter().map(|item| &item["textEdit"]["newText"]).collect();
    assert!(texts.contains(&&json!("@range")), "{texts:?}");
}

#[test]
fn pages_have_the_same_features() {
    let config = "[[package]]\nname = \"sky\"\ndialect = \"table\"\ninclude = [\"*.md\"]\n";
    for files in [vec![("uavspec.toml", config), ("page.md", PAGE)], vec![("page.md", PAGE)]] {
        let mut editor = Editor::new(&files);
        editor.open("page.md");
        let text = editor.hover("page.md", "| 6^4 |");
        assert!(
            text.contains("`64 LOW`") && text.contains("Battery low") && text.contains("`66 LOWER`"),
            "{text}"
        );
        let definition = editor.at("definition", "page.md", "use code 6^6", json!({})).expect("an answer");
        assert_eq!(definition["range"]["start"], json!({ "line": 7, "character": 2 }));
        let renamed =
            editor.at("rename", "page.md", "## Wi^nd", json!({ "newName": "Breeze" })).expect("renamed");
        let text = editor.apply("page.md", &renamed["documentChanges"][0]["edits"]);
        assert_eq!(text, PAGE.replace("Wind", "Breeze"));
        let error =
            editor.at("rename", "page.md", "| 6^4 |", json!({ "newName": "65" })).expect_err("refused");
        assert!(error.contains("permanent"), "{error}");
        editor.edit("page.md", "| The wind after |", "| See code ");
        let mut labels = |place: &str| -> Vec<String> {
            let items = editor.at("completion", "page.md", place, json!({})).expect("an answer");
            let labels = items.as_array().expect("a list").iter();
            labels.map(|item| item["label"].as_str().unwrap_or_default().to_owned()).collect()
        };
        assert_eq!(labels("See code ^"), ["64", "66"]);
        assert!(labels("| no | Wi^nd").contains(&"Wind".to_owned()));
        let symbols = editor.about("documentSymbol", "page.md", json!({})).expect("an answer");
        assert_eq!(symbols[0]["children"][0]["children"][1]["detail"], json!("LOWER"));
    }
}

#[test]
fn a_quick_fix_changes_only_its_finding() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Mark.msg");
    editor.edit("msg/Mark.msg", "# [m] ", "# [meters] ");
    editor.edit("msg/Mark.msg", "# [us] ", "# [usec] ");
    editor.expect_codes("msg/Mark.msg", &["unit-alias", "unit-alias"]);
    let range = json!({ "start": { "line": 3, "character": 20 }, "end": { "line": 3, "character": 20 } });
    let params = |only: &str| json!({ "range": range, "context": { "diagnostics": [], "only": [only] } });
    let actions = editor.about("codeAction", "msg/Mark.msg", params("quickfix")).expect("an answer");
    let [action] = actions.as_array().expect("a list").as_slice() else { panic!("{actions}") };
    assert_eq!(action["title"], json!("Fix unit-alias: write `[m]`"));
    let uri = editor.uri("msg/Mark.msg");
    let text = editor.apply("msg/Mark.msg", &action["edit"]["changes"][&uri]);
    assert_eq!(text, MARK.replace("[us]", "[usec]"));
    let actions = editor.about("codeAction", "msg/Mark.msg", params("source")).expect("an answer");
    let text = editor.apply("msg/Mark.msg", &actions[0]["edit"]["changes"][&uri]);
    assert_eq!(text, MARK);
}

#[test]
fn formatting_changes_only_lines_that_differ() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Mark.msg");
    editor.edit("msg/Mark.msg", "uint64 timestamp  #", "uint64   timestamp    #");
    let options = json!({ "options": { "tabSize": 4, "insertSpaces": true } });
    let edits = editor.about("formatting", "msg/Mark.msg", options.clone()).expect("an answer");
    assert_eq!(edits[0]["range"]["start"]["line"], json!(2));
    let formatted = editor.apply("msg/Mark.msg", &edits);
    assert!(formatted.contains("uint64 timestamp  # [us]"), "{formatted}");
    editor.edit("msg/Mark.msg", "uint64   timestamp", "uint64");
    assert_eq!(editor.about("formatting", "msg/Mark.msg", options), Ok(Value::Null), "errors come first");
}

#[test]
fn hints_show_the_memory_layout() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Mark.msg");
    let all =
        json!({ "range": { "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } } });
    let hints = editor.about("inlayHint", "msg/Mark.msg", all).expect("an answer");
    let labels: Vec<&Value> = hints.as_array().expect("a list").iter().map(|hint| &hint["label"]).collect();
    assert_eq!(labels, [&json!("@0"), &json!("@8, then 4 padding")]);
    assert_eq!(hints[1]["position"], json!({ "line": 3, "character": 14 }));
    let document = json!({ "textDocument": { "uri": editor.uri("msg/Mark.msg") } });
    let pictures = editor.request("uavspec/layout", document).expect("an answer");
    assert_eq!(pictures[0]["name"], json!("Mark"));
    assert!(pictures[0]["svg"].as_str().is_some_and(|svg| svg.contains("<svg") && svg.contains("height")));
}

#[test]
fn outlines_folds_and_tokens_follow_the_structure() {
    let mut editor = Editor::new(PX4);
    editor.open("msg/Tow.msg");
    let symbols = editor.about("documentSymbol", "msg/Tow.msg", json!({})).expect("an answer");
    let names: Vec<&str> = symbols[0]["children"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|child| child["name"].as_str())
        .collect();
    assert_eq!(
        names,
        ["MESSAGE_VERSION", "timestamp", "PHASE_IDLE", "PHASE_LIFT", "phase", "marks", "num_marks"]
    );
    let found = editor.request("workspace/symbol", json!({ "query": "PHASE_l" })).expect("an answer");
    assert_eq!(found[0]["name"], json!("PHASE_LIFT"));
    let folds = editor.about("foldingRange", "msg/Tow.msg", json!({})).expect("an answer");
    assert_eq!(folds[0], json!({ "startLine": 6, "endLine": 7, "kind": "region" }));
    let tokens = editor.about("semanticTokens/full", "msg/Tow.msg", json!({})).expect("an answer");
    let legend = &editor.initialized["capabilities"]["semanticTokensProvider"]["legend"]["tokenTypes"];
    let numbers: Vec<u64> =
        tokens["data"].as_array().expect("a list").iter().filter_map(Value::as_u64).collect();
    let (mut line, mut column) = (0, 0);
    let text = editor.text("msg/Tow.msg");
    let mut found = Vec::new();
    for token in numbers.chunks(5) {
        column = if token[0] == 0 { column + token[1] } else { token[1] };
        line += token[0];
        let [start, len] = [column, token[2]].map(|number| usize::try_from(number).expect("small"));
        let line = text.lines().nth(usize::try_from(line).expect("small")).expect("a line");
        let kind = legend[usize::try_from(token[3]).expect("small")].as_str().expect("a name");
        found.push((line[start..start + len].to_owned(), kind));
    }
    for expected in [
        ("uint64", "type"),
        ("timestamp", "property"),
        ("[us]", "decorator"),
        ("PHASE_IDLE", "enumMember"),
        ("0", "number"),
        ("Mark", "struct"),
        ("marks", "property"),
        ("PHASE", "enumMember"),
        ("# A tow", "comment"),
    ] {
        assert!(found.contains(&(expected.0.to_owned(), expected.1)), "{expected:?} in {found:?}");
    }
}

#[test]
fn folders_without_a_configuration_are_searched() {
    let px4 = [
        ("msg/Mark.msg", MARK),
        ("msg/versioned/Tow.msg", TOW),
        ("build/CMakeCache.txt", ""),
        ("build/msg/Tow.msg", "uint8 copy\n"),
    ];
    let mut editor = Editor::new(&px4);
    editor.open("msg/versioned/Tow.msg");
    editor.expect_codes("msg/versioned/Tow.msg", &[]);
    assert!(editor.hover("msg/versioned/Tow.msg", "Ma^rk[3]").contains("px4/Mark"));
    // A document that was never saved.
    editor.open_with("msg/New.msg", "# New\n\nuint64 timestamp  # [us] Time\nMark first  # Mark\n");
    assert!(editor.hover("msg/New.msg", "Ma^rk first").contains("px4/Mark"));
    // A reference to a package outside the workspace is not a mistake in the definition.
    let mut ros = Editor::new(&[("one_msgs/msg/A.msg", "# A\n\nrope_msgs/Rope rope  # Where\n")]);
    ros.expect_codes("one_msgs/msg/A.msg", &["unknown-package"]);
    assert_eq!(ros.diagnostics("one_msgs/msg/A.msg")[0]["severity"], json!(3));
}

#[test]
fn a_document_outside_the_workspace_opens_its_own_project() {
    let other = Editor::new(PX4);
    let outside = other.path("msg/Tow.msg");
    let mut editor = Editor::new(&[]);
    let relative = outside.to_string_lossy().into_owned();
    editor.open_with(&relative, TOW);
    assert!(editor.hover(&relative, "Ma^rk[3]").contains("glide/Mark"));
}

#[test]
fn invalid_messages_are_answered_with_errors() {
    let mut editor = Editor::new(PX4);
    assert!(editor.request("wind/speed", json!({})).expect_err("unknown").contains("unknown request"));
    assert!(
        editor.request("textDocument/hover", json!({})).expect_err("no document").contains("textDocument")
    );
    assert!(editor.request("textDocument/hover", json!([1, "a"])).is_err());
    editor.notify("textDocument/didChange", json!({ "textDocument": 7 }));
    let other = json!({ "textDocument": { "uri": "untitled:1" }, "position": { "line": 0, "character": 0 } });
    assert_eq!(editor.request("textDocument/hover", other), Ok(Value::Null));
    editor.open("msg/Tow.msg");
    let far = json!({ "line": 4_000_000_000_u32, "character": 4_000_000_000_u32 });
    assert_eq!(editor.about("hover", "msg/Tow.msg", json!({ "position": far })), Ok(Value::Null));
}

#[test]
fn a_rename_changes_the_references_in_annotations() {
    let gauge = "\
# A gauge

uint64 timestamp  # [us] Time since system start

uint8 LEVEL_NONE = 255  # No level

uint8 axes  # Axes of the force
uint8 level  # [@invalid LEVEL_NONE] Level
float32[3] force  # [N] [@frame @axes] Force
uint8 BODY = 1
float32[3] drag  # [N] [@frame @BODY] Drag
float32[4] marks  # [m] Marks
uint8 num_marks  # Used marks
";
    let path = "msg/Gauge.msg";
    let mut editor = Editor::new(&[with_winch()[0], (path, gauge)]);
    editor.open(path);
    let mut rename = |place: &str, name: &str| -> Result<String, String> {
        let renamed = editor.at("rename", path, place, json!({ "newName": name }))?;
        Ok(editor.apply(path, &renamed["documentChanges"][0]["edits"]))
    };
    let constant = gauge.replace("LEVEL_NONE", "LEVEL_UNKNOWN");
    assert_eq!(rename("LEVEL_NO^NE = 255", "LEVEL_UNKNOWN"), Ok(constant.clone()));
    assert_eq!(rename("@invalid LEVEL_NO^NE", "LEVEL_UNKNOWN"), Ok(constant));
    assert_eq!(rename("uint8 ax^es", "frame"), Ok(gauge.replace("axes", "frame")));
    // A constant without a comment gets a dissimilar name, so it looks like a different constant.
    assert_eq!(rename("BO^DY = 1", "HULL"), Ok(gauge.replace("BODY", "HULL")));
    // The name of a field determines the array that it counts.
    for (place, name, reason) in [
        (
            "float32[4] mar^ks",
            "points",
            "`num_marks` would no longer count `marks`: first write `[@count marks]` in the comment of the count field",
        ),
        (
            "uint8 num_mar^ks",
            "used",
            "`used` would no longer count `marks`: first write `[@count marks]` in the comment of the count field",
        ),
        (
            "uint8 num_mar^ks",
            "num_force",
            "`num_force` would count `force` instead of `marks`: first write `[@count marks]` in the comment of the count field",
        ),
        ("uint8 ax^es", "num_force", "`num_force` would count `force`: choose a different name"),
    ] {
        assert_eq!(rename(place, name), Err(reason.to_owned()), "{place}");
    }
}

#[test]
fn errors_of_unreadable_files_are_reported_there() {
    let mut editor = Editor::new(&with_winch());
    let files = json!({ "changes": [] });
    fs::write(editor.path("msg/Tow.msg"), b"# A tow\n# \xff\n").expect("written");
    editor.notify("workspace/didChangeWatchedFiles", files);
    editor.expect_codes("msg/Tow.msg", &["invalid-utf8"]);
    // The error keeps its location if the preceding file becomes longer.
    editor.open("msg/Mark.msg");
    editor.edit("msg/Mark.msg", "# [m] ", "# [parsec] ");
    editor.expect_codes("msg/Mark.msg", &["unknown-unit"]);
    editor.hover("msg/Mark.msg", "hei^ght");
    let place = &editor.diagnostics("msg/Tow.msg")[0]["range"]["start"];
    assert_eq!(place, &json!({ "line": 1, "character": 2 }));
    // The file is read as soon as its text is valid.
    editor.open_with("msg/Tow.msg", TOW);
    editor.expect_codes("msg/Tow.msg", &[]);
    assert!(editor.hover("msg/Tow.msg", "Ma^rk[3]").contains("glide/Mark"));
}

#[test]
fn a_configuration_file_determines_the_findings_of_its_files() {
    let config = "[lint]\nlevels = { unknown-unit = \"off\" }\n\n".to_owned() + with_winch()[0].1;
    let mark = MARK.replace("[m]", "[parsec]");
    // A folder within another folder is added to the workspace.
    let mut editor = Editor::new(&[("inner/msg/Mark.msg", mark.as_str())]);
    editor.expect_codes("inner/msg/Mark.msg", &["unknown-unit"]);
    fs::write(editor.path("inner/uavspec.toml"), &config).expect("written");
    let added = json!([{ "uri": editor.uri("inner"), "name": "inner" }]);
    let event = json!({ "event": { "added": added, "removed": [] } });
    editor.notify("workspace/didChangeWorkspaceFolders", event);
    editor.expect_codes("inner/msg/Mark.msg", &[]);
    // A configuration file is added, and later removed.
    let mut editor = Editor::new(&[("msg/Mark.msg", mark.as_str())]);
    editor.expect_codes("msg/Mark.msg", &["unknown-unit"]);
    fs::write(editor.path("uavspec.toml"), &config).expect("written");
    editor.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    editor.expect_codes("msg/Mark.msg", &[]);
    fs::remove_file(editor.path("uavspec.toml")).expect("removed");
    editor.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    editor.expect_codes("msg/Mark.msg", &["unknown-unit"]);
}

#[test]
fn packages_that_a_configuration_only_refers_to_keep_their_findings() {
    let tow = "src/tow_msgs/msg/Tow.msg";
    let (mark, gust) = ("src/sky_msgs/msg/Mark.msg", "src/sky_msgs/msg/Gust.msg");
    let config = "[lint]\nlevels = { unknown-unit = \"off\" }\n\n[[package]]\nname = \"tow_msgs\"\n\
                  dialect = \"ros2\"\ninclude = [\"msg/*.msg\"]\n";
    let mut editor = Editor::new(&[
        ("src/tow_msgs/uavspec.toml", config),
        (tow, "# A tow\n\nsky_msgs/Mark mark  # Mark\nfloat64 speed  # [parsec] Speed\n"),
        (mark, "# A turning point\n\nfloat64 height  # [parsec] Height\n"),
        // No message of the configured package refers to this one.
        (gust, "# A gust\n\nfloat64 heading  # [NED] Heading\n"),
    ]);
    editor.expect_codes(tow, &["unknown-unit"]);
    editor.expect_codes(mark, &["unknown-unit"]);
    editor.expect_codes(gust, &["annotation-near-miss"]);
    let added = json!([{ "uri": editor.uri("src/tow_msgs"), "name": "tow_msgs" }]);
    let event = json!({ "event": { "added": added, "removed": [] } });
    editor.notify("workspace/didChangeWorkspaceFolders", event);
    editor.expect_codes(tow, &[]);
    editor.expect_codes(mark, &["unknown-unit"]);
    editor.expect_codes(gust, &["annotation-near-miss"]);
    // The quick fixes belong to the same findings.
    editor.open(gust);
    let range = json!({ "start": { "line": 2, "character": 20 }, "end": { "line": 2, "character": 20 } });
    let params = json!({ "range": range, "context": { "diagnostics": [], "only": ["quickfix"] } });
    let actions = editor.about("codeAction", gust, params).expect("an answer");
    assert_eq!(actions.as_array().map(Vec::len), Some(1), "{actions}");
}

#[test]
fn an_open_file_that_a_new_configuration_does_not_include_keeps_a_project() {
    let gust = "extra/Gust.msg";
    let text = MARK.replace("[m]", "[parsec]");
    let mut editor = Editor::new(&[("msg/Mark.msg", MARK), (gust, text.as_str())]);
    editor.open(gust);
    editor.expect_codes(gust, &["unknown-unit"]);
    // As long as the configuration contains a mistake, it may include the file.
    fs::write(editor.path("uavspec.toml"), "[").expect("written");
    editor.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    editor.expect_codes("uavspec.toml", &[""]);
    assert_eq!(editor.hover(gust, "hei^ght"), "");
    fs::write(editor.path("uavspec.toml"), with_winch()[0].1).expect("written");
    editor.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    assert!(editor.hover(gust, "hei^ght").contains("height"));
    editor.expect_codes("uavspec.toml", &[]);
    editor.expect_codes(gust, &["unknown-unit"]);
}

#[test]
fn a_package_is_read_as_soon_as_a_text_refers_to_it() {
    let path = "src/tow_msgs/msg/Tow.msg";
    let config =
        "[[package]]\nname = \"tow_msgs\"\ndialect = \"ros2\"\ninclude = [\"src/tow_msgs/msg/*.msg\"]\n";
    let mut editor = Editor::new(&[
        ("uavspec.toml", config),
        (path, "# A tow\n\nuint8 phase  # Phase\n"),
        ("src/sky_msgs/msg/Mark.msg", "# A turning point\n\nfloat64 height  # [m] Height\n"),
        ("src/std_msgs/msg/Header.msg", "# A header\n\nstring frame_id  # Frame\n"),
    ]);
    editor.open(path);
    editor.edit(path, "uint8 phase", "sky_msgs/Mark mark  # Mark\nuint8 phase");
    assert!(editor.hover(path, "sky_msgs/Ma^rk").contains("sky_msgs/Mark"));
    editor.edit(path, "uint8 phase", "Header header  # Header\nuint8 phase");
    assert!(editor.hover(path, "Hea^der header").contains("std_msgs/Header"));
    editor.expect_codes(path, &["not-portable"]);
    editor.edit(path, "Header header", "std_msgs/Header header");
    editor.edit(path, "uint8 phase", "rope_msgs/Rope rope  # Rope\nuint8 phase");
    editor.expect_codes(path, &["unknown-package"]);
    editor.edit(path, "rope_msgs/Rope", "sky_msgs/Mark");
    editor.expect_codes(path, &[]);
    // A built-in package.
    editor.edit(path, "uint8 phase", "nav_msgs/Odometry odometry  # Odometry\nuint8 phase");
    editor.expect_codes(path, &[]);
}
