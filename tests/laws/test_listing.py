"""`pam-ident laws` tells of every law."""

from typer.testing import CliRunner

from pam_ident.cli import app
from pam_ident.laws import catalogue


def test_every_law_is_listed_with_formula_parameters_and_source():
    result = CliRunner().invoke(app, ["laws"])
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    for law in catalogue().values():
        begin = lines.index(f"{law.name}: {law.title}")
        assert lines[begin + 1 : begin + 4] == [
            f"  {law.formula}",
            f"  {len(law.params)} parameters" + (f": {', '.join(p.name for p in law.params)}" if law.params else ""),
            f"  source: {law.source}",
        ]
    assert len(lines) == 4 * len(catalogue())


def test_the_readme_names_every_law(root):
    text = (root / "README.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in catalogue())
