"""Reports of claims without time: every damage is refused."""

from pathlib import Path

import pytest
from tests.forgeries.damage import Forger, damages

from hacheck.__main__ import main as hacheck
from hacheck.rational import Meter
from haverify.cli import main as haverify

SPEC = """spec "Small" version "1.0"
enum Leg { Left = 0b0, Right = 0b1 }
enum Sub { Stance = 0b0, Swing = 0b1 }
param m in [6, 8]
cellular Partner {
  cell Cell = Leg ++ Sub
  rule 0b00 -> 0b11
  rule 0b01 -> 0b10
  rule 0b10 -> 0b01
  rule 0b11 -> 0b00
}
property back on Partner { holds forall c in Cell: next(next(c)) == c; expect proved }
property same on Partner { holds forall c in Cell: next(c).leg == c.leg; expect refuted }
property some on Partner { holds exists c in Cell: next(c).sub is Swing; expect proved }
property both on Partner {
  holds exists c in Cell: next(c) == c
  holds forall c in Cell: defined(next(c))
  expect refuted
}
property mass { holds m^2 <= 64; expect proved }
property less { assume m >= 7; holds m < 8; expect refuted }
"""


def test_a_damaged_report_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))
    (tmp_path / "small.ha").write_text(SPEC)
    assert haverify(["check", "small.ha", "--report", "true"]) == 0
    Meter.left = 60_000_000
    assert hacheck(["true", "--strict"]) == 0
    forger, accepted, count = Forger(tmp_path / "true", tmp_path / "forged"), [], 0
    for name, forge in damages(tmp_path / "true"):
        if not name.endswith(": shorter"):  # a claim without time is the same within any
            forger.forged(forge)
            Meter.left = 60_000_000
            accepted += [name] if hacheck(["forged"]) == 0 else []
            count += 1
    assert accepted == []
    assert count > 100
