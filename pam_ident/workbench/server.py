"""The workbench as a page for the browser of this machine."""

import asyncio
import logging
import os
import secrets
import socket
import warnings
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import panel as pn
from panel.io.server import get_server
from tornado.websocket import WebSocketClosedError

from ..core import UsageError
from .guard import guard, tell_no_files
from .history import History, Kept
from .page import Workbench

HOST = "127.0.0.1"
PAGE = (files("pam_ident.workbench") / "page.html").read_text(encoding="utf-8")
SESSION = "page"
"""The word in the address under which what was done on a page is kept."""
MOST_BYTES = 256 * 1024 * 1024
"""Largest message from the browser: the files that are dropped there."""

LOG_LINE = 300
"""Characters of a line in the log that tells of an error."""


def serve(
    make: Callable[[History], Workbench], port: int = 5006, show: bool = True, ready: Callable[[str], None] = print
) -> None:
    """Serve a workbench of `make` to each tab, until interrupted; `ready` is told the address.

    A tab begins afresh, and goes on where it was when it is loaded again.

    Only this machine is listened to, and only pages of this address are answered. Port 0 takes any that is free.
    Raises UsageError for a port that is taken.
    """
    port = _free(port)
    address = f"http://{HOST}:{port}"
    pn.extension(loading_indicator=False)
    logging.setLogRecordFactory(_in_one_line(logging.getLogRecordFactory()))
    logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)  # a tab that was closed is no fault
    kept = Kept()
    secret, hosts = secrets.token_urlsafe(32), [f"{HOST}:{port}", f"localhost:{port}"]
    server = get_server(
        lambda: _page(make, kept),
        port=port,
        address=HOST,
        show=show,
        start=False,
        title="pam-ident workbench",
        verbose=False,
        websocket_origin=hosts,
        sign_sessions=True,
        secret_key=secret.encode(),
        websocket_max_message_size=MOST_BYTES,
        http_server_kwargs={"max_buffer_size": MOST_BYTES},
    )
    guard(server._tornado, hosts, secret)
    tell_no_files()
    server.io_loop.add_callback(lambda: asyncio.get_running_loop().set_exception_handler(_unless_gone))
    warnings.filterwarnings("ignore", "reference already known")  # Bokeh, when a button is pressed; nothing is amiss
    ready(address)
    try:
        server.run_until_shutdown()
    except KeyboardInterrupt:
        server.stop()


def _page(make: Callable[[History], Workbench], kept: Kept) -> pn.Template:
    given = pn.state.session_args.get(SESSION, [b""])[0].decode("ascii", "replace")
    word, history = kept.of(given)
    bench = make(history)
    page = pn.Template(PAGE)
    page.location = True
    page.add_panel("bench", bench.page)
    location = pn.state.location
    if location is not None:
        pn.state.onload(lambda: setattr(location, "search", f"?{SESSION}={word}"))
    if pn.state.curdoc is not None:
        pn.state.curdoc.js_on_event("document_ready", bench.view.themed)
    return page


def _unless_gone(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """A tab that was closed while something was on its way to it is no fault."""
    if not isinstance(context.get("exception"), WebSocketClosedError):
        loop.default_exception_handler(context)


def _in_one_line(make: Callable[..., logging.LogRecord]) -> Callable[..., logging.LogRecord]:
    """Log records without the tracebacks, and the files in them, that whatever a page sends would leave there;
    PAM_IDENT_DEBUG keeps them."""

    def record(*args: Any, **more: Any) -> logging.LogRecord:
        made = make(*args, **more)
        if made.exc_info and made.exc_info[0] and not os.environ.get("PAM_IDENT_DEBUG"):
            told = f"{made.getMessage().partition(chr(10))[0]} ({made.exc_info[0].__name__}: {made.exc_info[1]})"
            made.msg, made.args, made.exc_info = " ".join(told.split())[:LOG_LINE], (), None
        return made

    return record


def _free(port: int) -> int:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except (OSError, OverflowError):
            raise UsageError(f"--port {port}: taken or not allowed; name another, or 0 for any that is free") from None
        return probe.getsockname()[1]
