//! Tests that outputs don't depend on the location of the definitions.

use uavspec_emit::{OutputFile, docs, json_schema, python, typescript, vectors};
use uavspec_schema::msg::Dialect;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Form, SourceMap, read};
use uavspec_test_definitions as support;

const MESSAGES: [(&str, &str); 3] = [
    ("msg/Wind.msg", "uint64 timestamp # [us] Since start\n"),
    ("msg/versioned/Gust.msg", "uint64 timestamp # [us] Since start\nWind wind # Around it\n"),
    ("srv/Calm.srv", "uint8 a # Until then\n---\nuint8 b # From then on\n"),
];

const ERROR_CODES: &str = include_str!("../../../definitions/flockwave/error-codes.md");

/// The outputs of all emitters for the same definitions in `folder`.
fn emitted(folder: &str) -> Vec<OutputFile> {
    let mut sources = SourceMap::default();
    let mut add = |path: &str, text: &str| {
        sources.add(format!("{folder}{path}"), text.as_bytes().to_vec()).expect("a definition")
    };
    let mut px4 = support::package("px4", Form::Msg(Dialect::Px4));
    px4.sources.extend(MESSAGES.map(|(path, text)| add(path, text)));
    let mut gliders = support::package("gliders", Form::Table);
    let page = include_str!("../../schema/tests/fixtures/ok/type-tables/gliders.md");
    gliders.sources.extend([add("pages/gliders.md", page), add("pages/error-codes.md", ERROR_CODES)]);
    let (schema, diagnostics) = read(&sources, &[px4, gliders]);
    assert_eq!(diagnostics, [], "{folder}");
    let translations = Translations::default();
    let mut files = docs::emit(&schema, &translations, &sources, &docs::Options::default());
    files.extend(json_schema::emit(&schema, &json_schema::Options::default()));
    files.extend(vectors::emit(&schema, &vectors::Options::default()));
    files.extend(typescript::emit(&schema, &translations, &typescript::Options::default()));
    files.extend(python::emit(&schema, &translations));
    files.extend({
        use uavspec_emit::rust;
        rust::emit(&schema, &sources, &rust::Options::default())
    });
    files
}

#[test]
fn outputs_do_not_depend_on_the_folder_of_definitions() {
    let relative = emitted("");
    let folders = ["definitions/", "../../here/", "/home/pilot/px4/", "/srv/build-17/", "C:\\px4\\"];
    for folder in folders.into_iter().rev().step_by(support::extent(1, 3)) {
        let found = emitted(folder);
        assert_eq!(found.len(), relative.len());
        for (found, expected) in found.iter().zip(&relative) {
            assert_eq!(found, expected, "{folder}");
        }
    }
    let names = |path: &str| relative.iter().any(|file| file.text.contains(path));
    assert!(
        names("`msg/versioned/Gust.msg`") && names("`error-codes.md:"),
        "pages contain the paths of definitions"
    );
}
