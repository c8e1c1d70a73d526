"""The chapter on simulation: every command prints what it says."""

import os
import subprocess
import sys
from pathlib import Path

from tests import guide

ROOT = Path(__file__).parents[1]
CODES = {"falsify ball.ha": 3}


def test_the_commands_of_the_chapter_print_what_it_shows(tmp_path: Path) -> None:
    guide.written("simulation.md", tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "verifier")}
    shown = [c for b in guide.blocks("simulation.md") if b.kind == "console" for c in guide.commands(b.text)]
    assert len(shown) >= 6
    for command in shown:
        words = command.words[1:]
        done = subprocess.run(
            [sys.executable, "-m", "haverify", *words], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert guide.agrees(command.printed, done.stdout), (words, done.stdout, done.stderr)
        assert done.returncode == CODES.get(" ".join(words), 0), (words, done.stderr)


def test_the_specs_of_the_chapter_have_no_new_finding(tmp_path: Path) -> None:
    for text in guide.specs("simulation.md"):
        report = guide.decided(text, tmp_path).report
        assert report.summary.exit_code == 0 or not report.claims
        # That a claim which is expected to be unknown is unknown is told as well.
        assert [f.message for f in report.findings if f.accepted is None and f.code != "HA702"] == []
