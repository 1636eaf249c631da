use uavspec_test_support::deadline;

use super::*;
use crate::bus::websocket::tests::{Peer, events, problems, send, server, text, topic};

const CALL: &str = r#"{"op":"call_service","id":"topics","service":"/rosapi/topics","args":{}}"#;

fn client(run: impl FnOnce(&mut Peer) + Send + 'static) -> Rosbridge {
    Rosbridge::connect(&server(run), &[]).expect("connect")
}

fn list_of(topics: &str, types: &str) -> String {
    format!(
        r#"{{"op":"service_response","id":"topics","service":"/rosapi/topics","values":{{"topics":{topics},"types":{types}}},"result":true}}"#
    )
}

/// The topic, the type and the text of each message.
fn received(events: &[Event]) -> Vec<(&str, &str, &str)> {
    let messages = events.iter().filter_map(|event| match event {
        Event::Message(message) => Some(message),
        _ => None,
    });
    messages
        .map(|Received { topic, payload, .. }| {
            (&*topic.name, &*topic.type_name, std::str::from_utf8(payload).expect("text"))
        })
        .collect()
}

#[test]
fn lists_topics_and_receives_messages_unchanged() {
    let mut bus = client(|peer| {
        assert_eq!(text(peer), r#"{"op":"subscribe","topic":"/a","compression":"none","type":"a/msg/B"}"#);
        assert_eq!(text(peer), CALL);
        let list = list_of(r#"["/b","/a"]"#, r#"["c/msg/D","a/msg/B"]"#);
        let messages = [r#"{"x": NaN, "text":"NaN"}"#, r#"{"x": null}"#];
        let [first, second] =
            messages.map(|message| format!(r#"{{"op":"publish","topic":"/a","msg": {message} }}"#));
        send(peer, &[&list, &first, &second]);
    });
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    let events = events(&mut bus);
    let [Event::Endpoint(a), Event::Endpoint(b), ..] = &events[..] else { panic!("{events:?}") };
    assert_eq!((a.topic.as_str(), b.topic.as_str(), b.type_name.as_str()), ("/a", "/b", "c/msg/D"));
    let expected =
        [r#"{"x": NaN, "text":"NaN"}"#, r#"{"x": null}"#].map(|payload| ("/a", "a/msg/B", payload));
    assert_eq!(received(&events), expected);
}

#[test]
fn subscribes_to_topics_of_unknown_type() {
    let mut bus = client(|peer| {
        assert_eq!(text(peer), r#"{"op":"subscribe","topic":"/a","compression":"none"}"#);
        text(peer);
        let message = r#"{"op":"publish","topic":"/a","msg":{}}"#;
        send(peer, &[message, &list_of(r#"["/a"]"#, r#"["a/msg/B"]"#), message]);
    });
    bus.subscribe(&Topic { type_name: "".into(), ..topic("/a") }, &Qos::WEAKEST).expect("subscribe");
    let events = events(&mut bus);
    assert_eq!(received(&events), [("/a", "", "{}"), ("/a", "a/msg/B", "{}")]);
}

#[test]
fn reports_changes_of_the_list() {
    let mut bus = client(|_| ());
    for names in [&["/a", "/b"][..], &["/a", "/c"]] {
        bus.update(names.iter().map(|name| ((*name).to_owned(), "T".into())).collect());
    }
    let events = events(&mut bus);
    let ids: Vec<&str> = events
        .iter()
        .filter_map(|event| match event {
            Event::Endpoint(endpoint) => Some(endpoint.id.as_str()),
            Event::Ended(id) => Some(id),
            _ => None,
        })
        .collect();
    assert_eq!(ids, ["/a", "/b", "/b", "/c"]);
    assert!(matches!(&events[2], Event::Ended(id) if id == "/b"));
}

#[test]
fn explains_that_it_cannot_publish() {
    let error = client(|_| ()).advertise(&topic("/a"), &Qos::PX4).expect_err("not supported");
    assert!(error.ends_with("connect with dds://, zenoh:// or foxglove://"), "{error}");
}

#[test]
fn explains_a_missing_rosapi() {
    let mut bus = client(|peer| {
        text(peer);
        let answer = r#"{"op":"service_response","service":"/rosapi/topics","values":"does not exist","result":false}"#;
        send(peer, &[answer]);
    });
    let events = events(&mut bus);
    let problem = problems(&events)[0];
    assert!(problem.contains("\"does not exist\"") && problem.ends_with("with --topics"), "{problem}");
}

#[test]
fn subscribes_to_named_topics_without_rosapi_until_messages_arrive() {
    let peer = server(|peer| {
        assert_eq!(text(peer), CALL);
        send(
            peer,
            &[r#"{"op":"service_response","service":"/rosapi/topics","values":"none","result":false}"#],
        );
        for _ in 0..2 {
            assert_eq!(text(peer), r#"{"op":"subscribe","topic":"/a","compression":"none"}"#);
        }
        send(peer, &[r#"{"op":"publish","topic":"/a","msg":{}}"#]);
    });
    let mut bus = Rosbridge::connect(&peer, &["/a".to_owned()]).expect("connect");
    let problem = bus.receive(deadline());
    let Some(Event::Problem(problem)) = problem else { panic!("{problem:?}") };
    assert!(problem.contains("full names are given"), "{problem}");
    bus.subscribe_names();
    let events = events(&mut bus);
    assert_eq!(received(&events), [("/a", "", "{}")]);
    assert_eq!(bus.names, Vec::<String>::new());
}

#[test]
fn reports_a_rosapi_that_does_not_answer() {
    let mut bus = client(|_| ());
    (bus.due, bus.is_requested) = (Clock::real().now(), true);
    let events = events(&mut bus);
    assert!(problems(&events)[0].contains("no answer within 10s"), "{events:?}");
}

#[test]
fn asks_again_after_a_failure() {
    let mut bus = client(|peer| {
        assert_eq!(text(peer), CALL);
        send(peer, &[&list_of(r#"["/a"]"#, "[]")]);
        assert_eq!(text(peer), CALL);
        send(peer, &[&list_of(r#"["/a"]"#, r#"["a/msg/B"]"#)]);
    });
    let problem = bus.receive(deadline());
    assert!(
        matches!(&problem, Some(Event::Problem(text)) if text.contains("1 topics but 0 types")),
        "{problem:?}"
    );
    bus.fail("a second failure isn't reported");
    bus.due = Clock::real().now();
    let found = bus.receive(deadline());
    assert!(matches!(found, Some(Event::Endpoint(_))), "{found:?}");
    assert!(!bus.has_failed);
}

#[test]
fn accepts_a_late_list() {
    let (timed_out, wait) = std::sync::mpsc::channel::<()>();
    let mut bus = client(move |peer| {
        assert_eq!(text(peer), CALL);
        let _ = wait.recv();
        send(peer, &[&list_of(r#"["/a"]"#, r#"["a/msg/B"]"#)]);
    });
    assert!(bus.receive(Clock::real().now() + Duration::from_millis(50)).is_none());
    (bus.due, bus.is_requested) = (Clock::real().now(), true);
    assert!(matches!(bus.receive(deadline()), Some(Event::Problem(_))));
    drop(timed_out);
    assert!(matches!(bus.receive(deadline()), Some(Event::Endpoint(_))));
    assert!(!bus.has_failed);
}

#[test]
fn refused_topics_are_not_received() {
    let mut bus = client(|peer| {
        text(peer);
        for (id, level) in [("topics", "error"), ("", "warning"), ("", "error")] {
            let status = format!(r#"{{"op":"status","id":"{id}","level":"{level}","msg":"no type {id}"}}"#);
            send(peer, &[&status]);
        }
    });
    let events = events(&mut bus);
    let [Event::Problem(_), Event::Problem(_), Event::Unreadable(text), _] = &events[..] else {
        panic!("{events:?}");
    };
    assert_eq!(text, "the server reports a problem: \"no type \"");
}

/// A message that is nested too deeply is reported instead of passed on.
#[test]
fn reports_each_hostile_message() {
    let deep =
        |close: &str| format!(r#"{{"op":"publish","topic":"/a","msg":{}"#, "[".repeat(100_000)) + close;
    let texts = [
        String::new(),
        deep(""),
        " ".to_owned() + &deep(&("]".repeat(100_000) + "}")),
        r#"{"op":"publish","topic":"/a"}"#.to_owned(),
        r#"{"op":"publish","msg":{}}"#.to_owned(),
        r#"{"op":"publish","topic":"/other","msg":1}"#.to_owned(),
        r#"{"op":"fragment","id":"1","data":"x","num":0,"total":9}"#.to_owned(),
        r#"{"op":"png","data":"x"}"#.to_owned(),
        r#"{"op":"status","level":"error","msg":"no type"}"#.to_owned(),
        list_of(r#"["/a"]"#, "[]"),
        list_of("[]", "[]"),
        "NaN\"\\".to_owned(),
    ];
    let count = texts.len() + 1;
    let mut bus = client(move |peer| {
        assert!(text(peer).contains("subscribe"));
        text(peer);
        for text in &texts {
            send(peer, &[text]);
        }
        peer.send(tungstenite::Message::binary(b"\x9f\x9f".to_vec())).expect("send");
    });
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    let events = events(&mut bus);
    assert_eq!(problems(&events).len(), count + 1, "{events:#?}");
    assert!(received(&events).is_empty());
}

#[test]
fn limits_the_list_of_topics() {
    let mut bus = client(|peer| {
        text(peer);
        let names: Vec<String> = (0..MAX_ENDPOINTS + 5).map(|number| format!("\"/{number}\"")).collect();
        let list = format!("[{}]", names.join(","));
        send(peer, &[&list_of(&list, &list)]);
    });
    let events = events(&mut bus);
    assert!(problems(&events)[0].contains("after the first 10000"), "{:?}", problems(&events));
    assert_eq!(bus.topics.len(), MAX_ENDPOINTS);
}
