//! Bugs in the envelope, and in which message answers which.

use serde_json::{Value, json};

use super::Bug;

pub(super) const BUGS: &[Bug] = &[
    Bug::message("FW-ENV-01", "Notifications of UAV-INF come in an array.", |out| {
        if out.notification_of("UAV-INF").is_some() {
            let message = out.message().take();
            *out.message() = json!([message]);
        }
    }),
    Bug::message("FW-ENV-02", "The version of the protocol is a number.", |out| {
        out.message()["$fw.version"] = json!(1);
    }),
    Bug::message("FW-ENV-02J", "The version of the protocol is a word.", |out| {
        out.message()["$fw.version"] = json!("newest");
    }),
    Bug::message("FW-ENV-03", "Ids are numbers.", |out| {
        let number = out.number;
        out.message()["id"] = json!(number);
    }),
    Bug::message("FW-ENV-03J", "Ids have 40 characters.", |out| {
        let id = format!("{:0>40}", out.number);
        out.message()["id"] = json!(id);
    }),
    Bug::message("FW-ENV-04", "All messages have the same id.", |out| out.message()["id"] = json!("s1")),
    Bug::message("FW-ENV-05", "Notifications have refs, which are null.", |out| {
        if out.is_notification() {
            out.message()["refs"] = Value::Null;
        }
    }),
    Bug::message("FW-ENV-06", "An acknowledgment that refers to no request follows each SYS-VER.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(Some("nobody-sent-this"), json!({ "type": "ACK-ACK" }));
        }
    }),
    Bug::message("FW-ENV-07", "Requests of unknown types aren't answered.", |out| {
        let is_unknown =
            out.message()["body"]["reason"].as_str().is_some_and(|why| why.starts_with("no handler"));
        if is_unknown {
            out.message = None;
        }
    }),
    Bug::message("FW-ENV-08", "SYS-PING is answered twice.", |out| {
        if out.asked() == Some("SYS-PING") {
            let refs = out.message()["refs"].as_str().unwrap_or_default().to_owned();
            out.follow(Some(&refs), json!({ "type": "ACK-ACK" }));
        }
    }),
    Bug::message("FW-ENV-09", "An acknowledgment refers to each notification of UAV-INF.", |out| {
        if out.notification_of("UAV-INF").is_some() {
            let refs = out.message()["id"].as_str().unwrap_or_default().to_owned();
            out.follow(Some(&refs), json!({ "type": "ACK-ACK" }));
        }
    }),
    Bug::message("FW-ENV-10", "Beside its body SYS-VER has an error.", |out| {
        if out.kind() == "SYS-VER" {
            out.message()["error"] = json!({ "message": "all is well" });
        }
    }),
    Bug::message("FW-ENV-11", "Notifications of UAV-INF have neither body nor error.", |out| {
        if out.notification_of("UAV-INF").is_some()
            && let Some(message) = out.message().as_object_mut()
        {
            message.remove("body");
        }
    }),
    Bug::message(
        "FW-ENV-12",
        "Requests of unknown types are answered by an error that says nothing.",
        |out| {
            let is_unknown =
                out.message()["body"]["reason"].as_str().is_some_and(|why| why.starts_with("no handler"));
            if is_unknown && let Some(message) = out.message().as_object_mut() {
                message.remove("body");
                message.insert("error".to_owned(), json!({}));
            }
        },
    ),
    Bug::message("FW-ENV-13", "Messages have a key of their own that starts with $.", |out| {
        out.message()["$wind"] = json!("fair");
    }),
    Bug::message("FW-ENV-14", "The type of notifications of UAV-INF is a number.", |out| {
        if let Some(body) = out.notification_of("UAV-INF") {
            body["type"] = json!(7);
        }
    }),
    Bug::message("FW-ENV-15", "Requests of unknown types are answered by a type in small letters.", |out| {
        let is_unknown =
            out.message()["body"]["reason"].as_str().is_some_and(|why| why.starts_with("no handler"));
        if is_unknown {
            out.message()["body"] = json!({ "type": "whatever" });
        }
    }),
    Bug::message("FW-ENV-16", "CONN-LIST is answered by OBJ-LIST.", |out| {
        if let Some(body) = out.body_of("CONN-LIST") {
            body["type"] = json!("OBJ-LIST");
        }
    }),
    Bug::message("FW-ENV-17", "A CONN-LIST that nobody asked for follows each SYS-VER.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(None, json!({ "type": "CONN-LIST", "ids": ["radio-1"] }));
        }
    }),
    Bug::message("FW-ENV-18", "RTK-LIST has a field that its definition doesn't allow.", |out| {
        if let Some(body) = out.body_of("RTK-LIST") {
            body["count"] = json!(2);
        }
    }),
    Bug::behaviour("FW-ENV-19", "An id that was answered is refused when it comes again."),
    Bug::message(
        "FW-ENV-21",
        "Responses refer to ids without what isn't an ASCII letter, digit, - or _.",
        |out| {
            if let Some(refs) = out.message()["refs"].as_str() {
                let is_plain =
                    |character: &char| character.is_ascii_alphanumeric() || "-_".contains(*character);
                let plain: String = refs.chars().filter(is_plain).collect();
                out.message()["refs"] = json!(plain);
            }
        },
    )
    .with(&["FW-ENV-05", "FW-ENV-06"]),
    Bug::behaviour("FW-ENV-22", "A request that is malformed ends the connection."),
    Bug::message("FW-ENV-23", "Notifications have a key twice.", |out| {
        if out.is_notification() {
            out.write = |message| {
                let text = message.to_string();
                text.replacen('{', "{\"$fw.version\":\"1.0\",", 1)
            };
        }
    }),
    Bug::behaviour("FW-ENV-24", "Nothing of the family DEV is handled."),
    Bug::behaviour(
        "FW-ENV-25",
        "Over TCP, requests that come at once are answered from the last to the first.",
    ),
];
