"""Specs as texts, read, linted and repaired."""

from __future__ import annotations

from pathlib import Path

from haverify.diagnostics.edits import edited
from haverify.repair.proposal import Outcome
from haverify.repair.repair import repair
from haverify.repair.subject import Subject, Text, read
from haverify.run.load import load

CLOCK = """spec "Clock" version "1.0"
automaton A {
  var x: s in [0 s, 5 s]
  let y: deg = 10 deg * x / 1 s - 7 deg
  init M with x := 0 s
  mode M {
    domain x <= 1 s
    flow { x' = 1 }
    urgent edge again: -> M when x >= 1 s do x := 0 s
  }
}
"""

TWO = """spec "Two" version "1.0"
enum P { U, V }
table T from "t.csv" { key p: P
  poly a..b descending in x: s -> deg
  HASH}
automaton A {
  var x: s in [0 s, 2 s]
  let y: deg = T[p](x)
  init U with x := 0 s
  mode Run for p in P { flow { x' = 1 } }
  schedule on x from 0 s {
    U until 1 s
    V until 2 s then U do x := 0 s
  }
}
"""
ROWS = "p,a,b\nU,40,-3\nV,-30,67\n"  # -3 .. 37 deg, then 37 .. 7 deg


def subject(folder: Path, text: str, recorded: dict[str, tuple[str, ...]] | None = None, **tables: str) -> Subject:
    """A spec with its tables, written to a folder, read and linted."""
    for name, rows in tables.items():
        (folder / f"{name}.csv").write_text(rows)
    (folder / "a.ha").write_text(text)
    loaded, found = load(folder / "a.ha")
    assert loaded is not None and not found, found
    data = {s.path: s for s in loaded.files.data.values()}
    made = read(Text(loaded.tree, loaded.files, {**data, **loaded.sources}), recorded or {})
    made.lint()
    assert made.has_meaning, made.found
    return made


def mended(of: Subject, only: str | None = None) -> Outcome:
    """What a repair proposes where nothing is accepted."""
    return repair(of, (), only)


def texts(of: Subject, outcome: Outcome) -> dict[str, str]:
    """The files that a repair changes, by name, as they are then."""
    paths = {e.span.path for e in outcome.edits}
    return {
        Path(p).name: edited(of.text.sources[p].text, [e for e in outcome.edits if e.span.path == p]) for p in paths
    }
