//! Checks the hello of a testee.

use std::collections::BTreeSet;

use serde_json::Value;
use uavspec_model::json::shortened;

use super::{Bench, Check, CheckOutcome};
use crate::testee::link::Link;
use crate::testee::options::excerpt;
use crate::testee::protocol::{Format, Hello, Op};

pub(super) const INTRODUCTION: Check = Check {
    id: "introduction",
    statement: "the testee sends a valid hello in time",
    help: "respond to {\"op\":\"hello\",\"protocol\":1} with one line of JSON, and flush the output after every line",
    attempt: introduction,
};

pub(super) const HELLO_MEMBERS: Check = Check {
    id: "hello-members",
    statement: "the hello has a name, a version, known ops and formats, and types such as px4/Event",
    help: "send, for example, {\"op\":\"hello\",\"protocol\":1,\"name\":\"my-codec\",\"version\":\"1.2\",\
           \"ops\":[\"decode\"],\"formats\":[\"uorb\"],\"types\":[\"px4/Event\"]}",
    attempt: hello_members,
};

pub(super) const SECOND_HELLO: Check = Check {
    id: "second-hello",
    statement: "a second hello gets an error or the same response as the first, and later requests still work",
    help: "respond to every hello in the same way",
    attempt: second_hello,
};

fn introduction(bench: &mut Bench<'_>) -> CheckOutcome {
    let opened = bench.first.take().map_or_else(|| Link::open(bench.options, true), Ok);
    match opened.and_then(|mut link| link.introduction(bench.options)) {
        Ok(introduced) => {
            bench.introduced = Some(introduced);
            CheckOutcome::Pass
        }
        Err(wrong) => CheckOutcome::Fail(wrong),
    }
}

fn hello_members(bench: &mut Bench<'_>) -> CheckOutcome {
    let Some((hello, line)) = &bench.introduced else { return CheckOutcome::Pass };
    // `Hello::read` accepted the line, so it is valid JSON.
    let value: Value = serde_json::from_slice(line).unwrap_or_default();
    let wrong = [
        hello.name.is_empty().then(|| "\"name\" is empty".to_owned()),
        hello.version.is_empty().then(|| "\"version\" is missing or not a string".to_owned()),
        wrong_list(&value, "ops", |name| Op::ALL.iter().any(|op| op.name() == name)),
        wrong_list(&value, "formats", |name| Format::ALL.iter().any(|format| format.name() == name)),
        wrong_list(&value, "types", is_type_name),
    ];
    let wrong: Vec<String> = wrong.into_iter().flatten().collect();
    if wrong.is_empty() { CheckOutcome::Pass } else { CheckOutcome::Fail(wrong.join("; ")) }
}

/// The first problem in a list of names. A missing list isn't a problem, because `Hello::read` requires the mandatory
/// lists.
fn wrong_list(hello: &Value, member: &str, is_known: impl Fn(&str) -> bool) -> Option<String> {
    let names: Vec<&str> = hello.get(member)?.as_array()?.iter().filter_map(Value::as_str).collect();
    if names.is_empty() {
        return Some(format!("\"{member}\" is empty"));
    }
    let mut seen = BTreeSet::new();
    let wrong = names.iter().find_map(|name| {
        if !is_known(name) {
            Some(format!("the unknown name {:?}", shortened(name)))
        } else if !seen.insert(name) {
            Some(format!("{:?} twice", shortened(name)))
        } else {
            None
        }
    });
    wrong.map(|wrong| format!("\"{member}\" lists {wrong}"))
}

/// True if a name has the form `PACKAGE/NAME`, such as `px4/Event` or `flockwave/UAV-INF.response`.
fn is_type_name(name: &str) -> bool {
    let is_of = |word: &str, more: &[char]| {
        let is_known = |it: char| it.is_ascii_alphanumeric() || it == '_' || more.contains(&it);
        word.starts_with(|it: char| is_known(it) && !more.contains(&it)) && word.chars().all(is_known)
    };
    name.split_once('/').is_some_and(|(package, name)| is_of(package, &[]) && is_of(name, &['-', '.']))
}

fn second_hello(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        session.check_alive(case)?;
        session.send_hello();
        session.check_alive(case)?;
        let first = bench.introduced.as_ref().map(|(hello, _)| hello);
        match session.received.hellos.iter().find(|line| Hello::read(line).ok().as_ref() != first) {
            Some(line) => Err(format!("the second hello differs from the first: {}", excerpt(line))),
            None => Ok(()),
        }
    })
}
