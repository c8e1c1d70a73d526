"""Settings: the nearest file counts, an unknown key is an error."""

import os
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.errors import UsageError
from haverify.run.settings import Settings, duration, settings


def test_pyproject_and_own_file(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "pyproject.toml").write_text('[tool.haverify]\njobs = 3\ngrade = "checked"\n')
    assert settings(inner) == Settings(jobs=3, grade="checked")
    (inner / "haverify.toml").write_text('budget = "5s"\n')
    assert settings(inner) == Settings(budget="5s")


@pytest.mark.parametrize(
    "text",
    ["[tool.haverify]\njobs = 3",
     '[ tool . "haverify" ]\njobs = 3', "[tool]\nhaverify.jobs = 3", "tool.haverify.jobs = 3",
     "tool = { haverify = { jobs = 3 } }"],
)  # fmt: skip
def test_every_way_to_write_the_table_is_seen(tmp_path: Path, text: str) -> None:
    (tmp_path / "pyproject.toml").write_text(text + "\n")
    assert settings(tmp_path).jobs == 3


def test_a_pyproject_of_others_is_passed_by(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "haverify-user"\n')
    (tmp_path.parent / "haverify.toml").unlink(missing_ok=True)
    assert settings(tmp_path).jobs is None


@pytest.mark.parametrize(
    "text", ["colour = true\n", 'jobs = "two"\n', "jobs = true\n", 'grade = "sure"\n', 'format = "html"\n', "jobs ="]
)
def test_what_cannot_be_meant_is_an_error(tmp_path: Path, text: str) -> None:
    (tmp_path / "haverify.toml").write_text(text)
    with pytest.raises(UsageError):
        settings(tmp_path)


@pytest.mark.parametrize(
    ("text", "seconds"), [("60s", 60), ("500ms", Fraction(1, 2)), ("2 min", 120), ("1.5", Fraction(3, 2))]
)
def test_durations(text: str, seconds: Fraction) -> None:
    assert duration(text) == seconds


@pytest.mark.parametrize("text", ["", "0s", "-1s", "1e9", "five", "9" * 5000])
def test_no_durations(text: str) -> None:
    with pytest.raises(UsageError):
        duration(text)


def test_a_pipe_holds_no_settings(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "haverify.toml")
    assert settings(tmp_path) == settings(tmp_path.parent)
