//! Compares the public API of each crate with golden files, so that changes are visible in reviews.

mod listing;

use std::collections::BTreeSet;
use std::path::Path;
use std::{env, fs};

use self::listing::Crate;

/// Compares the public items of a crate with its golden file, or writes the file.
#[track_caller]
fn check(name: &str, root: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let golden = folder.join(format!("tests/api/{name}.txt"));
    let items = Crate::read(&name.replace('-', "_"), &folder.join("..").join(root)).public_items();
    if env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(&golden, items.join("\n") + "\n").expect("a golden file");
        return;
    }
    let text = fs::read_to_string(&golden).unwrap_or_default();
    let (old, new): (BTreeSet<_>, BTreeSet<_>) =
        (text.lines().collect(), items.iter().map(String::as_str).collect());
    let removed = old.difference(&new).map(|line| format!("\n- {line}"));
    let added = new.difference(&old).map(|line| format!("\n+ {line}"));
    let changes: String = removed.chain(added).collect();
    assert!(
        changes.is_empty(),
        "the public API of {name} differs from xtask/tests/api/{name}.txt:{changes}\n\
         If the change is intended, run `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p xtask api` and commit the file."
    );
}

#[test]
fn the_api_of_codegen_is_unchanged() {
    check("uavspec-codegen", "codegen/src/lib.rs");
    // The language server is part of the program, and has no separate list.
    for part in ["schema", "dynamic", "lint", "emit"] {
        check(&format!("uavspec-{part}"), &format!("codegen/{part}/src/lib.rs"));
    }
}

#[test]
fn the_api_of_conformance_is_unchanged() {
    // Third-party programs use these crates. The other crates are parts of these crates.
    for part in ["check", "report"] {
        check(&format!("uavspec-{part}"), &format!("conformance/{part}/src/lib.rs"));
    }
}

#[test]
fn the_api_of_definitions_is_unchanged() {
    check("uavspec-definitions", "definitions/lib.rs");
}

#[test]
fn the_api_of_the_runtime_is_unchanged() {
    check("uavspec-runtime", "generated/runtime/src/lib.rs");
}

#[test]
fn lists_what_other_crates_can_name() {
    let text = r#"
        pub mod shown {
            pub struct Pair { pub first: u8, second: u8 }
            pub(crate) struct Inner;
            #[doc(hidden)]
            pub fn hidden() {}
            #[cfg(test)]
            pub fn tested() {}
        }
        mod private {
            use super::shown::Pair as Both;
            impl Both { pub fn sum(&self) -> u8 { 0 } fn own(&self) {} }
            pub enum Choice { One, #[cfg(feature = "two")] Two { by: u8 } }
            pub trait Choose { const COUNT: usize; type Item; fn choose(); }
            pub struct Absent;
            #[macro_export]
            macro_rules! made { () => {} }
        }
        #[cfg(feature = "extra")]
        pub use private::{Choice as Option, Choose};
        pub use shown::Pair;
        pub use other::Thing;
    "#;
    let expected = r#"
        trait it::Choose (feature = "extra")
        const it::Choose::COUNT (feature = "extra")
        type it::Choose::Item (feature = "extra")
        fn it::Choose::choose (feature = "extra")
        enum it::Option (feature = "extra")
        variant it::Option::One (feature = "extra")
        variant it::Option::Two (feature = "extra") (feature = "two")
        field it::Option::Two::by (feature = "extra") (feature = "two")
        use it::Pair = it::shown::Pair
        use it::Thing = other::Thing
        macro it::made
        mod it::shown
        struct it::shown::Pair
        field it::shown::Pair::first
        fn it::shown::Pair::sum
    "#;
    let expected: Vec<&str> = expected.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    assert_eq!(Crate::parse("it", text, Path::new("nowhere")).public_items(), expected);
}
