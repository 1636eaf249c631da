//! Tests that names in definitions don't hide the built-in names of Python in the generated modules. The names come
//! from the installed Python version.

use std::path::Path;

use super::declarations::check_python;
use super::tools::{python_with_tools, run, write, xtask};

/// A Python program that prints the names of all functions, classes, constants and keywords that are built in.
const BUILT_IN: &str = "import builtins, keyword\n\
                        names = {*dir(builtins), *keyword.kwlist, *keyword.softkwlist, 'sys', 'typing', 'enum'}\n\
                        print(*sorted(name for name in names if name[0].isalpha()), sep='\\n')\n";

/// The fields of a message, with a type for each annotation in Python.
const FIELDS: &str = "uint8 KIND_GUST=1\nfloat32 NONE=nan\nuint64 timestamp # [us] Time since system start\n\
                      uint8[2] kinds # [@enum KIND] Kinds\nfloat32[2] speeds # [m/s] Speeds\nchar[8] label # Label\n\
                      bool is_valid # True if valid\n";

/// Enums that are named after the message and the prefix, such as `ValueError`.
const ENUMS: &str = "uint8 ERROR_A=1\nuint8 WARNING_A=1\nuint64 timestamp # [us] Time since system start\n\
                     uint8 error # [@enum ERROR] Error\nuint8 warning # [@flags WARNING] Warning\n";

/// Writes definitions in which packages, messages, fields and constants have these names, and generates Python.
fn emit(names: &[&str], folder: &Path) {
    let lines = |line: &dyn Fn(&str) -> String| names.iter().map(|name| line(name)).collect::<String>();
    let fields = lines(&|name| format!("uint8 {name}\n"));
    let constants = lines(&|name| format!("uint8 {name}=1\n"));
    let users = lines(&|name| format!("{name}/Item {}\n", name.to_lowercase()));
    for (path, text) in [
        ("messages/Fields.msg", fields + FIELDS),
        ("messages/Constants.msg", constants + FIELDS),
        ("messages/Value.msg", ENUMS.to_owned()),
        ("messages/User.msg", ENUMS.to_owned()),
        ("users/User.msg", users),
        ("item/Item.msg", "uint8 a\n".to_owned()),
    ] {
        write(&folder.join(path), &text);
    }
    for name in names {
        let text = format!("{FIELDS}uint8 {name} # [@enum KIND] Kind\n");
        write(&folder.join(format!("messages/{name}.msg")), &text);
    }
    let package = |name: &str, dialect: &str, folder: &str| {
        format!("[[package]]\nname = \"{name}\"\ndialect = \"{dialect}\"\ninclude = [\"{folder}/*.msg\"]\n")
    };
    let config = [
        "[output]\npython = \"python/hostile\"\n".to_owned(),
        package("messages", "px4", "messages"),
        package("users", "ros2", "users"),
        lines(&|name| package(name, "ros2", "item")),
    ];
    let path = folder.join("uavspec.toml");
    write(&path, &config.concat());
    xtask(&["codegen", "--config", &path.display().to_string()]);
}

#[test]
#[ignore = "requires Python, Node, npm and the network"]
fn no_name_hides_a_built_in_name_of_python() {
    let folder = tempfile::tempdir().expect("a folder");
    let printed = run(python_with_tools(), &["-c", BUILT_IN], folder.path());
    let names: Vec<&str> = printed.lines().collect();
    assert!(names.len() > 150, "{names:?}");
    emit(&names, folder.path());
    check_python(&folder.path().join("python"));
}
