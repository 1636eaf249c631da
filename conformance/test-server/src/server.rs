//! Servers for tests of clients.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread;

use serde_json::{Value, json};
use uavspec_serve::{Options, Server, Transport};

/// An address on this computer with any free port.
pub fn location() -> SocketAddr {
    ([127, 0, 0, 1], 0).into()
}

/// Starts the reference server, and returns its address.
pub fn serve(options: Options, transport: Transport) -> (Server, SocketAddr) {
    let server = Server::start(options, &[(transport, location())]).expect("it starts");
    let address = server.listening()[0].address;
    (server, address)
}

/// Starts a server that handles each client with a function. Returns its address.
pub fn custom_server(serve: impl Fn(TcpStream) + Send + 'static) -> SocketAddr {
    let listener = TcpListener::bind(location()).expect("a port");
    let address = listener.local_addr().expect("an address");
    thread::spawn(move || listener.incoming().flatten().for_each(serve));
    address
}

/// Answers each request with the body that `body` returns for its type. If it returns `None`, the request isn't
/// answered.
pub fn answer_requests(mut stream: TcpStream, body: impl Fn(&str, &Value) -> Option<Value>) {
    let reader = BufReader::new(stream.try_clone().expect("a second handle"));
    for line in reader.lines().map_while(Result::ok) {
        let request: Value = serde_json::from_str(&line).expect("a request");
        let kind = request["body"]["type"].as_str().expect("a type");
        let Some(mut body) = body(kind, &request["body"]) else { continue };
        body["type"] = json!(kind);
        let answer = json!({ "$fw.version": "1.0", "id": "a", "refs": request["id"], "body": body });
        if writeln!(stream, "{answer}").is_err() {
            return;
        }
    }
}
