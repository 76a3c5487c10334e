"""What a stranger installs: one version, one list of dependencies, a paper whose figures stand in the pages."""

import re
import tomllib

import pytest
import yaml

import pam_ident
from pam_ident.live import OLDEST

CONDA = {"matplotlib": "matplotlib-base", "mujoco": "mujoco-python"}  # where conda-forge has another name
USERS = ("formats", "prototype", "workbench", "cluster")


def read(path):
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def project(root):
    return tomllib.loads(read(root / "pyproject.toml"))["project"]


@pytest.fixture(scope="module")
def recipe(root):
    return yaml.safe_load(read(root / "packaging" / "conda" / "recipe.yaml"))


def floors(lines):
    """(name as conda has it, floor) of each requirement."""
    found = [re.fullmatch(r"([\w-]+) ?>=([\d.]+)", line) for line in lines]
    assert all(found), lines
    return {(CONDA.get(m[1].lower(), m[1].lower()), m[2]) for m in found}


def test_one_version(root, recipe):
    citation = yaml.safe_load(read(root / "CITATION.cff"))
    assert citation["version"] == recipe["context"]["version"] == pam_ident.__version__
    assert f"\n## {pam_ident.__version__}" in read(root / "CHANGELOG.md")


def test_the_recipe_asks_for_what_the_wheel_asks_for(project, recipe):
    needs, python = recipe["requirements"], recipe["context"]["python_min"]
    assert project["requires-python"] == f">={python}"
    assert needs["run"][0] == "python >=${{ python_min }}"
    assert floors(needs["run"][1:]) == floors(project["dependencies"])
    extras = [line for extra in USERS for line in project["optional-dependencies"][extra]]
    assert floors(needs["run_constraints"]) == floors(extras)
    (script,) = recipe["build"]["python"]["entry_points"]
    assert dict([script.split(" = ")]) == project["scripts"]


def test_a_package_has_one_floor(project):
    extras = project["optional-dependencies"]
    assert f"pam-ident[{','.join(USERS)}]" in extras["test"], "the tests need all that a user can install"
    lines = [*project["dependencies"], *(line for extra in extras.values() for line in extra if "[" not in line)]
    names = [name for name, _ in floors(lines)]
    assert len(names) == len(set(names))
    assert ("bokeh", ".".join(map(str, OLDEST))) in floors(extras["workbench"]), "what runs asks for the same"


def test_types_come_along(root):
    assert (root / "pam_ident" / "py.typed").is_file()
    assert "Typing :: Typed" in read(root / "pyproject.toml")


def test_figures_of_the_paper_stand_in_the_pages(root):
    paper = read(root / "paper" / "paper.md")
    pages = [read(root / "docs" / f"{name}.md") for name in ("validation", "benchmarks", "laws")]
    lines = [line for page in pages for line in page.splitlines()]
    evidence = re.sub(r"\[@\w+\]|DMSP-20-300", "", paper.partition("# Evidence")[2].partition("# References")[0])
    told = re.findall(r"(\d+(?:\.\d+)?(?: %)?)(?: of (?:the )?(\d+))?", evidence)
    assert len(told) > 20
    assert not [pair for pair in told if not any(all(stands(one, line) for one in pair) for line in lines)]


def stands(number, line):
    """Whether a number, or none, stands in a line by itself."""
    return not number or re.search(rf"(?<![\d.]){re.escape(number)}(?![\d.]?\d)", line) is not None


def test_the_paper_s_sources_are_those_that_it_names(root):
    named = set(re.findall(r"@(\w+)", read(root / "paper" / "paper.md")))
    listed = re.findall(r"^@\w+\{(\w+),", read(root / "paper" / "paper.bib"), re.M)
    assert named == set(listed) and len(listed) == len(named)
