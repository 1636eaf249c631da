//! Tests of the software bill of materials.

use std::fs;
use std::path::Path;

use crate::packages::tools::{python_with_tools, run, xtask};

/// Prints the errors in a document.
const VALIDATE: &str = "
import sys
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
print(JsonStrictValidator(SchemaVersion.V1_6).validate_str(open(sys.argv[1]).read()))
";

#[test]
#[ignore = "requires Python and PyPI"]
fn is_valid_cyclonedx() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sbom");
    fs::create_dir_all(&folder).expect("a folder");
    let (right, wrong) = (folder.join("right.json"), folder.join("wrong.json"));
    xtask(&["sbom", "--out", &right.display().to_string()]);
    let text = fs::read_to_string(&right).expect("a document");
    fs::write(&wrong, text.replace("\"application\"", "\"program\"")).expect("a file");
    let validate = |path: &Path| {
        run(python_with_tools(), &["-c", VALIDATE, &path.display().to_string()], &folder).trim().to_owned()
    };
    assert_eq!(validate(&right), "None");
    assert!(validate(&wrong).contains("program"), "the validator accepts any document");
}
