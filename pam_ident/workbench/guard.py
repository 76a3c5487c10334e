"""Who may ask the server, and what it tells them: pages of this address, with a session that it has given out."""

import gzip
import os
import zlib
from collections.abc import Collection
from importlib import import_module
from types import SimpleNamespace
from typing import Any

from bokeh.core import serialization
from bokeh.util.token import check_token_signature, get_session_id
from tornado.httputil import HTTPServerRequest
from tornado.web import Application, ErrorHandler

PROTOCOL = "Sec-Websocket-Protocol"
MOST_IN_MESSAGE = 1 << 28
"""Bytes that a packed part of a message may have when it is unpacked."""


def guard(app: Application, hosts: Collection[str], secret: str) -> None:
    """Let `app` answer requests that name one of `hosts`, and whose token, where they bring one, is signed by `secret`.

    A page of a foreign name that is made to point at this machine names that name; it gets 403, and so does a token
    that was not given out here, before anything reads what it holds.
    """
    find = app.find_handler

    def find_guarded(request: HTTPServerRequest, **more: Any) -> Any:
        fair = request.host in hosts and "%00" not in request.path
        if not fair or not all(_ours(token, secret) for token in _tokens(request)):
            return app.get_handler_delegate(request, ErrorHandler, {"status_code": 403})
        return find(request, **more)

    app.find_handler = find_guarded  # type: ignore[method-assign]


def tell_no_files() -> None:
    """Bokeh answers a message that it cannot take with a traceback, and unpacks what it is sent without a limit: take
    both away. PAM_IDENT_DEBUG leaves the former."""
    if not os.environ.get("PAM_IDENT_DEBUG"):
        messages = import_module("bokeh.protocol.messages.error")  # the package has a class of that name
        messages.format_exception = lambda *_: ()  # type: ignore[attr-defined]
    serialization.gzip = SimpleNamespace(compress=gzip.compress, decompress=_unpacked)  # type: ignore[attr-defined]


def _unpacked(data: bytes) -> bytes:
    unpack = zlib.decompressobj(16 + zlib.MAX_WBITS)
    found = unpack.decompress(data, MOST_IN_MESSAGE)
    if not unpack.eof:
        raise ValueError(f"a part of a message that unpacks to more than {MOST_IN_MESSAGE >> 20} MiB, or is cut short")
    return found


def _tokens(request: HTTPServerRequest) -> list[str]:
    """The tokens of a request: of a socket behind the word for the protocol, else among the arguments."""
    given = [value.decode("latin-1") for value in request.arguments.get("bokeh-token", [])]
    if request.headers.get("Upgrade", "").lower() == "websocket":
        words = [word.strip() for word in request.headers.get(PROTOCOL, "").split(",")]
        given.append(words[1] if len(words) == 2 else "")
    return given


def _ours(token: str, secret: str) -> bool:
    try:
        return (
            token.isascii()
            and check_token_signature(token, secret_key=secret.encode(), signed=True)
            and bool(get_session_id(token))
        )
    except Exception:  # a dozen of them, from base64 to JSON
        return False
