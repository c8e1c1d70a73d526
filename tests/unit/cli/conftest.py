"""Calls of haverify in a folder of their own."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from haverify.cli import main

CLOCK = """spec "Clock" version "1.0"
automaton Clock {
  var x: s in [0 s, 2 s]
  let y: deg = 3 deg * (x / 1 s)
  init Run with x := 0 s
  mode Run {
    domain x <= 1 s
    flow { x' = 1 }
    urgent edge again: -> Run when x >= 1 s do x := 0 s
  }
}
"""

TRUE = "property low on Clock { always y <= 3 deg; expect proved }\n"
FALSE = "property lower on Clock { always y <= 2 deg }\n"
KNOWN = 'property lower on Clock { always y <= 2 deg; expect refuted because "it reaches 3 deg" }\n'


@dataclass(frozen=True)
class Said:
    """What a call came to."""

    code: int
    out: str
    err: str


@pytest.fixture
def haverify(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Said]:
    """Run a command in `tmp_path`, with a cache of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / ".cache"))
    monkeypatch.delenv("HAVERIFY_DEBUG", raising=False)

    def call(*arguments: str) -> Said:
        try:
            code = main(list(arguments))
        except SystemExit as e:  # argparse
            code = int(e.code or 0)
        said = capsys.readouterr()
        return Said(code, said.out, said.err)

    return call


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, str], str]:
    """Write a file below `tmp_path`; its name back."""

    def put(name: str, text: str) -> str:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
        return name

    return put
