//! Checks that the crate's README contains all Rust examples of the repository's README. The examples in the
//! crate's README run as documentation tests.

#[test]
fn the_crate_readme_contains_the_examples_of_the_repository_readme() {
    let page = include_str!("../README.md");
    let readme = include_str!("../../README.md");
    let examples = readme.split("```rust\n").skip(1).filter_map(|rest| rest.split("```\n").next());
    let untested: Vec<&str> =
        examples.filter(|example| !page.contains(&format!("```rust\n{example}```\n"))).collect();
    assert!(untested.is_empty(), "generated/README.md lacks {untested:#?}");
    assert!(readme.contains("```rust\n"), "README.md has no Rust example");
}
