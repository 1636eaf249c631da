//! Tests that the examples in the README of the installed npm package run, and print the text below them.

use std::fs;
use std::path::Path;

use super::tools::{node_tool, package, run, write};

/// An example and its output.
struct Example {
    language: String,
    code: String,
    printed: String,
}

/// The fenced blocks that are followed by a block of plain text.
fn examples(readme: &str) -> Vec<Example> {
    let mut blocks = Vec::new();
    let mut lines = readme.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else { continue };
        let text: String =
            lines.by_ref().take_while(|line| *line != "```").map(|line| format!("{line}\n")).collect();
        blocks.push((language.to_owned(), text));
    }
    let pairs = blocks.windows(2).filter(|pair| pair[0].0 != "text" && pair[1].0 == "text");
    pairs
        .map(|pair| Example {
            language: pair[0].0.clone(),
            code: pair[0].1.clone(),
            printed: pair[1].1.clone(),
        })
        .collect()
}

#[test]
#[ignore = "requires Node and npm"]
fn the_readme_of_the_npm_package_is_correct() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write(&folder.join("package.json"), "{ \"private\": true }\n");
    run(
        "npm",
        &["install", "--offline", "--no-audit", "--no-fund", &package().display().to_string()],
        folder,
    );
    let readme = fs::read_to_string(folder.join("node_modules/uavspec-types/README.md")).expect("a README");
    let examples = examples(&readme);
    let count = |language: &str| examples.iter().filter(|example| example.language == language).count();
    assert!(count("js") > 0 && count("cjs") > 0 && count("ts") > 1, "an example of each language");
    let ending = |example: &Example| match example.language.as_str() {
        "js" => "mjs".to_owned(),
        "ts" => "mts".to_owned(),
        other => other.to_owned(),
    };
    let mut typed = Vec::new();
    for (index, example) in examples.iter().enumerate() {
        let source = format!("example-{index}.{}", ending(example));
        write(&folder.join(&source), &example.code);
        typed.extend(is_module_source(&source).then_some(source));
    }
    write_entries(folder);
    typed.extend(["entries.mts".to_owned(), "entries.cts".to_owned()]);
    compile(folder, &typed);
    for (index, example) in examples.iter().enumerate() {
        let program = format!("example-{index}.{}", ending(example).replace("mts", "mjs"));
        assert_eq!(run("node", &[&program], folder), example.printed, "{}", example.code);
    }
    for program in ["entries.mjs", "entries.cjs"] {
        assert_eq!(run("node", &[program], folder), "true 1 3 true true\n", "{program}");
    }
}

fn is_module_source(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|ending| ending == "mts")
}

/// Compiles sources with each module resolution of TypeScript. Node runs the output.
fn compile(folder: &Path, sources: &[String]) {
    let compiler = node_tool("typescript/bin/tsc");
    let (modern, common): (Vec<&str>, Vec<&str>) =
        sources.iter().map(String::as_str).partition(|source| is_module_source(source));
    for (module, resolution) in [("esnext", "bundler"), ("nodenext", "nodenext"), ("node16", "node16")] {
        let mut arguments = vec![compiler.as_str(), "--strict", "--target", "es2022", "--lib", "es2022,dom"];
        arguments.extend(["--module", module, "--moduleResolution", resolution]);
        arguments.extend(&modern);
        match resolution {
            // Bundlers don't support `import … = require`.
            "bundler" => arguments.push("--skipLibCheck"),
            // Check all declarations of the package only in the last run, because this is slow.
            "nodenext" => arguments.extend([&["--skipLibCheck"], &common[..]].concat()),
            _ => arguments.extend(&common),
        }
        run("node", &arguments, folder);
    }
}

/// Writes programs that import and require each entry point, and use its types.
fn write_entries(folder: &Path) {
    let uses = "const known: boolean = flockwave.errorCode(1).isKnown;\nconst low: 1 = px4.BatteryStatusBatteryWarning.LOW;\n\
                const bundles: readonly string[] = data.manifest().bundles;\n\
                const same: boolean = index.px4.BatteryStatusBatteryWarning.LOW === low;\n\
                const tags: string[] = labels.languages.map((known) => known.tag);\n\
                const uk: labels.Labels = ukrainian.labels;\n\
                console.log(known, low, bundles.length, same, tags.includes(uk.tag));\n";
    let mut esm = String::new();
    let mut cjs = String::new();
    for (name, entry) in [
        ("index", "uavspec-types"),
        ("px4", "uavspec-types/px4"),
        ("flockwave", "uavspec-types/flockwave"),
        ("data", "uavspec-types/data"),
        ("labels", "uavspec-types/labels"),
        ("ukrainian", "uavspec-types/labels/uk"),
    ] {
        esm.extend(["import * as ", name, " from \"", entry, "\";\n"]);
        cjs.extend(["import ", name, " = require(\"", entry, "\");\n"]);
    }
    write(&folder.join("entries.mts"), &(esm + uses));
    write(&folder.join("entries.cts"), &(cjs + uses));
}
