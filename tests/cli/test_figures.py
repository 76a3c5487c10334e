"""`fit --figures DIR` writes the paper's figures of any record."""

import pytest

NAMES = ["coefficients.svg", "isobars.svg", "laws_compared.svg"]


@pytest.mark.long
def test_figures_of_a_fit_are_written_and_named(ask, clean, tmp_path):
    folder = tmp_path / "figures"
    result = ask("fit", clean, "--law", "exponential_law", "--figures", folder)
    assert result.exit_code == 0
    assert sorted(path.name for path in folder.iterdir()) == [*NAMES, "measured_against_model.svg"]
    assert all(f"figure: {path}" in result.stdout for path in folder.iterdir())


def test_a_file_in_the_place_of_the_folder_is_refused_before_anything_is_fitted(ask, clean, tmp_path):
    (tmp_path / "taken").write_text("")
    result = ask("fit", clean, "--law", "exponential_law", "--figures", tmp_path / "taken")
    assert result.exit_code == 2 and "cannot be made a folder" in result.stderr and not result.stdout
