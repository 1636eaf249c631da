//! The Rust examples of the repository's README are those of the crate's page, which the documentation tests run.

#[test]
fn the_examples_of_the_readme_are_tested() {
    let page = include_str!("../README.md");
    let readme = include_str!("../../README.md");
    let examples = readme.split("```rust\n").skip(1).filter_map(|rest| rest.split("```\n").next());
    let untested: Vec<&str> =
        examples.filter(|example| !page.contains(&format!("```rust\n{example}```\n"))).collect();
    assert!(untested.is_empty(), "generated/README.md lacks {untested:#?}");
    assert!(readme.contains("```rust\n"), "the README has no example");
}
