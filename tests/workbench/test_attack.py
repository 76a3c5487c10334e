"""The workbench as a process, asked by pages and clients that mean no good: they are refused, and it lives on."""

import asyncio
import base64
import http.client
import json
import re
import sys
from contextlib import closing
from pathlib import Path

import pytest

pytest.importorskip("panel")
pytestmark = pytest.mark.long

sys.path.insert(0, str(Path(__file__).parent))

import hostile  # noqa: E402
from bokeh.client import ClientSession  # noqa: E402
from bokeh.document.events import MessageSentEvent  # noqa: E402
from bokeh.events import DocumentReady  # noqa: E402
from bokeh.util.token import get_session_id  # noqa: E402
from panel.models.esm import DataEvent, ReactiveESM  # noqa: E402
from tornado.httpclient import HTTPClientError, HTTPRequest  # noqa: E402
from tornado.websocket import websocket_connect  # noqa: E402

import pam_ident.workbench.cards  # noqa: E402, F401 - a client decodes only models that it knows


@pytest.fixture(scope="module")
def served(root, tmp_path_factory):
    """Port and folder of a workbench; in the end nothing was left in the folder, and no traceback in the log."""
    place = tmp_path_factory.mktemp("served")
    with hostile.serving(root, place) as port:
        yield port, place
    text = (place / hostile.LOG).read_text()
    assert "Traceback" not in text and 'File "' not in text, text[-2000:]
    assert [one.name for one in place.iterdir()] == [hostile.LOG]


def asked(port, path, host=None):
    """Status and text of an answer to a request that names a host."""
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=30)) as connection:
        connection.putrequest("GET", path, skip_host=True)
        connection.putheader("Host", host if host is not None else f"127.0.0.1:{port}")
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.read().decode("utf-8", "replace")


def fresh_token(port):
    """The token of a new page."""
    return re.search(r'"token":"([^"]+)"', asked(port, "/")[1])[1]


def socket_answers(port, token, **headers):
    """Whether a socket with this token and these headers is heard."""

    async def connect():
        request = HTTPRequest(f"ws://127.0.0.1:{port}/ws", headers=headers)
        connection = await websocket_connect(request, subprotocols=["bokeh", token])
        message = await asyncio.wait_for(connection.read_message(), 20)
        connection.close()
        await asyncio.wait_for(connection.read_message(), 20)
        return message is not None

    try:
        return asyncio.run(connect())
    except HTTPClientError as error:
        assert error.code == 403
        return False


class Client(ClientSession):
    """A client with the token of a page, that may send what it likes."""

    def __init__(self, port):
        self.given = fresh_token(port)
        super().__init__(get_session_id(self.given), f"ws://127.0.0.1:{port}/ws")
        self.pull()
        ready = MessageSentEvent(self.document, "bokeh_event", DocumentReady())
        self.document.callbacks.trigger_on_change(ready)

    @property
    def token(self):
        return self.given

    def pull(self):
        """The page as it is now. While it is put in place, nothing is sent: the server would take it for a new page."""
        if self.document is not None:
            self.document.callbacks.remove_on_change(self)
        super().pull()
        self.document.callbacks.on_change_dispatch_to(self)

    def models(self, kind):
        """The page's models of a kind."""
        return [one for one in self.document.models if type(one).__name__ == kind]

    def send(self, model, **values):
        """Set properties at once, also those that only a browser sets."""
        self.document.hold("combine")
        for name, value in values.items():
            model.set_from_json(name, value)
        self.document.unhold()
        self.force_roundtrip()

    def drop(self, *files):
        """Give files, names with contents, to the page."""
        names, contents = zip(*files, strict=True)
        self.pull()
        (target,) = self.models("FileInput")
        values = [base64.b64encode(content).decode() for content in contents]
        self.send(target, filename=list(names), mime_type=["t"] * len(names), value=values)


def test_only_names_of_this_machine_are_answered(served):
    port, _ = served
    for host in (f"127.0.0.1:{port}", f"localhost:{port}"):
        assert asked(port, "/", host)[0] == 200
    for host in ("evil.example", f"evil.example:{port}", "127.0.0.1", "", f"127.0.0.1:{port}.evil.example", "[::1]"):
        for path in ("/", "/ws", "/static/js/bokeh.min.js", "/nosuch"):
            assert asked(port, path, host)[0] in (400, 403)


def test_no_file_of_the_machine_and_no_path_is_given_away(served):
    port, place = served
    paths = ["/nosuch", "/static/../../../../etc/passwd", "/static/%2e%2e/%2e%2e/etc/passwd", "/static//etc/passwd"]
    paths += [
        "/autoload.js",
        "/?bokeh-session-id=x",
        "/?bokeh-token=x",
        "/?bokeh-token=%ff",
        "/static/%00",
        "/" + "a" * 9000,
    ]
    for path in paths:
        status, text = asked(port, path)
        assert 400 <= status < 500, path
        assert "root:" not in text and str(place) not in text and "site-packages" not in text


def test_the_word_of_a_page_that_nobody_was_given_opens_an_empty_one(served):
    port, place = served
    for word in ("x", "%ff", "../../etc/passwd", "<b>", "a" * 5000):
        status, text = asked(port, f"/?page={word}")
        assert status == 200 and "<b>" not in text and str(place) not in text


def test_sockets_of_other_pages_and_with_tokens_not_given_out_are_refused(served):
    port, _ = served
    here = f"http://127.0.0.1:{port}"
    assert socket_answers(port, fresh_token(port), Origin=here)
    for origin in (
        "http://evil.example",
        f"http://evil.example:{port}",
        "null",
        f"https://127.0.0.1.evil.example:{port}",
    ):
        assert not socket_answers(port, fresh_token(port), Origin=origin)
    assert not socket_answers(port, fresh_token(port), Origin=here, Host=f"evil.example:{port}")
    content = {"session_id": "x", "session_expiry": 9e9}
    forged = [
        base64.urlsafe_b64encode(json.dumps(one).encode()).decode() for one in (content, {}, [1], {"session_id": 1})
    ]
    token = fresh_token(port)
    spoilt = [token[:-3] + "AAA", "A" + token[1:], token + "A", token.split(".")[0], "", "x", "é", "." * 9, "a" * 9000]
    for bad in (*forged, *(f"{one}.{token.split('.')[-1]}" for one in forged), *spoilt):
        assert not socket_answers(port, bad, Origin=here), bad
    rng = __import__("random").Random(5)
    for _ in range(60):
        bad = "".join(rng.choice(token) for _ in range(rng.randrange(300)))
        assert not socket_answers(port, bad, Origin=here), bad


@pytest.mark.filterwarnings("ignore:reference already known")  # of the client, that pulls what it has
def test_what_a_hostile_client_sends_ends_in_a_line(served):
    port, place = served
    client = Client(port)
    for menu in client.models("CustomSelect"):
        for value in ("nonsense", "../../etc/passwd", "x" * 10_000):
            client.send(menu, value=value)
    cards = [one for one in client.document.models if isinstance(one, ReactiveESM)]
    for data in ({"key": "creep"}, {"key": ["x"]}, {"key": {}}, {"name": "mu", "value": "x"}, [], None, 7):
        for one in cards:
            event = MessageSentEvent(client.document, "bokeh_event", DataEvent(one, data=data))
            client.document.callbacks.trigger_on_change(event)
    client.force_roundtrip()
    assert len(cards) == 5
    (target,) = client.models("FileInput")
    client.send(target, filename=["a.csv"], mime_type=["t"], value=["!!!no base64"])
    client.send(target, filename=["a.csv", "b.csv"], mime_type=["t"], value=["eHg="])
    client.pull()
    for name in ("../../../etc/passwd", "/etc/passwd", "a\0b.csv", "..", "con:\\x", "<b>x</b>.csv"):
        client.drop((name, b"time_s,force_N\n0,1\n" + name.encode()))
    client.pull()
    text = " ".join(str(one.text) for one in client.models("HTML"))
    client.close()
    assert str(place) not in text and "<b>x</b>" not in text
    assert asked(port, "/")[0] == 200, "it lives"
