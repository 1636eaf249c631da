//! Targets for the reference server.

use serde_json::json;
use uavspec_check::FlockwaveChecker;
use uavspec_flockwave::transport::lines::{Line, Lines};
use uavspec_model::json::Tree;
use uavspec_model::{Group, Level};
use uavspec_rules::flockwave::env_19;
use uavspec_rules::flockwave::sample::Session;
use uavspec_serve::driver::{Side, transcript};

use super::{DEFINITIONS, Pieces};

/// The byte that separates datagrams. It never occurs in UTF-8.
const SEPARATOR: u8 = 0xff;

/// The maximum length of a line, in bytes.
const MAX_LINE: usize = 1 << 20;

/// Sends lines to the server. The line splitter must find the same lines if the stream arrives in pieces.
pub(super) fn tcp(data: &[u8]) {
    let whole = lines(&mut &data[..]);
    assert_eq!(lines(&mut Pieces::new(data)), whole);
    let length: usize = whole.iter().map(Vec::len).sum();
    assert!(length <= data.len(), "{length} bytes from {}", data.len());
    exchange(whole.iter().map(Vec::as_slice), false);
}

/// Splits a stream into lines.
fn lines(stream: &mut dyn std::io::Read) -> Vec<Vec<u8>> {
    let (mut lines, mut found, mut piece) = (Lines::new(MAX_LINE), Vec::new(), [0; 1 << 10]);
    while let Ok(length @ 1..) = stream.read(&mut piece) {
        lines.feed(&piece[..length]);
        found.extend(lines.taken().into_iter().filter_map(|line| match line {
            Line::Whole(line) => Some(line),
            Line::TooLong => None,
        }));
    }
    found
}

/// Sends datagrams to the server.
pub(super) fn udp(data: &[u8]) {
    exchange(data.split(|byte| *byte == SEPARATOR), true);
}

/// Sends messages to the server. Its responses must conform to the specification.
fn exchange<'m>(messages: impl Iterator<Item = &'m [u8]>, is_datagram: bool) {
    let mut checker = FlockwaveChecker::new(&DEFINITIONS);
    let (connection, end) = if is_datagram { ("udp-hill", "") } else { ("tcp-hill", "\n") };
    let (mut number, mut recording) = (0, String::new());
    for record in transcript(messages, is_datagram) {
        let text = std::str::from_utf8(&record.bytes).ok().filter(|text| Tree::read(text).is_ok());
        assert!(text.is_some() || record.side == Side::Client, "the server sent invalid JSON: {record:?}");
        let content = match text {
            // A line end between JSON tokens is insignificant.
            Some(text) => format!("\"msg\":{}", text.replace(['\n', '\r'], " ")),
            // The line end ensures that no later line continues the text.
            None => format!("\"raw\":{}", json!(format!("{}{end}", String::from_utf8_lossy(&record.bytes)))),
        };
        let direction = if record.side == Side::Server { "in" } else { "out" };
        let line =
            format!("{{\"t\":{},\"conn\":\"{connection}\",\"dir\":\"{direction}\",{content}}}", record.time);
        number += 1;
        checker.line(line.as_bytes(), number, false);
        recording += &line;
        recording.push('\n');
    }
    let result = checker.finish(0);
    assert!(result.corruption.is_empty(), "{:?}\n{recording}", result.corruption);
    // One rule is about clients.
    let is_about_server =
        |group: &&Group| group.rule.level == Level::Must && group.rule.id != env_19::RULE.rule.id;
    if let Some(group) = result.findings.groups().find(is_about_server) {
        panic!("the server violates {}: {:?}\n{recording}", group.rule.id, group.examples);
    }
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let session = Session::new();
    let from_client = session.lines.iter().filter(|line| line["dir"] == "out").map(|line| &line["msg"]);
    let messages = from_client.filter(|message| !message.is_null());
    let mut seeds: Vec<Vec<u8>> = messages.map(|message| format!("{message}\n").into_bytes()).collect();
    let datagrams: Vec<Vec<u8>> = seeds.iter().take(6).cloned().collect();
    seeds.push(datagrams.join(&SEPARATOR));
    seeds.push(datagrams.concat());
    seeds
}
