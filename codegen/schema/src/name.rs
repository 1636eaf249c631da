//! Names of packages and generated files.

use crate::limits::MAX_NAME_LEN;

/// Device names on Windows. Windows can't create a file with such a name, even with an extension.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];

/// True for letters, digits and `_`, starting with a letter.
pub fn is_identifier(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// True if Windows reserves the name, such as `CON`, `aux.rs` or `com1.tar.gz`.
pub fn is_reserved(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or(name).trim_end_matches(' ').to_lowercase();
    let is_port = |device: &str| {
        stem.strip_prefix(device).is_some_and(|number| {
            // The superscripts of Latin-1 count as digits.
            matches!(number, "0" | "1" | "2" | "3" | "4" | "5" | "6" | "7" | "8" | "9" | "¹" | "²" | "³")
        })
    };
    DEVICES.contains(&stem.as_str()) || is_port("com") || is_port("lpt")
}

/// The reason why a package can't have this name, and the solution.
pub fn package_problem(name: &str) -> Option<(String, String)> {
    if !is_identifier(name) {
        let message = if name.is_empty() {
            "the name of a package is empty".to_owned()
        } else {
            format!("`{}` is not a valid package name", name.escape_debug())
        };
        let hint =
            "use letters, digits and `_`, starting with a letter; folders, modules and URLs contain the name";
        return Some((message, hint.to_owned()));
    }
    let problem = file_problem(name)?;
    let message = format!("the package name `{name}` {problem}");
    Some((message, "choose another name; files and folders are named after the package".to_owned()))
}

/// The reason why some file systems don't accept a file or folder with this name.
pub fn file_problem(name: &str) -> Option<&'static str> {
    let is_forbidden = |c: char| c.is_control() || "<>:\"/\\|?*".contains(c);
    if name.is_empty() || name == "." || name == ".." {
        Some("is not a file name")
    } else if name.contains(is_forbidden) {
        Some("contains a character that is not allowed in file names")
    } else if name.ends_with(['.', ' ']) {
        Some("ends with a dot or a space, which Windows removes")
    } else if is_reserved(name) {
        Some("is reserved on Windows")
    } else if name.len() > MAX_NAME_LEN {
        Some("is longer than 255 bytes")
    } else {
        None
    }
}

/// Splits a name at non-alphanumeric characters and at case changes that start a word. An uppercase letter after a digit
/// starts a word only if a lowercase letter follows, because `2D` and `PX4IO` are words.
pub fn words(name: &str) -> Vec<&str> {
    let bytes = name.as_bytes();
    let mut words = Vec::new();
    let mut start = 0;
    for at in 0..=bytes.len() {
        let is_break = match bytes.get(at) {
            None => true,
            Some(byte) if !byte.is_ascii_alphanumeric() => true,
            Some(byte) if byte.is_ascii_uppercase() && at > start => {
                let next_is_lower = bytes.get(at + 1).is_some_and(u8::is_ascii_lowercase);
                bytes[at - 1].is_ascii_lowercase() || next_is_lower
            }
            Some(_) => false,
        };
        if !is_break {
            continue;
        }
        if let Some(word) = name.get(start..at).filter(|word| !word.is_empty() && word.is_ascii()) {
            words.push(word);
        }
        let is_letter = bytes.get(at).is_some_and(u8::is_ascii_alphanumeric);
        start = if is_letter { at } else { at + 1 };
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recognizes_reserved_names_with_any_extension() {
        for name in ["CON", "con", "Aux.msg", "nul.tar.gz", "prn .txt", "COM1", "lpt9.rs", "CONIN$", "com²"]
        {
            assert!(is_reserved(name), "{name}");
        }
        for name in ["Control", "auxiliary", "COM", "COM10", "LPTX", "xcon", "a.con", "Null"] {
            assert!(!is_reserved(name), "{name}");
        }
    }

    #[test]
    fn accepts_identifiers_as_package_names() {
        for name in ["px4", "px4_msgs", "Demo", "mod", "class", "c"] {
            assert_eq!(package_problem(name), None, "{name}");
        }
        for name in [
            "", ".", "..", "/", "/tmp", "../up", "a/b", "a\\b", "C:", "a b", "my-msgs", "_a", "4g", "é",
            "con", "aux",
        ] {
            assert!(package_problem(name).is_some(), "{name}");
        }
        assert!(package_problem(&"a".repeat(256)).is_some());
    }

    #[test]
    fn rejects_file_names_that_some_systems_reject() {
        for name in ["", ".", "..", "a/b", "a\\b", "C:x", "a\0", "a\n", "a.", "a ", "what?", "NUL.json"] {
            assert!(file_problem(name).is_some(), "{name}");
        }
        for name in ["SYS-VER.schema.json", ".uavspec-manifest", "мова.md", "a b.md"] {
            assert_eq!(file_problem(name), None, "{name}");
        }
    }
}
