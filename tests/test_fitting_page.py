"""The chapter on fitting is run as it is written: its commands print what it shows."""

from pathlib import Path

import pytest
from tests import guide

from haverify.cli import main

ROOT = Path(__file__).parents[1]
COMMANDS = [c for b in guide.blocks("fitting.md") if b.kind == "console" for c in guide.commands(b.text)]


def test_the_commands_of_the_chapter_print_what_it_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("models", "spec"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        assert command.words[0] == "haverify"
        main(command.words[1:])
        assert guide.agrees(command.printed, capsys.readouterr().out), command.words


def test_the_chapter_fits_checks_and_compares() -> None:
    assert {c.words[1] for c in COMMANDS} == {"fit", "check", "compare"}
