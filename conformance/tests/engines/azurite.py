"""Checks captures in a container of Azure: azurite.py UAVSPEC AZURITE

Azurite is Microsoft's emulator of Azure's storage.
"""

import json
import os
import socket
import subprocess
import sys
import tempfile
import time

from azure.core.exceptions import ServiceRequestError
from azure.storage.blob import BlobServiceClient

UAVSPEC, AZURITE = sys.argv[1:]
# Everyone knows the account of the emulator.
ACCOUNT = "devstoreaccount1"
KEY = "Eby8vdM02xNOcqFlqUwJPLlmEtlCDXJ1OUzFT50uSRZ6IFsuFq2UVErCz4I6tq/K1SZFPTOtr/KBHBeksoGMGw=="
MESSAGE = {"timestamp": 1_000, "request_id": 300, "valid_registrations_mask": 1}
LINE = json.dumps({"type": "px4/ArmingCheckRequest", "message": MESSAGE}) + "\n"
# The large one has several ranges.
CAPTURES = {"a.jsonl": 3, "2026/b c.jsonl": 3, "2026/ä%41+&.jsonl": 3, "large.jsonl": 90_000}

with socket.create_server(("127.0.0.1", 0)) as free:
    port = free.getsockname()[1]
emulator = subprocess.Popen(
    [AZURITE, "--inMemoryPersistence", "--blobPort", str(port), "--silent", "--skipApiVersionCheck", "--disableTelemetry"]
)
address = f"http://127.0.0.1:{port}"
client = BlobServiceClient(f"{address}/{ACCOUNT}", credential={"account_name": ACCOUNT, "account_key": KEY}, retry_total=0)
end = time.monotonic() + 60
while True:
    try:
        container = client.create_container("flights")
        break
    except ServiceRequestError:
        assert emulator.poll() is None and time.monotonic() < end, "the emulator doesn't start"
        time.sleep(0.2)
environment = os.environ | {"AZURE_STORAGE_USE_EMULATOR": "true", "AZURITE_BLOB_STORAGE_URL": address, "AZURE_ALLOW_HTTP": "true"}
tables = os.path.join(tempfile.mkdtemp(), "tables")


def upload(name, lines):
    container.get_blob_client(name).upload_blob(LINE * lines, overwrite=True)


def check(url):
    command = [UAVSPEC, "check", "--resume", tables, url]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    return run.returncode, run.stdout + run.stderr


try:
    for name, lines in CAPTURES.items():
        upload(name, lines)
    status, text = check("az://flights/2026/")
    assert status == 1 and "0 of 2 captures" in text, text
    status, text = check("az://flights/")
    assert status == 1 and "2 of 4 captures" in text and "PX-JSON-02 (90,000)" in text, text
    status, text = check("az://flights/")
    assert status == 0 and "4 of 4 captures" in text, text
    upload("a.jsonl", 4)
    status, text = check("az://flights/")
    assert status == 1 and "3 of 4 captures" in text and "PX-JSON-02 (4)" in text, text
    status, text = check("az://absent/")
    assert status == 3 and "az://absent/" in text and KEY not in text, text
finally:
    emulator.kill()
