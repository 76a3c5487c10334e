"""`report` and `demo` write one page that says where it came from and how to make it again."""

import hashlib
import html
import re
import shlex

import pytest


@pytest.fixture(scope="module")
def reported(ask, rubbing, tmp_path_factory):
    out = tmp_path_factory.mktemp("report") / "page.html"
    result = ask("report", rubbing, "--law", "exponential_law", "--heldout", "refit", "--out", out)
    assert result.exit_code == 0, result.output
    return result, out, out.read_text(encoding="utf-8")


@pytest.mark.long
def test_the_page_tells_all_and_loads_nothing(reported, rubbing):
    _, out, page = reported
    for word in (
        "The answer in numbers",
        "Where the model fails",
        "The falling error",
        "Isobar by isobar",
        "Energy of the loops",
    ):
        assert word in page, word
    assert "Coulomb friction" in page
    assert hashlib.sha256(rubbing.read_bytes()).hexdigest() in page
    for name in ("pam-ident 0", "python 3", "numpy ", "scipy ", "pandas "):
        assert name in page, name
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert list(out.parent.iterdir()) == [out]


@pytest.mark.long
def test_the_command_in_the_page_makes_it_again(ask, reported, tmp_path):
    _, out, page = reported
    command = html.unescape(re.search(r"pam-ident report [^<]+", page)[0])
    words = shlex.split(command)
    again = tmp_path / "again.html"
    assert ask(*[str(again) if word == str(out) else word for word in words[1:]]).exit_code == 0
    text = again.read_text(encoding="utf-8").replace(str(again), str(out))
    date = r"\d{4}-\d\d-\d\d \d\d:\d\d"
    assert re.sub(date, "", text) == re.sub(date, "", page)


def test_a_report_that_fails_leaves_the_old_page(ask, write_record, tmp_path):
    out = tmp_path / "page.html"
    out.write_text("old")
    bad = write_record("time_s,pressure_MPa,displacement_mm,force_N\n0,0.1,0,x\n")
    assert ask("report", bad, "--law", "sarosi", "--out", out).exit_code == 4
    assert out.read_text() == "old" and list(tmp_path.iterdir()) == [out]


@pytest.mark.long
def test_the_demo_climbs_all_three_ladders(ask, tmp_path):
    result = ask("demo", "--out", tmp_path / "new" / "demo")
    assert result.exit_code == 0, result.output
    page = tmp_path / "new" / "demo" / "report.html"
    assert result.stdout.splitlines()[-1] == f"report: {page}"
    stages = dict(
        zip(
            ("hidden_effect", "nothing_hidden", "dmsp20_300"),
            re.split(r"^(?:nothing_hidden|dmsp20_300): ", result.stdout, flags=re.M),
            strict=True,
        )
    )
    rungs = {name: rungs_of(text) for name, text in stages.items()}
    parameters, rmse = rungs["dmsp20_300"][-1][1:3]
    assert parameters <= 8 and rmse <= 15 and rungs["dmsp20_300"][0][2] > 100
    assert all(heldout > 0 for _, _, _, heldout in rungs["dmsp20_300"])
    assert "pressure_friction" in rungs["hidden_effect"][-1][0] and rungs["hidden_effect"][-1][2] < 2.3
    assert stages["hidden_effect"].startswith("hidden_effect: "), "the easier record comes first"
    assert len(rungs["nothing_hidden"]) == 1 and "adequate" in stages["nothing_hidden"]
    text = page.read_text(encoding="utf-8")
    assert all("r0 = 11.5 mm stands at its bound" in told for told in (stages["dmsp20_300"], text))
    assert "unknown effect" in stages["dmsp20_300"] and "unknown effect" not in stages["hidden_effect"]
    badges = re.findall(r'<span class="word">([^<]+)</span>', text)
    assert badges == ["Missing effect", "Adequate", "Unknown effect"], "the page says what the terminal says"
    for name in ("DMSP-20-300", "hidden_effect", "nothing_hidden", "SHA-256", "pam-ident demo --out"):
        assert name in text, name


def rungs_of(text):
    """Model, free parameters, rmse and held-out rmse of each rung printed."""
    found = re.findall(r"^  \d+ +(.+?)  +(\d+) +([\d.]+) +([\d.]+|-)(?: +[\d.]+)?$", text, re.M)
    return [(model, int(n), float(rmse), float(heldout)) for model, n, rmse, heldout in found]
