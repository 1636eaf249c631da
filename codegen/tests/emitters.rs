//! Tests of the list of emitters.

use std::fs;

use uavspec_codegen::generate;
use uavspec_emit::EMITTERS;

use uavspec_test_definitions as support;

/// The error message for a configuration with this `output` table.
fn error_of(output: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("uavspec.toml");
    let package = "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n";
    fs::write(&config, format!("{package}[output]\n{output}\n")).expect("a file");
    fs::write(folder.path().join("Wind.msg"), "uint64 timestamp\n").expect("a file");
    generate(&config).expect_err(output).to_string()
}

#[test]
fn an_output_accepts_only_the_options_of_its_emitter() {
    for emitter in EMITTERS {
        let message = error_of(&format!("{} = {{ path = \"out\", bogus = 1 }}", emitter.name));
        let expected = match emitter.options().as_slice() {
            [] => "unknown field `bogus`, there are no fields".to_owned(),
            [(key, _)] => format!("unknown field `bogus`, expected `{key}`"),
            [(first, _), (second, _)] => format!("unknown field `bogus`, expected `{first}` or `{second}`"),
            options => {
                let keys: Vec<String> = options.iter().map(|(key, _)| format!("`{key}`")).collect();
                format!("unknown field `bogus`, expected one of {}", keys.join(", "))
            }
        };
        assert!(message.contains(&expected), "{}: {message}", emitter.name);
    }
}

#[test]
fn errors_in_outputs_are_shown_with_their_location() {
    for (output, expected) in [
        (
            "ruts = \"out\"",
            ["uavspec.toml:6:1", "unknown field `ruts`, expected one of `rust`, `json_schema`"],
        ),
        (
            "docs = 7",
            [
                "uavspec.toml:6:8",
                "expected a path, or a table with the keys `path`, `title`, `rules`, `contents`",
            ],
        ),
        ("docs = {}", ["uavspec.toml:6:8", "expected a path, or a table with the keys `path`, `title`"]),
        (
            "python = { path = 1 }",
            ["uavspec.toml:6:10", "expected a path, or a table with the keys `path`\n"],
        ),
        ("typescript = { path = \"o\", form = \"c\" }", ["uavspec.toml:6:14", "unknown variant `c`"]),
    ] {
        let message = error_of(output);
        assert!(expected.iter().all(|expected| message.contains(expected)), "{output}: {message}");
    }
}

/// Definitions in each dialect, with a translation and an earlier release.
const OWN: &[(&str, &str)] = &[
    (
        "my_msgs/Wind.msg",
        "# Wind\n\nuint8 KIND_GUST=1 # Gust\nuint64 timestamp # [us] Time\nuint8 kind # [@enum KIND] Kind\n",
    ),
    ("my_msgs/Mast.msg", "# Mast\n\nuint64 timestamp # [us] Time\nWind[2] winds # Winds\n"),
    ("my_msgs/Reef.srv", "# Reef\nuint8 sail # Sail\n---\nbool is_done # True if done\n"),
    ("newer/Wind.msg", "# Wind\n\nuint64 timestamp # [us] Time\nfloat32 speed # [m/s] Speed\n"),
    ("my_ros/msg/Boat.msg", "# Boat\nstring name # Name\nmy_ros/Sail[] sails # Sails\n"),
    ("my_ros/msg/Sail.msg", "# Sail\nfloat64 area # [m^2] Area\n"),
    (
        "my_ros/action/Tack.action",
        "# Tack\nbool to_port\n---\nbool is_done\n---\nfloat32 angle # [rad] Angle\n",
    ),
    (
        "codes.md",
        "# Errors\n\n## Warnings (64-127)\n\n| Code | Abbreviation | Description |\n|---|---|---|\n| 66 | WINCH | Rope slack |\n",
    ),
    (
        "uk.po",
        "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\nmsgctxt \"my_msgs/Wind\"\nmsgid \"Wind\"\n\
         msgstr \"Вітер\"\n",
    ),
    (
        "releases/1.0.msg",
        "========================================\nMSG: my_msgs/msg/Wind\nuint64 timestamp\n",
    ),
];

/// The packages of [`OWN`].
const OWN_PACKAGES: &str = "[[package]]\nname = \"my_msgs\"\ndialect = \"px4\"\ninclude = [\"my_msgs/*\"]\nreleases = \"releases\"\n\
    [[package]]\nname = \"newer\"\ndialect = \"px4\"\ninclude = [\"newer/*\"]\n\
    [[package]]\nname = \"my_ros\"\ndialect = \"ros2\"\ninclude = [\"my_ros/**/*\"]\n\
    [[package]]\nname = \"codes\"\ndialect = \"table\"\ninclude = [\"codes.md\"]\n\
    [[conversion]]\nfrom = \"my_msgs\"\nto = \"newer\"\n\
    [translations]\ninclude = [\"*.po\"]\n";

#[test]
fn own_packages_carry_their_own_names() {
    let folder = tempfile::tempdir().expect("a folder");
    for (path, text) in OWN {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    let config = folder.path().join("uavspec.toml");
    let outputs: String =
        EMITTERS.iter().map(|emitter| format!("{0}.path = \"out/{0}\"\n", emitter.name)).collect();
    for form in ["source", "compiled"] {
        fs::write(&config, format!("[output]\n{outputs}typescript.form = \"{form}\"\n{OWN_PACKAGES}"))
            .expect("a file");
        generate(&config).expect("output");
        let files = walkdir::WalkDir::new(folder.path().join("out")).into_iter();
        let files = files.filter_map(|entry| fs::read_to_string(entry.ok()?.path()).ok());
        let text = files.collect::<String>();
        for foreign in ["px4_msgs", "uavspec.dev"] {
            let found: Vec<&str> = text.lines().filter(|line| line.contains(foreign)).collect();
            assert!(found.is_empty(), "{form}: {found:?}");
        }
        for own in ["my_msgs/msg/Wind", "my_msgs/srv/Reef", "my_ros/msg/Boat", "codes/ErrorCode.schema.json"]
        {
            assert!(text.contains(own), "{form}: {own}");
        }
    }
}

/// Slashes in a string must not be confused with a documentation comment, which starts with `//` as well.
#[test]
fn constants_may_contain_slashes_before_any_character() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("uavspec.toml");
    let text = "[[package]]\nname = \"demo\"\ndialect = \"ros2\"\ninclude = [\"*.msg\"]\n[output]\nrust = { path = \"out\" }\n";
    fs::write(&config, text).expect("a file");
    let definition = "string A='//\u{e9}'\nstring B='//'\nstring C='https://example.org/\u{e9}'\n";
    fs::write(folder.path().join("Wind.msg"), definition).expect("a file");
    generate(&config).expect("output");
    let files = walkdir::WalkDir::new(folder.path().join("out"));
    let files = files.into_iter().filter_map(|entry| fs::read_to_string(entry.ok()?.path()).ok());
    let code: String = files.collect();
    for constant in ["\"//\u{e9}\"", "\"//\"", "\"https://example.org/\u{e9}\""] {
        assert!(code.contains(constant), "{constant} is missing:\n{code}");
    }
}

#[test]
fn error_codes_are_sorted_if_the_ranges_of_tables_overlap() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write(
        "uavspec.toml",
        "[[package]]\nname = \"demo\"\ndialect = \"table\"\ninclude = [\"*.md\"]\n[output]\nrust = { path = \"out\" }\n",
    );
    let table = |title: &str, rows: &str| format!("## {title}\n\n|Code|Abbr|Description|\n|-|-|-|\n{rows}\n");
    let pages = table("Warnings", "|64|FUEL|Low fuel|\n|66|WIND|Strong wind|\n")
        + &table("Battery warnings (codes 64-127)", "|65|BATT|Low battery|\n");
    write("codes.md", &pages);
    generate(folder.path().join("uavspec.toml")).expect("output");
    let files = support::files_below(&folder.path().join("out"), &["rs"]);
    let text: String = files.iter().map(|path| fs::read_to_string(path).expect("text")).collect();
    let entries = text.find("ENTRIES").expect("the entries");
    let at = |name: &str| text[entries..].find(name).expect("an entry");
    assert!(at("\"FUEL\"") < at("\"BATT\"") && at("\"BATT\"") < at("\"WIND\""), "{text}");
}
