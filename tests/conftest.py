"""What tests in several folders share: places on disk, real data, a browser."""

import gc
import os
import shutil
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # as the command line does, and before numpy is imported
os.environ.pop("COLUMNS", None)  # a worker of pytest-xdist has it: no test's terminal is as wide as the tester's

import pytest  # noqa: E402
import threadpoolctl  # noqa: E402

threadpoolctl.threadpool_limits(1)  # a plugin of pytest may have imported numpy before

ROOT = Path(__file__).parents[1]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """What needs measurements or problems from outside the checkout belongs to the long tier."""
    for item in items:
        if {"realdata", "nist"} & set(item.fixturenames):
            item.add_marker("long")


def pytest_collection_finish():
    """What is imported stays: to look it through for garbage again and again takes a tenth of the time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture(scope="session")
def root() -> Path:
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def realdata() -> Path:
    """Folder of real measurements, PAM_IDENT_REALDATA or ../shared/realdata; skips where it is absent."""
    folder = Path(os.environ.get("PAM_IDENT_REALDATA", ROOT.parent / "shared" / "realdata"))
    if not folder.is_dir():
        pytest.skip(f"no real measurements at {folder}; set PAM_IDENT_REALDATA")
    return folder


@pytest.fixture(scope="session")
def nist() -> Path:
    """NIST's 27 .dat files of nonlinear regression, PAM_IDENT_NIST or ../shared/nist; skips where they are absent."""
    folder = Path(os.environ.get("PAM_IDENT_NIST", ROOT.parent / "shared" / "nist"))
    if not (folder / "Misra1a.dat").is_file():
        pytest.skip(f"no NIST problems at {folder}; set PAM_IDENT_NIST")
    return folder


@pytest.fixture(scope="module")
def one_process():
    """What the program shares out to a process for each core is done in this one: each would load all anew."""
    from pam_ident.parallel.executor import Executor

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Executor, "of_cores", lambda *_: Executor())
        yield


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of a chromium; skips where there is none, or fails if PAM_IDENT_REQUIRE_BROWSER is set."""
    found = os.environ.get("PAM_IDENT_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if not found:
        if os.environ.get("PAM_IDENT_REQUIRE_BROWSER"):
            pytest.fail("PAM_IDENT_REQUIRE_BROWSER is set, but there is no chromium; set PAM_IDENT_CHROMIUM")
        pytest.skip("no chromium on this machine; set PAM_IDENT_CHROMIUM")
    return found


@pytest.fixture(scope="module")
def browser(chromium: str):
    """A headless chromium; each test opens contexts of its own in it."""
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        yield browser
        browser.close()


@pytest.fixture
def page(browser):
    """An empty page that cannot reach any network."""
    with browser.new_context(offline=True) as context:
        yield context.new_page()
