//! Texts of `uavspec.toml` that follow its grammar.

use super::grammar::{self, Table};

/// Possible values of a path.
const PATHS: &[&str] = &["\"out\"", "\"../out\"", "\"\"", "\"/\"", "\"a/../../b\"", "\"\\u0000\"", "1", "[]"];

/// Possible values of a list of patterns.
const PATTERNS: &[&str] = &["[\"*.msg\"]", "[]", "[\"\"]", "[\"**/{a,b\"]", "[\"[\"]", "\"*.msg\"", "[1]"];

/// Possible values of a text.
const TEXTS: &[&str] = &["\"text\"", "'''a\nb'''", "\"\\u202e\"", "\"é𝄞\"", "0", "true", "{}"];

/// All tables that the file may contain.
const TABLES: [Table; 13] = [
    (
        "[[package]]",
        &[
            ("name", &["\"demo\"", "\"px4\"", "\"a b\"", "\"\"", "7"]),
            ("dialect", &["\"px4\"", "\"ros2\"", "\"table\"", "\"idl\""]),
            ("include", PATTERNS),
            ("select", &["[\"Wind\"]", "[]", "[\"Wind\", \"Wind\"]", "[\"\"]", "\"Wind\""]),
            ("ros_package", TEXTS),
            ("origin", TEXTS),
            ("revision", TEXTS),
            ("releases", PATHS),
        ],
    ),
    ("[output.rust]", &[("path", PATHS), ("root", TEXTS), ("readme", PATHS)]),
    (
        "[output.json_schema]",
        &[("path", PATHS), ("base", &["\"https://hill.invalid/\"", "\"\"", "\" \"", "1"])],
    ),
    ("[output.vectors]", &[("path", PATHS), ("base", TEXTS)]),
    (
        "[output.docs]",
        &[
            ("path", PATHS),
            ("title", TEXTS),
            ("rules", &["true", "false", "1"]),
            ("contents", &["\"a.md\"", "[\"a.md\", \"b.md\"]", "[]", "[[]]"]),
        ],
    ),
    ("[output.typescript]", &[("path", PATHS), ("form", &["\"source\"", "\"compiled\"", "\"other\""])]),
    ("[output.python]", &[("path", PATHS), ("form", TEXTS)]),
    ("[output.absent]", &[("path", PATHS)]),
    ("[output]", &[("rust", PATHS), ("docs", PATHS), ("other", PATHS)]),
    ("[lint]", &[("preset", &["\"strict\"", "\"px4\"", "\"none\""])]),
    (
        "[lint.levels]",
        &[
            ("unit-missing", &["\"off\"", "\"note\"", "\"warning\"", "\"error\"", "\"high\""]),
            ("name-style", &["\"note\"", "1"]),
            ("absent", &["\"off\""]),
        ],
    ),
    (
        "[[lint.ignore]]",
        &[("rule", &["\"name-style\"", "\"absent\"", "\"\""]), ("path", PATTERNS), ("reason", TEXTS)],
    ),
    (
        "[[conversion]]",
        &[
            ("from", &["\"demo\"", "\"px4\"", "\"dmeo\""]),
            ("to", &["\"px4\"", "\"demo\"", "\"\""]),
            ("hints", PATHS),
        ],
    ),
];

/// The tables of a valid file. Each consists of a header, and the keys that are set to their first value.
#[cfg(test)]
const VALID: [(&str, &[&str]); 8] = [
    (
        "[[package]]",
        &["name", "dialect", "include", "select", "ros_package", "origin", "revision", "releases"],
    ),
    ("[output.rust]", &["path", "root", "readme"]),
    ("[output.json_schema]", &["path", "base"]),
    ("[output.docs]", &["path", "title", "rules", "contents"]),
    ("[output.typescript]", &["path", "form"]),
    ("[output.python]", &["path"]),
    ("[lint]", &["preset"]),
    ("[lint.levels]", &["unit-missing", "name-style"]),
];

/// A text that the bytes select. It starts with a package, because most tables need one.
pub(super) fn text(data: &[u8]) -> String {
    let package = "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n";
    package.to_owned() + &grammar::text(&TABLES, data)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::path::Path;

    use uavspec_codegen::load::Config;

    use super::*;

    /// If a table were missing, the grammar would describe a different file.
    #[test]
    fn the_grammar_contains_all_tables_of_a_valid_file() {
        let mut file = String::new();
        for (header, keys) in VALID {
            let (_, known) = TABLES.iter().find(|(known, _)| *known == header).expect("a table");
            let _ = writeln!(file, "{header}");
            for key in keys {
                let (_, values) = known.iter().find(|(known, _)| known == key).expect("a key");
                let _ = writeln!(file, "{key} = {}", values[0]);
            }
        }
        let plan = Config::parse(Path::new("uavspec.toml"), file.clone()).and_then(Config::plan);
        let plan = plan.unwrap_or_else(|failure| panic!("{failure}\n{file}"));
        assert_eq!((plan.packages.len(), plan.outputs.len()), (1, 5));
    }
}
