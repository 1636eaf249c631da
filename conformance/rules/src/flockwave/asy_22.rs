//! `FW-ASY-22`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-22",
    name: "Type of a result",
    level: Level::Should,
    status: Status::DisputedCases(
        "For the result of ASYNC-RESP, the specification text requires an object, but its example has a \
         number, and the JSON Schema allows any value. This rule requires the type that an immediate \
         response would have.",
    ),
    statement: "Each result has the type specified in the definition of its command. For most UAV \
                commands, this is a boolean.",
    source: source::SCHEMA,
    applies_to: "ASYNC-RESP, and responses with `result`",
    why: "Clients compare the result with true. A string such as \"failed\" may count as success, and \
          null as failure.",
    example: r#"{"type":"UAV-LAND","result":{"uav-1":"ok"}}"#,
    fix: "Send the type that the definition specifies. Report failures in `error`, not as text in `result`.",
})
.checks(&[Check::Exchange(check)])
.covers(&[Attribution::new(&TYPES, "result.*", &[Fault::Null, Fault::Kind])])
.bug(Bug::message("Results that should be booleans are strings.", |out| {
    let is_command = out.kind().starts_with("UAV-") || out.kind() == "ASYNC-RESP";
    let Some(result) = out.message()["body"].get_mut("result").filter(|_| is_command) else { return };
    let values: Vec<&mut Value> = match result {
        Value::Object(values) => values.values_mut().collect(),
        value => vec![value],
    };
    for value in values.into_iter().filter(|value| value.is_boolean()) {
        *value = json!("yes");
    }
}))
.mutants(&[
    Mutant::reply("null in a response", "UAV-TAKEOFF", |body| body["result"]["swift"] = json!(null)),
    Mutant::notice("a number in ASYNC-RESP", "ASYNC-RESP", |body| body["result"] = 7.into()),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.role == Role::Response && exchange.is_from_server() {
        let Some((name, expected, fits)) = exchange.type_name.and_then(result_of) else { return };
        let wrong = body::members(exchange.body, "result")
            .iter()
            .inspect(|_| context.covered())
            .find(|(_, found)| !fits(found));
        if let Some((key, found)) = wrong {
            exchange.violates(context, || {
                Detail::new(format!("result of {name}: expected {expected}, found {found}"))
                    .at(pointer(&["body", "result", key]))
                    .expected(expected)
                    .actual(found.to_string())
            });
        }
    }
    let Some(found) = exchange.notification("ASYNC-RESP").and_then(|body| body.get("result")) else { return };
    let known = exchange.operations.first().and_then(|named| named.before.as_ref());
    let request = known.and_then(|operation| operation.type_name.as_deref());
    let Some((name, expected, fits)) = request.and_then(result_of) else { return };
    // If there is an error, a null result doesn't count as a result.
    if body::is_present(exchange.field("error")) {
        return;
    }
    context.covered();
    if !fits(found) {
        context.violation(&format!("ASYNC-RESP of {name}"), exchange.record.location, || {
            Detail::new(format!("result of {name}: expected {expected}, found {found}"))
                .at("/body/result")
                .expected(expected)
                .actual(found.to_string())
                .disputed(true)
        });
    }
}

/// A message type, a description of its valid results, and a function that returns true for valid results.
type ResultSpec = (&'static str, &'static str, fn(&Tree<'_>) -> bool);

/// The result specification of a command, if the definitions have one.
fn result_of(name: &str) -> Option<ResultSpec> {
    RESULTS.iter().find(|(known, ..)| *known == name).copied()
}

const BOOLEAN: &str = "true or false";

const RESULTS: [ResultSpec; 18] = [
    ("BCN-PROPS", "an object", is_object),
    ("LOG-INF", "a list", |found| matches!(found, Tree::List(_))),
    ("OBJ-CMD", "a string or an object", |found| matches!(found, Tree::Text(_) | Tree::Object(_))),
    ("PRM-SET", BOOLEAN, is_boolean),
    ("PRM-SET-MANY", "an object", is_object),
    ("UAV-CALIB", BOOLEAN, is_boolean),
    ("UAV-FLY", BOOLEAN, is_boolean),
    ("UAV-HALT", BOOLEAN, is_boolean),
    ("UAV-HOVER", BOOLEAN, is_boolean),
    ("UAV-LAND", BOOLEAN, is_boolean),
    ("UAV-MOTOR", BOOLEAN, is_boolean),
    ("UAV-RST", BOOLEAN, is_boolean),
    ("UAV-RTH", BOOLEAN, is_boolean),
    ("UAV-SIGNAL", BOOLEAN, is_boolean),
    ("UAV-SLEEP", BOOLEAN, is_boolean),
    ("UAV-TAKEOFF", BOOLEAN, is_boolean),
    ("UAV-TEST", BOOLEAN, is_boolean),
    ("UAV-WAKEUP", BOOLEAN, is_boolean),
];

/// The message types in [`RESULTS`].
const TYPES: [&str; RESULTS.len()] = {
    let mut types = [""; RESULTS.len()];
    let mut at = 0;
    while at < types.len() {
        types[at] = RESULTS[at].0;
        at += 1;
    }
    types
};

fn is_boolean(found: &Tree<'_>) -> bool {
    matches!(found, Tree::Bool(_))
}

fn is_object(found: &Tree<'_>) -> bool {
    matches!(found, Tree::Object(_))
}
