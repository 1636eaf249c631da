//! Faults in the processing of requests. In `testee MODE [ID]`, the fault affects the request with this id, or all
//! requests if there is no id.

use std::io::{self, Write};
use std::time::Duration;
use std::{process, thread};

use serde_json::{Value, json};
use uavspec_dynamic::Types;
use uavspec_runtime::Scalar;
use uavspec_schema::Element;

/// The size of a flood in bytes, larger than a pipe's buffer.
const FLOOD: usize = 200 << 10;

pub(crate) struct RequestFault {
    mode: String,
    id: Option<u64>,
    /// A delayed response, and the number of responses to send before it.
    held: Option<(String, usize)>,
}

impl RequestFault {
    pub(crate) fn read(arguments: &[String]) -> Self {
        let mode = arguments.first().cloned().unwrap_or_default();
        Self { mode, id: arguments.get(1).and_then(|id| id.parse().ok()), held: None }
    }

    pub(crate) fn is(&self, mode: &str) -> bool {
        self.mode == mode
    }

    pub(crate) fn at_start(&self) {
        match self.mode.as_str() {
            "exit" => {
                eprintln!("out of cheese");
                process::exit(7);
            }
            "bad-hello" => println!("hello, world"),
            _ => {}
        }
    }

    /// In some modes, misbehaves instead of responding. `count` is the number of requests so far, including the hello.
    pub(crate) fn instead(&self, count: usize, request: &Value, output: &mut impl Write) -> io::Result<bool> {
        if self.is("crash-third") && count == 3 {
            process::exit(4);
        }
        if self.id.is_some() && request["id"].as_u64() != self.id {
            return Ok(false);
        }
        match self.mode.as_str() {
            "hang" => hang(),
            "crash" => {
                eprintln!("no field of that name");
                process::exit(3);
            }
            "orphan" => {
                // This process keeps the pipes open, and outlives its parent.
                let orphan = process::Command::new("sleep").arg("600").spawn()?;
                eprintln!("{}", orphan.id());
                process::exit(5);
            }
            "wrong-id" => writeln!(output, "{}", json!({ "id": 1_000_000, "ok": null }))?,
            "babble" => loop {
                writeln!(output, "{}", json!({ "id": 1_000_000, "ok": null }))?;
            },
            "not-utf8" => {
                write!(output, "{{\"id\":{},\"ok\":\"", request["id"])?;
                output.write_all(b"\xff\"}\n")?;
            }
            "endless" => loop {
                output.write_all(&[b'x'; 4096])?;
            },
            "flood" => {
                eprintln!("{}", "x".repeat(FLOOD));
                return Ok(false);
            }
            "repeat" => {
                writeln!(output, "{}", json!({ "id": request["id"], "unsupported": true }))?;
                return Ok(false);
            }
            _ => return Ok(false),
        }
        output.flush()?;
        Ok(true)
    }

    /// In modes that imitate buggy codecs, corrupts the response.
    pub(crate) fn corrupt(&self, types: &Types, request: &Value, answer: &mut Value) {
        let name = request["type"].as_str().and_then(|name| name.split_once('/'));
        let Some(message) = name.and_then(|(package, name)| types.find(package, name)) else { return };
        if request["op"] != "decode" {
            return;
        }
        for field in message.fields() {
            let Some(value) = answer.get_mut("ok").and_then(|ok| ok.get_mut(&*field.name)) else { continue };
            match field.element {
                Element::Scalar(Scalar::UInt16) if self.is("swap-uint16") => each(value, &swap),
                Element::Scalar(scalar) if scalar.is_float() && self.is("drop-nan") => {
                    each(value, &drop_nan);
                }
                _ => {}
            }
        }
    }

    pub(crate) fn write(&mut self, answer: &Value, output: &mut impl Write) -> io::Result<()> {
        let line = format!("{answer}\n");
        if self.is("later") && answer["id"].as_u64() == self.id {
            self.held = Some((line, 3));
            return Ok(());
        }
        if let Some((held, others)) = &mut self.held {
            *others = others.saturating_sub(1);
            if *others == 0 {
                output.write_all(held.as_bytes())?;
                self.held = None;
            }
        }
        if !self.is("split") {
            return output.write_all(line.as_bytes());
        }
        for part in line.as_bytes().chunks(7) {
            output.write_all(part)?;
            output.flush()?;
            thread::yield_now();
        }
        Ok(())
    }
}

fn hang() {
    loop {
        thread::sleep(Duration::from_secs(60));
    }
}

fn each(value: &mut Value, change: &dyn Fn(&mut Value)) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(change),
        other => change(other),
    }
}

fn swap(value: &mut Value) {
    if let Some(number) = value.as_u64().and_then(|number| u16::try_from(number).ok()) {
        *value = number.swap_bytes().into();
    }
}

fn drop_nan(value: &mut Value) {
    if value.get("$f").is_some() {
        *value = json!(0.0);
    }
}
