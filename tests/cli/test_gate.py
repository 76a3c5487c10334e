"""What is grave stops naming: exit code 4, an answer that says so, and `--assume`. What is doubtful is said."""

import json

import pytest

LAW = ("--law", "exponential_law")


@pytest.fixture(scope="module")
def slipped(write_record, clean):
    """The clean record with its pressure in bar."""
    lines = clean.read_text().splitlines()
    rows = (line.split(",") for line in lines[1:])
    return write_record("\n".join([lines[0], *(f"{t},{10 * float(p):.6f},{x},{f}" for t, p, x, f in rows)]) + "\n")


def refused(run, *words):
    """Message and exit code of a command that ends in an error."""
    result = run(*words)
    return result.stderr, result.exit_code


@pytest.mark.parametrize("verb", ["ladder", "report"])
def test_a_slip_stops_naming_and_the_answer_says_so(ask, slipped, tmp_path, verb):
    out, page = tmp_path / "answer.json", tmp_path / "page.html"
    more = ("--out", page) if verb == "report" else ()
    message, code = refused(ask, verb, slipped, *LAW, "--json", out, *more)
    assert code == 4 and "nothing is named" in message and "--assume scale" in message and not page.exists()
    check_stopped(json.loads(out.read_text()))


def check_stopped(found):
    assert found["schema"] == "pam-ident/diagnosis/1" and found["n"] == 1200
    assert found["selected"] == [] and found["ranking"] == [] and found["rmse_N"] is None
    first = found["warnings"][0]
    assert first["code"] == "scale" and first["grave"] is True and "bar and MPa (10)" in first["text"]


def test_of_several_records_each_has_its_answer(ask, slipped, clean, tmp_path):
    out = tmp_path / "answers.jsonl"
    result = ask("diagnose", slipped, clean, *LAW, "--json", out)
    assert result.exit_code == 4 and "nothing is named" in result.stderr
    stopped, fine = map(json.loads, out.read_text().splitlines())
    check_stopped(stopped)
    assert fine["verdict"] == "adequate" and fine["warnings"] == [] and fine["record"] == str(clean)


@pytest.mark.long
def test_what_is_assumed_is_named_under_a_banner(answer, slipped):
    result, found = answer("diagnose", slipped, *LAW, "--assume", "scale", "--assume", "displacement_scale")
    assert result.exit_code == 0 and "WARNING (scale): the force grows" in result.stdout
    assert found["rmse_N"] > 0.0 and [one["code"] for one in found["warnings"] if one["grave"]]


@pytest.mark.parametrize("verb", ["fit", "compare"])
def test_fit_and_compare_answer_under_a_banner(answer, slipped, verb):
    result, found = answer(verb, slipped, *LAW)
    lines = result.stdout.splitlines()
    banner = next(k for k, line in enumerate(lines) if line.startswith("WARNING (scale)"))
    assert result.exit_code == 0 and found["warnings"][0]["code"] == "scale"
    assert banner < next(k for k, line in enumerate(lines) if "rms" in line and k != banner)


def test_an_unknown_code_is_refused(ask, clean):
    message, code = refused(ask, "diagnose", clean, *LAW, "--assume", "bar")
    assert code == 2 and "--assume bar: expected all or one of" in message


def test_a_kind_is_said_by_inspect_and_by_the_specimen(answer, ask, clean, write_record):
    result, found = answer("inspect", clean)
    assert found["kind"] == "isobaric" and "kind        isobaric: the pressure is held" in result.stdout
    specimen = clean.with_name("specimen.toml").read_text()
    for text in (f'kind = "isotonic"\n{specimen}', f'{specimen}kind = "isotonic"\n'):
        told = write_record(clean.read_text(), specimen=text)
        assert answer("inspect", told)[1]["kind"] == "isotonic"
        message, code = refused(ask, "diagnose", told, *LAW)
        assert code == 4 and "an isotonic test" in message
    wrong = write_record(clean.read_text(), specimen=f'kind = "isochoric"\n{specimen}')
    message, code = refused(ask, "inspect", wrong)
    assert code == 4 and "kind = 'isochoric'; expected one of isobaric" in message


def test_a_kind_is_said_by_columns(answer, clean, write_record):
    told = write_record(clean.read_text())
    columns = [f'{name} = "{name}"' for name in ("time_s", "pressure_MPa", "displacement_mm", "force_N")]
    told.with_name("columns.toml").write_text("\n".join(['kind = "dynamic"', "[columns]", *columns]) + "\n")
    assert answer("inspect", told)[1]["kind"] == "dynamic"
    assert answer("fit", told, *LAW, "--chunked")[0].exit_code == 0


@pytest.mark.long
@pytest.mark.parametrize("verb", ["diagnose", "ladder", "report"])
@pytest.mark.parametrize(("what", "expected"), [("kind", 4), ("too_little", 3)])
@pytest.mark.parametrize("law", [LAW, ()])
def test_a_refusal_has_its_answer_too(ask, clean, write_record, tmp_path, verb, what, expected, law):
    specimen, lines = clean.with_name("specimen.toml").read_text(), clean.read_text().splitlines()
    if what == "kind":
        told = write_record(clean.read_text(), specimen=f'kind = "isotonic"\n{specimen}')
    else:
        told = write_record("\n".join([lines[0], *lines[1:1000:80]]) + "\n")
    more = ("--out", tmp_path / "page.html") if verb == "report" else ()
    out = tmp_path / "answer.json"
    message, code = refused(ask, verb, told, *law, "--json", out, *more)
    found = json.loads(out.read_text())
    assert code == expected and len(message.splitlines()) <= 2
    assert found["verdict"] == "unknown_effect" and found["selected"] == [] and found["rmse_N"] is None
    first = found["warnings"][0]
    assert first["code"] == what and first["grave"] is False and first["text"] in " ".join(message.split())
    assert found["n"] == (1200 if what == "kind" else 13)


def test_what_was_left_out_is_a_warning(answer, clean, write_record):
    lines = clean.read_text().splitlines()
    told = write_record("\n".join([*lines[:5], lines[5].rpartition(",")[0] + ",", *lines[6:]]) + "\n")
    for verb in ("fit", "compare", "inspect"):
        result, found = answer(verb, told, *(() if verb == "inspect" else LAW))
        (one,) = [one for one in found["warnings"] if one["code"] == "empty_cells"]
        assert one["column"] == "force_N" and not one["grave"] and "1 row is left out" in one["text"]
        assert result.stdout.count(one["text"]) == 1
