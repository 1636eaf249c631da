//! The examples of the crate's page, which the documentation tests run, are those of the README too.

#[test]
fn examples_are_those_of_the_readme() {
    let page = include_str!("../README.md");
    let readme = include_str!("../../README.md");
    let mut examples =
        page.split("```rust\n").skip(1).filter_map(|rest| rest.split("```\n").next()).peekable();
    assert!(examples.peek().is_some(), "the page shows no example");
    for example in examples {
        assert!(
            readme.contains(&format!("```rust\n{example}```\n")),
            "the README lacks this example:\n{example}"
        );
    }
}
