"""What a release says of itself in several places is the same in all of them."""

import re
import tomllib
from pathlib import Path

import pytest

import twistcore

ROOT = Path(__file__).resolve().parents[1]


def text(name):
    return (ROOT / name).read_text("utf-8")


def released():
    """Version and date of every section of the changelog, the latest first."""
    return re.findall(r"^## \[(\d[^]]*)\] - (\d{4}-\d\d-\d\d)$", text("CHANGELOG.md"), re.M)


def test_version_and_date_are_those_of_the_changelog():
    version, date = released()[0]
    assert twistcore.__version__.split(".dev")[0] == version
    citation = text("CITATION.cff")
    assert f"\nversion: {version}\n" in citation
    assert f"\ndate-released: {date}\n" in citation
    assert f"version = {{{version}}}," in text("docs/cite.md")
    assert f"date    = {{{date}}}," in text("docs/cite.md")


def test_the_recipe_for_conda_is_that_of_the_wheel():
    yaml = pytest.importorskip("yaml", reason="comes with the packages for the site")
    project = tomllib.loads(text("pyproject.toml"))["project"]
    recipe = yaml.safe_load(text("packaging/conda/recipe.yaml"))
    assert recipe["context"]["version"] == twistcore.__version__.split(".dev")[0]
    python, *packages = [line.replace(" ", "") for line in recipe["requirements"]["run"]]
    assert python == f"python{project['requires-python']}"
    assert packages == project["dependencies"]
    commands = [f"{name} = {call}" for name, call in project["scripts"].items()]
    assert sorted(recipe["build"]["python"]["entry_points"]) == sorted(commands)
    assert recipe["about"]["license"] == project["license"]


def test_a_section_of_the_changelog_has_each_kind_of_change_once():
    sections = re.split(r"^## ", text("CHANGELOG.md"), flags=re.M)[1:]
    assert sections[0].startswith("[Unreleased]")
    for section in sections:
        kinds = re.findall(r"^### (.*)$", section, re.M)
        assert len(set(kinds)) == len(kinds)
        known = ["Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"]
        assert kinds == [kind for kind in known if kind in kinds]


def test_no_entry_of_the_changelog_stands_twice():
    entries = re.findall(r"^- (?:.+\n)(?:  .+\n)*", text("CHANGELOG.md"), re.M)
    plain = [re.sub(r"\W+", " ", entry).lower() for entry in entries]
    assert len(plain) > 100
    assert len(set(plain)) == len(plain)


def test_the_house_cites_its_methods_alike():
    for doi in ("10.46670/JSST.2026.35.1.13", "2601.19580"):
        for page in ("README.md", "CITATION.cff", "docs/cite.md"):
            assert doi in text(page), page
