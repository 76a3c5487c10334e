"""Requests and messages that no browser sends, to a workbench as a process: how each ended, and what went wrong."""

import asyncio
import contextlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest
from tornado.iostream import StreamClosedError
from tornado.websocket import websocket_connect

PATHS = (
    "/",
    "/ws",
    "/autoload.js",
    "/static/js/bokeh.min.js",
    "/static/%2e%2e/%2e%2e/etc/passwd",
    "/..%2f..%2f",
    "/%00",
)
BYTES = {"type": "bytes", "data": "AAAA"}
VALUES = (
    None, True, -1, 1e308, float("nan"), float("inf"), "", "x" * 50_000, "<script>alert(1)</script>",
    "../../etc/passwd", "é\ud7ff\x00", [], [[]], ["a", "b"], {}, {"id": "p999999"},
    {"type": "map", "entries": [[1, 2, 3]]},
    {"type": "nonsense"}, {"type": "bytes", "data": "!!!"}, {"type": "number", "value": "nan"},
    {"type": "object", "name": "os.system", "id": "x1"}, {"type": "symbol", "name": "a"},
    {"type": "set", "entries": [{}]},
    {"type": "object", "name": "FileInput", "id": "x2", "attributes": {"value": [1]}},
    {"type": "ndarray", "array": BYTES, "shape": [-1], "dtype": "object", "order": "little"},
    {"type": "ndarray", "array": BYTES, "shape": [1 << 40], "dtype": "float64", "order": "big"},
    {"type": "slice", "start": 0, "stop": 1 << 60, "step": 0},
)  # fmt: skip
KEYS = {
    "ModelChanged": ("model", "attr", "new"), "MessageSent": ("msg_type", "msg_data"), "TitleChanged": ("title",),
    "ColumnDataChanged": ("model", "attr", "data", "cols"), "RootAdded": ("model",), "RootRemoved": ("model",),
    "Nonsense": ("model", "new"),
}  # fmt: skip
PROJECT = re.escape(str(Path(__file__).parents[2]))
LEAK = re.compile(rf"site-packages|\.py\b|Traceback|root:x:|/tmp/|/home/|{PROJECT}")
LOG = "log.txt"


@contextlib.contextmanager
def serving(root, place):
    """The port of a workbench that runs in a folder and logs there."""
    words = [sys.executable, "-m", "pam_ident", "workbench", "--no-browser", "--port", "0"]
    environment = {**os.environ, "PYTHONPATH": str(root), "TMPDIR": str(place)}
    with (
        (place / LOG).open("w") as log,
        subprocess.Popen(words, stdout=subprocess.PIPE, stderr=log, text=True, cwd=place, env=environment) as process,
    ):
        assert process.stdout is not None
        try:
            yield int(re.search(r":(\d+)", process.stdout.readline())[1])
        finally:
            process.send_signal(signal.SIGINT)
            code = process.wait(20)
    assert code in (0, 130), code


def tried(count, seed, root):
    """How `count` requests ended, and the failures: what the log, an answer, or a later client shows."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        with serving(root, place) as port:
            ends, failures = asyncio.run(_all(port, count, seed))
        log = (place / LOG).read_text()
        if "Traceback" in log or 'File "' in log:
            failures.append(f"[{seed}] in the log: {log[-800:]}")
        left = sorted(one.name for one in place.iterdir() if one.name != LOG)
        if left:
            failures.append(f"[{seed}] left behind: {left}")
    return ends, failures


async def _all(port, count, seed):
    ends, failures = Counter(), []
    for k in range(count):
        rng = random.Random(f"{seed} {k}")
        ask = rng.choice((_page, _socket, _message, _patch, _patch, _patch))
        end, text = await asyncio.wait_for(ask(port, rng), 60)
        ends[end] += 1
        if leak := LEAK.search(text.replace("bokeh.min.js", "")):
            failures.append(
                f"[{seed}, {k}] {ask.__name__}: tells {text[max(leak.start() - 80, 0) : leak.end() + 80]!r}"
            )
        if (await _page(port, None))[0] != "answered":
            return ends, [*failures, f"[{seed}, {k}] {ask.__name__}: the next page is not answered"]
    session = await _connect(port)
    if not await _models(session):
        failures.append(f"[{seed}] a later client gets no page")
    await _leave(session)
    return ends, failures


async def _page(port, rng):
    """A page asked for in odd ways; without a stream an honest one."""
    words = {"headers": {"Host": f"127.0.0.1:{port}"}, "method": "GET", "request_timeout": 30}
    path = "/"
    if rng is not None:
        path = rng.choice(
            (*PATHS, f"/?bokeh-token={_junk(rng)}", "/" + "a" * 9000, f"/?{_junk(rng)}", f"/{_junk(rng)}")
        )
        words["method"] = rng.choice(("GET", "GET", "POST", "DELETE", "OPTIONS", "TRACE"))
        words["headers"]["Host"] = rng.choice(
            (f"127.0.0.1:{port}", f"127.0.0.1:{port}", "evil.example", f"[::1]:{port}", "")
        )
        words["headers"][rng.choice(("Cookie", "Range", "Origin", "X-Forwarded-Host", "Content-Type"))] = _junk(rng)
        words |= {"allow_nonstandard_methods": True, "body": "x" * 999 if words["method"] == "POST" else None}
    try:
        answer = await AsyncHTTPClient().fetch(
            HTTPRequest(f"http://127.0.0.1:{port}{path}", **words), raise_error=False
        )
    except (OSError, StreamClosedError, HTTPClientError, ValueError):
        return "refused", ""
    # The page itself tells the paths of its own scripts, which are the server's addresses and no files.
    return ("answered", "") if answer.code == 200 else ("refused", answer.body.decode("utf-8", "replace"))


def _junk(rng):
    return "".join(rng.choice("abcXYZ019.=-_%2f~") for _ in range(rng.randrange(1, 300)))


async def _connect(port, token=None, **headers):
    """A socket with a token, by default that of a new page."""
    if token is None:
        page = (await AsyncHTTPClient().fetch(f"http://127.0.0.1:{port}/")).body.decode()
        token = re.search(r'"token":"([^"]+)"', page)[1]
    request = HTTPRequest(f"ws://127.0.0.1:{port}/ws", headers=headers)
    found = await websocket_connect(request, subprotocols=["bokeh", token])
    for _ in range(3):
        await asyncio.wait_for(found.read_message(), 30)
    return found


async def _socket(port, rng):
    """A socket of another page, or with a token that was not given out."""
    try:
        if rng.random() < 0.5:
            await _connect(port, Origin=rng.choice(("http://evil.example", "null", f"http://127.0.0.1.evil:{port}")))
        else:
            await _connect(port, _junk(rng))
    except (HTTPClientError, OSError, StreamClosedError):
        return "refused", ""
    return "answered", "Traceback: a socket that should not be heard"


async def _models(session):
    """Identity and properties of the page's models."""
    await _send(session, "PULL-DOC-REQ", {})
    while text := await asyncio.wait_for(session.read_message(), 30):
        if isinstance(text, str) and '"doc"' in text[:20]:
            return dict(_in(json.loads(text)))
    return {}


def _in(item):
    """Identity and properties of the models in what was parsed from JSON."""
    if isinstance(item, dict):
        if item.get("type") == "object" and "id" in item:
            yield item["id"], list(item.get("attributes", {}))
        item = list(item.values())
    for value in item if isinstance(item, list) else ():
        yield from _in(value)


async def _send(session, kind, content, header=None):
    await session.write_message(json.dumps(header or {"msgid": "1000", "msgtype": kind}))
    await session.write_message("{}")
    await session.write_message(content if isinstance(content, str | bytes) else json.dumps(content))


async def _leave(session):
    """Hang up, and wait until the other end has."""
    session.close()
    with contextlib.suppress(TimeoutError, StreamClosedError):
        while await asyncio.wait_for(session.read_message(), 5) is not None:
            pass


async def _answers(session, patience_s=0.3):
    """What the server says to it, until it is silent or hangs up."""
    told = []
    while True:
        try:
            text = await asyncio.wait_for(session.read_message(), patience_s)
        except TimeoutError:
            return "answered", " ".join(told)
        if text is None:
            return "hung up", " ".join(told)
        told.append(text if isinstance(text, str) else "")


async def _message(port, rng):
    """A message that is none."""
    session = await _connect(port)
    header = rng.choice(
        ({}, {"msgid": "1"}, {"msgtype": "NOPE", "msgid": "1"}, [], 1, {"msgid": "1", "msgtype": "PATCH-DOC"})
    )
    content = rng.choice(("", "{", "[" * 5000, "null", b"\x00\xff", '{"events": 1}', '{"events": [[]]}', _junk(rng)))
    try:
        await _send(session, "PATCH-DOC", content, header)
        return await _answers(session)
    except (StreamClosedError, OSError, RuntimeError):
        return "hung up", ""
    finally:
        await _leave(session)


async def _patch(port, rng):
    """A patch of the document with what no widget gives."""
    session = await _connect(port)
    models = await _models(session)
    events = []
    for _ in range(rng.randrange(1, 4)):
        name = rng.choice(list(models))
        kind = rng.choice((*KEYS, "ModelChanged", "ModelChanged", "ModelChanged"))
        attribute = rng.choice([*models[name], "value", "filename", "active", "nonsense", "__class__"])
        event = dict.fromkeys(KEYS[kind], rng.choice(VALUES)) | {"kind": kind}
        event |= {"model": {"id": rng.choice((name, name, "p999999"))}} if "model" in event else {}
        event |= {"attr": attribute} if "attr" in event else {}
        event |= {"msg_type": "bokeh_event"} if "msg_type" in event else {}
        events.append(event)
    try:
        await _send(session, "PATCH-DOC", {"events": events})
        return await _answers(session)
    except (StreamClosedError, OSError, RuntimeError):
        return "hung up", ""
    finally:
        await _leave(session)


async def patched(port, token, model, value):
    """What the server says to a model's `value` being set so, by a page with this token."""
    session = await _connect(port, token)
    event = {"kind": "ModelChanged", "model": {"id": model}, "attr": "value", "new": value}
    await _send(session, "PATCH-DOC", {"events": [event]})
    told = (await _answers(session, 20.0))[1]
    await _leave(session)
    return told


if __name__ == "__main__":
    print(tried(int(sys.argv[1]), int(sys.argv[2]), Path(__file__).parents[2]))
