"""Repairs of table cells."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import pytest

from .subjects import ROWS, TWO, mended, subject, texts

RANGES = """property r on A {
  always at(U) implies -4 deg <= y <= 38 deg
  always at(V) implies 6 deg <= y <= 38 deg
  expect proved
}
"""
PLAIN = TWO.replace("HASH", "")


@pytest.mark.parametrize(
    ("right", "wrong", "kind"),
    [
        ("V,-30,67", "V,30,67", "sign"),
        ("V,-30,67", "V,-30,76", "digits"),
        ("U,40,-3", "U,400,-3", "point"),
        ("U,40,-3", "U,-3,40", "cells"),
    ],
)
def test_one_slip_in_a_row(tmp_path: Path, right: str, wrong: str, kind: str) -> None:
    s = subject(tmp_path, PLAIN + RANGES, t=ROWS.replace(right, wrong))
    outcome = mended(s)
    (p,) = outcome.proposals
    assert p.change.kind == kind
    assert texts(s, outcome) == {"t.csv": ROWS}
    assert p.effect.mended == ("r",)
    assert any("as written" in n and "then" in n for n in p.notes)


def test_two_slips_in_one_row_are_beyond_a_small_change(tmp_path: Path) -> None:
    outcome = mended(subject(tmp_path, PLAIN + RANGES, t=ROWS.replace("V,-30,67", "V,30,-67")))
    assert outcome.proposals == ()
    assert any("t.csv:3: no single change" in text for text in outcome.left)


def test_slips_in_neighbouring_rows_are_mended_together(tmp_path: Path) -> None:
    s = subject(tmp_path, PLAIN + RANGES, t="p,a,b\nU,-40,-3\nV,30,67\n")
    assert texts(s, mended(s)) == {"t.csv": ROWS}


def test_without_claims_a_torn_curve_tells(tmp_path: Path) -> None:
    s = subject(tmp_path, PLAIN, t=ROWS.replace("V,-30,67", "V,-30,-67"))
    assert texts(s, mended(s)) == {"t.csv": ROWS}


def test_a_recorded_hash_tells_what_a_file_was(tmp_path: Path) -> None:
    """Also where no claim would notice: the sign of the error is a small matter, its hash is not."""
    text = TWO.replace("HASH", f'sha256 "{sha256(ROWS.encode()).hexdigest()}"\n')
    s = subject(tmp_path, text, t=ROWS.replace("-3\n", "3\n"))
    outcome = mended(s)
    assert texts(s, outcome) == {"t.csv": ROWS}
    assert outcome.proposals[0].notes == ("the file then has the sha256 that the spec records",)


def test_a_hash_that_was_right_follows(tmp_path: Path) -> None:
    wrong = ROWS.replace("V,-30,67", "V,30,67")
    text = TWO.replace("HASH", f'sha256 "{sha256(wrong.encode()).hexdigest()}"\n')
    s = subject(tmp_path, text + RANGES, t=wrong)
    after = texts(s, mended(s))
    assert after["t.csv"] == ROWS
    assert sha256(ROWS.encode()).hexdigest() in after["a.ha"]


BOUNDS = """spec "Bounds" version "1.0"
enum J { A }
table L from "l.csv" { key j: J
  column low: deg
  column high: deg }
automaton M {
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


@pytest.mark.parametrize("expect", ["proved", 'refuted because "as printed"'])
def test_cells_that_are_backwards_bounds(tmp_path: Path, expect: str) -> None:
    text = BOUNDS + f"property p on M {{ always L[A].low <= y <= L[A].high; expect {expect} }}\n"
    s = subject(tmp_path, text, l="j,low,high\nA,3,-7\n")
    outcome = mended(s)
    (p,) = outcome.proposals
    assert p.change.kind == "bounds"
    assert texts(s, outcome) == {"l.csv": "j,low,high\nA,-7,3\n"}
    assert p.notes[1].endswith("not at all then")


def test_a_cell_that_a_claim_states(tmp_path: Path) -> None:
    text = BOUNDS + "property p on M { always L[A].low <= y <= L[A].high; expect proved }\n"
    s = subject(tmp_path, text, l="j,low,high\nA,7,31\n")
    assert texts(s, mended(s)) == {"l.csv": "j,low,high\nA,-7,31\n"}
