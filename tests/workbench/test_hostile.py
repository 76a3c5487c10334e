"""Fifty sessions at once, files that are too large, and two hundred patches that no browser sends."""

import asyncio
import base64
import contextlib
import datetime
import gzip
import http.client
import re
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

pytest.importorskip("panel")
pytestmark = pytest.mark.long

sys.path.insert(0, str(Path(__file__).parent))

import hostile  # noqa: E402
from test_attack import Client, asked, fresh_token, served  # noqa: E402, F401
from tornado.httpclient import HTTPRequest  # noqa: E402
from tornado.iostream import StreamClosedError  # noqa: E402
from tornado.websocket import WebSocketClosedError, websocket_connect  # noqa: E402

from pam_ident.workbench.draft import MOST_UNPACKED  # noqa: E402
from pam_ident.workbench.server import MOST_BYTES  # noqa: E402

SESSIONS = 50
LIFETIME_S = 40
"""After so long Bokeh has dropped a session that nobody looks at (15 s and a round of 17 s)."""
ROWS = 15
"""Too few to name anything by: what is drawn of them is as large, and is there in a moment."""


def files(number):
    """A record of a name and a length of its own, with the forces of an ideal braid."""
    rows = []
    for k in range(ROWS):
        p, x = 0.2 + 0.1 * (k // 5), 4.0 * (k % 5)
        e = x / (200.0 + number)
        rows.append(f"{0.1 * k:.1f},{p},{x},{314.16 * p * (13.3 * (1 - e) ** 2 - 5.43):.3f}")
    head = f'[specimen]\nname = "made"\ninitial_length_mm = {200 + number}\n'
    specimen = head + "initial_radius_mm = 10.0\nbraid_angle_deg = 25.4\n"
    table = "time_s,pressure_MPa,displacement_mm,force_N\n" + "\n".join(rows) + "\n"
    return (f"run{number:03d}.csv", table.encode()), ("specimen.toml", specimen.encode())


def told(client):
    """All that a client's page says."""
    client.pull()
    return " ".join(str(one.text) for one in client.models("HTML"))


def wait_for(client, word, seconds=240):
    end = time.monotonic() + seconds
    while word not in (text := told(client)):
        assert time.monotonic() < end, f"{word} is not in {text[-500:]}"
        time.sleep(0.2)
    return text


def memory_MiB(place, key="VmRSS"):
    """Of the workbench whose folder this is."""
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            ours = (status.parent / "cwd").resolve() == place and b"workbench" in (
                status.parent / "cmdline"
            ).read_bytes()
            if ours:
                return int(re.search(rf"{key}:\s+(\d+)", status.read_text())[1]) / 1024
        except OSError:
            continue
    raise AssertionError("no such process")


def many(port, first):
    """Sessions at once, each with a record of its own; each sees its own alone."""
    clients = [Client(port) for _ in range(SESSIONS)]
    for k, client in enumerate(clients, first):
        client.drop(*files(k))
    for k, client in enumerate(clients, first):
        others = set(re.findall(r"run(\d{3})", wait_for(client, f"run{k:03d}"))) - {f"{k:03d}"}
        assert not others, f"session {k} sees {others}"
    for client in clients:
        client.close()


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
def test_fifty_sessions_see_their_own_and_give_their_memory_back(served):  # noqa: F811
    port, place = served
    begun = memory_MiB(place)
    used = []
    for first in (100, 200):
        many(port, first)
        time.sleep(LIFETIME_S)
        asked(port, "/")
        used.append(memory_MiB(place))
    # What a first round leaves is code and caches; if sessions stayed, each round would add as much.
    assert used[1] - used[0] < 0.3 * (used[0] - begun), f"{begun:.0f} MiB at first, then {used}"


def test_a_message_larger_than_the_limit_ends_its_connection(served):  # noqa: F811
    port, place = served

    async def shout():
        request = HTTPRequest(f"ws://127.0.0.1:{port}/ws")
        session = await websocket_connect(request, subprotocols=["bokeh", fresh_token(port)])
        for _ in range(3):
            await session.read_message()
        with contextlib.suppress(StreamClosedError, WebSocketClosedError):
            await session.write_message("x" * (MOST_BYTES + 1))
        told = await asyncio.wait_for(session.read_message(), 60)
        session.close()
        return told

    assert asyncio.run(shout()) is None
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=30)) as connection:
        connection.putrequest("POST", "/", skip_host=True)
        connection.putheader("Host", f"127.0.0.1:{port}")
        connection.putheader("Content-Length", str(8 << 30))
        connection.endheaders()
        with contextlib.suppress(ConnectionError, http.client.HTTPException):
            assert connection.getresponse().status >= 400
    assert asked(port, "/")[0] == 200 and memory_MiB(place, "VmHWM") < 2048


def test_a_small_file_that_is_large_inside_is_told(served):  # noqa: F811
    port, place = served
    member = gzip.compress(b"0,0.3,1,500\n" * (1 << 23))
    name, content = "bomb.csv.gz", member * (MOST_UNPACKED // (12 << 23) + 1)
    assert len(content) < MOST_BYTES // 32
    client = Client(port)
    client.drop((name, content), files(1)[1])
    text = wait_for(client, "unpacks to more than", 120)
    assert str(place) not in text
    (target,), token = client.models("FileInput"), client.token
    client.close()
    packed = {"type": "bytes", "data": base64.b64encode(gzip.compress(bytes(1 << 30), 1)).decode()}
    found = asyncio.run(hostile.patched(port, token, target.id, packed))
    assert "unpacks to more than" in found and not hostile.LEAK.search(found)
    assert asked(port, "/")[0] == 200 and memory_MiB(place, "VmHWM") < 2048


def test_two_hundred_requests_that_no_browser_sends(root):
    seed = int(datetime.datetime.now(datetime.UTC).strftime("%Y%m%d"))
    ends, failures = hostile.tried(200, seed, root)
    assert not failures, failures
    assert set(ends) == {"answered", "refused", "hung up"}
