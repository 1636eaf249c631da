//! Tests that labels are identical in JavaScript and Python. The cases include languages whose tags are keywords, and
//! flags with all bits.

use std::path::Path;

use super::tools::{python_with_tools, run, write, xtask};

const GLIDER: &str = "# A glider under way\n\nuint8 MODE_SOAR=1 # Soaring\nuint8 MODE_GLIDE=1 # The same\nuint8 MODE_DIVE=2\n\
                      uint64 MARK_FIRST=1 # First \"mark\" */ passed\nuint64 MARK_FAR=9223372036854775808 # Far mark\n\n\
                      uint64 timestamp # [us] Time since system start\nuint8 mode # [@enum MODE] What it does\n\
                      uint64 marks # [@flags MARK] Marks that it has passed\nint8 import\n";

const TOW: &str = "# A tow\n\nuint64 timestamp # [us] Time since system start\n\
                   uint8[2] mode # [@enum Glider.MODE] What both gliders do\n";

const ERRORS: &str = "# Errors\n\n## Warnings (64-127)\n\n| Code | Abbreviation | Description |\n|---|---|---|\n| 66 | WINCH | Rope slack |\n";

/// Languages and their texts: key, text of the definition, translation.
const TRANSLATIONS: [(&str, &[[&str; 3]]); 3] = [
    ("is", &[["gliders/Glider.mode", "What it does", "Hvað hún gerir"]]),
    (
        "pt-BR",
        &[
            ["gliders/Glider", "A glider under way", "Um planador a caminho"],
            ["gliders/Glider::MODE_SOAR", "Soaring", "Planando"],
            ["gliders/Glider::MARK_FAR", "Far mark", "Última \\\"marca\\\" */ \\\\ ${x}"],
            ["winch/error-code/66", "Rope slack", "Cabo frouxo"],
        ],
    ),
    ("fa", &[["winch/error-code/66", "Rope slack", "طناب شل می\u{200c}شود"]]),
];

/// Writes definitions with translations to `folder`, and generates outputs. `output` is the part of the configuration
/// file that selects the outputs.
pub(crate) fn emit(folder: &Path, output: &str) {
    write(&folder.join("msg/Glider.msg"), GLIDER);
    write(&folder.join("msg/Tow.msg"), TOW);
    write(&folder.join("errors.md"), ERRORS);
    for (tag, entries) in TRANSLATIONS {
        let head = "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n".to_owned();
        let entries = entries.iter().map(|[key, source, translation]| {
            format!("\nmsgctxt \"{key}\"\nmsgid \"{source}\"\nmsgstr \"{translation}\"\n")
        });
        write(&folder.join(format!("{tag}.po")), &entries.fold(head, |text, entry| text + &entry));
    }
    let packages = "[[package]]\nname = \"gliders\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\n\
                    [[package]]\nname = \"winch\"\ndialect = \"table\"\ninclude = [\"errors.md\"]\n\
                    [translations]\ninclude = [\"*.po\"]\n";
    let config = folder.join("uavspec.toml");
    write(&config, &format!("[output]\n{output}\n{packages}"));
    xtask(&["codegen", "--config", &config.display().to_string()]);
}

/// A JavaScript program that queries labels.
const PROGRAM: &str = r#"for (const known of languages) console.log(known.tag, known.name, known.isRightToLeft);
for (const tags of [["pt_BR.UTF-8"], ["IS-is"], ["pt", "fa"], ["tlh"], []]) {
  const labels = await language(...tags);
  console.log("--", labels.tag, labels.name, labels.isRightToLeft);
  console.log(labels.message("gliders/Glider"));
  console.log(labels.field("gliders/Glider", "mode"), "|", labels.field("gliders/Glider", "import"));
  console.log([1, 2, 3].map((mode) => labels.value("gliders/Tow", "mode", mode)).join(" "));
  console.log(labels.flags("gliders/Glider", "marks", 2n ** 63n + 5n).join(", "));
  console.log(labels.errorCode("winch", 66), "|", labels.errorCode("winch", 67), "|", labels.field("toString", ""));
  console.log(labels.text("gliders/Glider::MARK_FIRST"), labels.text("toString") === null);
}
"#;

/// The equivalent Python program.
const PYTHON: &str = r#"from gliders.labels import language, languages

for known in languages:
    print(known.tag, known.name, str(known.is_right_to_left).lower())
for tags in [["pt_BR.UTF-8"], ["IS-is"], ["pt", "fa"], ["tlh"], []]:
    labels = language(*tags)
    print("--", labels.tag, labels.name, str(labels.is_right_to_left).lower())
    print(labels.message("gliders/Glider"))
    print(labels.field("gliders/Glider", "mode"), "|", labels.field("gliders/Glider", "import"))
    print(*(labels.value("gliders/Tow", "mode", mode) for mode in (1, 2, 3)))
    print(*labels.flags("gliders/Glider", "marks", 2**63 + 5), sep=", ")
    print(labels.error_code("winch", 66), "|", labels.error_code("winch", 67), "|", labels.field("toString", ""))
    print(labels.text("gliders/Glider::MARK_FIRST"), str(labels.text("toString") is None).lower())
"#;

/// The expected output of both programs.
const PRINTED: &str = r#"en English false
fa فارسی true
is is false
pt-BR Português (Brasil) false
-- pt-BR Português (Brasil) false
Um planador a caminho
What it does | import
Planando MODE_DIVE 3
First "mark" */ passed, Última "marca" */ \ ${x}, 4
Cabo frouxo | 67 | 
First "mark" */ passed true
-- is is false
A glider under way
Hvað hún gerir | import
Soaring MODE_DIVE 3
First "mark" */ passed, Far mark, 4
Rope slack | 67 | 
First "mark" */ passed true
-- fa فارسی true
A glider under way
What it does | import
Soaring MODE_DIVE 3
First "mark" */ passed, Far mark, 4
طناب شل می‌شود | 67 | 
First "mark" */ passed true
-- en English false
A glider under way
What it does | import
Soaring MODE_DIVE 3
First "mark" */ passed, Far mark, 4
Rope slack | 67 | 
First "mark" */ passed true
-- en English false
A glider under way
What it does | import
Soaring MODE_DIVE 3
First "mark" */ passed, Far mark, 4
Rope slack | 67 | 
First "mark" */ passed true
"#;

#[test]
#[ignore = "requires Node"]
fn labels_in_javascript_match_the_language() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    emit(folder, "typescript = { path = \"out\", form = \"compiled\" }");
    write(&folder.join("package.json"), "{ \"type\": \"module\" }\n");
    let module = format!("import {{ language, languages }} from \"./out/labels.js\";\n\n{PROGRAM}");
    write(&folder.join("program.js"), &module);
    let common = "const { language, languages } = require(\"./out/labels.cjs\");\n";
    write(&folder.join("program.cjs"), &format!("{common}\n(async () => {{\n{PROGRAM}}})();\n"));
    for program in ["program.js", "program.cjs"] {
        assert_eq!(run("node", &[program], folder), PRINTED, "{program}");
    }
}

#[test]
#[ignore = "requires Python and the network"]
fn labels_in_python_match_the_language() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    emit(folder, "python = \"gliders\"");
    write(&folder.join("program.py"), PYTHON);
    assert_eq!(run(python_with_tools(), &["-X", "utf8", "program.py"], folder), PRINTED);
}

#[test]
#[ignore = "requires Node, Python and the network"]
fn languages_are_loaded_lazily() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    emit(folder, "typescript = { path = \"out\", form = \"compiled\" }\npython = \"gliders\"");
    let script = "const { language } = require('./out/labels.cjs');\n\
                  require('./out/index.cjs');\n\
                  const loaded = () => Object.keys(require.cache).filter((path) => /labels.(fa|is|en|pt-BR)/.test(path)).length;\n\
                  const before = loaded();\n\
                  language('is').then(() => console.log(before, loaded()));\n";
    write(&folder.join("program.cjs"), script);
    assert_eq!(run("node", &["program.cjs"], folder), "0 2\n");
    let script = "import sys\nimport gliders\nfrom gliders import labels\n\
                  loaded = lambda: sum(name.startswith('gliders.labels._') for name in sys.modules) - 1\n\
                  before = loaded()\nlabels.language('is')\nprint(before, loaded())\n";
    write(&folder.join("program.py"), script);
    assert_eq!(run(python_with_tools(), &["program.py"], folder), "0 2\n");
}
