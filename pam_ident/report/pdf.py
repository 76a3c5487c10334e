"""A page printed to PDF by a browser that is installed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from ..core import UsageError

BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "microsoft-edge-stable",
    "msedge",
)
QUIET = (
    "--headless",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND",
    "--no-pdf-header-footer",
)
PATIENCE_S = 120.0
INSTEAD = "or write the report with --format html, open it and print it"


def find_browser() -> str:
    """PAM_IDENT_BROWSER, or the first Chromium, Chrome or Edge on PATH. Raises UsageError where there is none."""
    named = os.environ.get("PAM_IDENT_BROWSER")
    if named:
        if found := shutil.which(named):
            return found
        raise UsageError(f"PAM_IDENT_BROWSER={named}: expected a program that can be run; fix it, {INSTEAD}")
    for name in BROWSERS:
        if found := shutil.which(name):
            return found
    raise UsageError(
        "a PDF is printed by Chromium, Chrome or Edge, and none is on PATH; "
        f"install one, set PAM_IDENT_BROWSER to its path, {INSTEAD}"
    )


def to_pdf(page: str, folder: str | Path | None = None, patience_s: float = PATIENCE_S) -> bytes:
    """The HTML `page` as PDF. The browser works in a temporary folder inside `folder` and reaches no network.

    Raises UsageError where there is no browser, or it fails, or takes longer than `patience_s`.
    """
    browser = find_browser()
    with TemporaryDirectory(dir=folder, prefix="pam-ident-", ignore_cleanup_errors=True) as place:
        source, target = Path(place, "report.html"), Path(place, "report.pdf")
        source.write_text(page, encoding="utf-8")
        command = [browser, *QUIET, f"--user-data-dir={Path(place, 'profile')}", f"--print-to-pdf={target}"]
        if sys.platform == "linux" and os.geteuid() == 0:
            command.append("--no-sandbox")  # Chromium refuses to start as root with it
        try:
            subprocess.run(
                [*command, source.resolve().as_uri()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                timeout=patience_s,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise UsageError(f"{browser}: made no PDF in {patience_s:g} s; try again, {INSTEAD}") from None
        except OSError as error:
            raise UsageError(f"{browser}: cannot be run ({error}); set PAM_IDENT_BROWSER, {INSTEAD}") from None
        pdf = target.read_bytes() if target.is_file() else b""
    if not pdf.startswith(b"%PDF-"):
        raise UsageError(f"{browser}: made no PDF; set PAM_IDENT_BROWSER to another browser, {INSTEAD}")
    return pdf
