"""Checks captures in an object store that fails: stores.py UAVSPEC

moto, a server with the API of S3, serves the captures. A proxy before it returns errors, stalls, cuts bodies, and changes an
object while it is read. The tables must be those of the files, whatever happens.
"""

import http.client
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import boto3
import duckdb
from moto.server import ThreadedMotoServer

UAVSPEC = sys.argv[1]
BUCKET = "flights"
SECRET = "a-secret-that-nobody-may-see"
FOLDER = tempfile.mkdtemp()
# Larger than two ranges.
LARGE = "large.jsonl"


def write(name, count):
    """Writes a capture with arming check requests. Every hundredth violates its definition."""
    with open(os.path.join(FOLDER, name), "w", encoding="utf-8") as file:
        for number in range(count):
            request = {
                "timestamp": 1_000_000 + 300_000 * number,
                "request_id": 300 if number % 100 == 99 else number % 256,
                "valid_registrations_mask": 1,
            }
            message = {"op": "publish", "topic": "/fmu/out/arming_check_request", "msg": request}
            file.write(json.dumps(message) + "\n")


for index in range(12):
    write(f"flight_{index:02}.jsonl", 50 * index + 7)
write(LARGE, 70_000)
NAMES = sorted(os.listdir(FOLDER))


class Proxy(BaseHTTPRequestHandler):
    """Passes requests on, and spoils some of them."""

    protocol_version = "HTTP/1.1"
    faults = {}
    requests = {}
    lock = threading.Lock()
    delay = 0
    changes = None

    def log_message(self, *_):
        pass

    def do_GET(self):
        self.answer()

    def do_HEAD(self):
        self.answer()

    def answer(self):
        key = self.path.split("?")[0]
        with self.lock:
            number = self.requests[key] = self.requests.get(key, 0) + 1
        fault = self.faults.get((key, number), self.faults.get(number)) if self.command == "GET" else None
        time.sleep(self.delay)
        if fault in (500, 503):
            return self.send(fault, [], b"")
        if fault == "stall":
            time.sleep(22)
            self.close_connection = True
            return None
        if self.changes and key.endswith(self.changes) and self.headers.get("Range", "bytes=0-") != "bytes=0-4194303":
            Proxy.changes = None
            store.put_object(Bucket=BUCKET, Key=LARGE, Body=b"other bytes" * 900_000)
        connection = http.client.HTTPConnection("127.0.0.1", port)
        # The host is part of the signature.
        connection.request(self.command, self.path, headers=dict(self.headers))
        response = connection.getresponse()
        body = response.read()
        cut = body[: len(body) // 2] if fault == "cut" else body
        length = response.headers["Content-Length"] if self.command == "HEAD" else str(len(body))
        skipped = ("content-length", "transfer-encoding", "connection")
        headers = [(name, value) for name, value in response.getheaders() if name.lower() not in skipped]
        self.send(response.status, [*headers, ("Content-Length", length)], cut)
        self.close_connection = cut is not body
        return None

    def send(self, status, headers, body):
        self.send_response(status)
        for name, value in headers or [("Content-Length", str(len(body)))]:
            self.send_header(name, value)
        self.end_headers()
        try:
            if self.command == "GET":
                self.wfile.write(body)
        except BrokenPipeError:
            # The program was killed.
            self.close_connection = True


server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
server.start()
_, port = server.get_host_and_port()
store = boto3.client(
    "s3",
    endpoint_url=f"http://127.0.0.1:{port}",
    region_name="us-east-1",
    aws_access_key_id="key",
    aws_secret_access_key=SECRET,
)
store.create_bucket(Bucket=BUCKET)
proxy = ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
threading.Thread(target=proxy.serve_forever, daemon=True).start()
environment = os.environ | {
    "AWS_ENDPOINT": f"http://127.0.0.1:{proxy.server_port}",
    "AWS_ALLOW_HTTP": "true",
    "AWS_REGION": "us-east-1",
    "AWS_ACCESS_KEY_ID": "key",
    "AWS_SECRET_ACCESS_KEY": SECRET,
}
# The tables are outside of the folder that is checked.
out = tempfile.mkdtemp()


def upload():
    for name in NAMES:
        store.upload_file(os.path.join(FOLDER, name), BUCKET, name, ExtraArgs={"ACL": "public-read"})


def start(tables, *arguments):
    command = [UAVSPEC, "check", "--resume", os.path.join(out, tables), *arguments]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def check(tables, source=f"s3://{BUCKET}/"):
    process = start(tables, source)
    text = process.communicate()[0]
    assert SECRET not in text, text
    return process.returncode, text


def rows(tables, table):
    """The rows of a table, with the names of the captures instead of their URLs."""
    columns = "* EXCLUDE (capture, etag)" if table == "captures" else "* EXCLUDE (capture)"
    query = f"SELECT {columns}, parse_filename(capture) AS name FROM '{out}/{tables}/{table}/*.parquet'"
    return sorted(map(str, duckdb.sql(query).fetchall()))


def expect_complete(tables):
    for table in ("captures", "findings", "rules", "topics"):
        assert rows(tables, table) == rows("files", table), f"{tables}: {table} differs"
    assert rows(tables, "failures") == []


check("files", FOLDER)
assert len(rows("files", "captures")) == len(NAMES)

# Errors, cut bodies and a stall.
upload()
Proxy.faults = {1: 500, 2: 503, 3: "cut"}
status, text = check("faults")
assert status in (0, 1), text
expect_complete("faults")
Proxy.requests, Proxy.faults = {}, {(f"/{BUCKET}/{LARGE}", 1): "stall"}
status, text = check("stalls")
assert status in (0, 1), text
expect_complete("stalls")
Proxy.faults = {}
print("faults are overcome")

# A second run has nothing to do.
status, text = check("faults")
assert status == 0 and f"{len(NAMES)} of {len(NAMES)} captures are in the tables already" in text, text
expect_complete("faults")
print("captures are checked once")

# Google's store has the same lists and objects. The requests aren't signed, so the objects are public.
environment |= {"GOOGLE_BASE_URL": environment["AWS_ENDPOINT"], "GOOGLE_SKIP_SIGNATURE": "true", "GOOGLE_ALLOW_HTTP": "true"}
status, text = check("google", f"gs://{BUCKET}/")
assert status in (0, 1), text
expect_complete("google")
print("captures with URLs of Google are checked")

# An object changes while it is read: it fails, and the next run checks the new version.
Proxy.changes = LARGE
status, text = check("changes")
assert status == 3 and "the object changed while it was read" in text, text
assert len(rows("changes", "captures")) == len(NAMES) - 1
assert len(rows("changes", "failures")) == 1
upload()
status, text = check("changes")
assert status in (0, 1) and "1 are left" in text, text
expect_complete("changes")
print("changed objects are checked again")

# A run is killed again and again.
Proxy.delay = 0.05
for attempt in range(100):
    process = start("kills", "--jobs", "1", f"s3://{BUCKET}/")
    try:
        process.communicate(timeout=0.5 + attempt)
        break
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.communicate()
assert attempt > 0, "no run was killed"
expect_complete("kills")
print("killed runs continue")

# Wrong credentials and buckets are explained without the secret.
status, text = check("absent", "s3://no-such-bucket/")
assert status == 3 and "no-such-bucket" in text, text
print("errors name the URL")
os._exit(0)
