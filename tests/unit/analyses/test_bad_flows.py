"""Flows that are out of the ordinary: a verdict, or unknown with a reason, never a fault and never a wrong verdict."""

from __future__ import annotations

from pathlib import Path

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.run.examine import read

DECAY = "x' = -x + sin(x) / 2"


def verdict(folder: Path, start: str, rate: str, claim: str, edge: str = "") -> Verdict:
    path = folder / "bad.ha"
    path.write_text(
        f'spec "bad" version "1.0" unitless\nautomaton A {{\n  var x\n  init P where {start}\n'
        f"  mode P {{ flow {{ {rate} }} }}\n  {edge}\n}}\nproperty p on A {{ {claim} }}\n"
    )
    spec, _, found = read(str(path))
    assert spec is not None, [d.message for d in found]
    return decide_all(spec)["p"].verdict


@pytest.mark.parametrize(
    ("start", "rate", "claim", "expected"),
    [
        ("1 <= x <= 2", DECAY, "within 0; always x <= 2", Proved),
        ("1 <= x <= 2", DECAY, "within 0; always x <= 1.9", Refuted),
        ("1 <= x <= 2", DECAY, "within 1e9; always x <= 2.001", Proved),
        ("x == 1", DECAY, "within 3; always x <= 1.001", Proved),
        ("1 <= x <= 1 + 1e-300", DECAY, "within 3; always x <= 1.1", Proved),
        ("-500000 <= x <= 500000", DECAY, "within 3; always x <= 500001", Proved),
        ("1 <= x <= 1.1", "x' = x^2", "within 0.5; always x <= 3", Proved),
        ("2 <= x <= 1", DECAY, "within 3; always x <= 3", Unknown),
    ],
)
def test_starts_and_horizons_of_any_size(tmp_path: Path, start: str, rate: str, claim: str, expected: type) -> None:
    assert isinstance(verdict(tmp_path, start, rate, claim), expected)


@pytest.mark.parametrize("rate", ["x' = -1", DECAY])
def test_a_reset_to_an_empty_range_is_no_fault(tmp_path: Path, rate: str) -> None:
    edge = "edge e: P -> P when x <= 1.5 do x in [3, 2]"
    found = verdict(tmp_path, "1 <= x <= 2", rate, "within 1; always x <= 3", edge)
    assert isinstance(found, Proved)  # the edge has no outcome (LANGUAGE S9)


@pytest.mark.parametrize(
    ("claim", "expected"),
    [
        ("reach x <= 1 within 5", Proved),
        ("within 0.1; reach x <= 1 within 5", Unknown),
        ("within 0.1; reach x <= 2 within 5", Proved),
        ("within 0.1; can reach x <= 0.5 within 5", Unknown),
        ("within 9; reach x <= 0.5 within 0.1", Refuted),
    ],
)
def test_what_a_shorter_horizon_does_not_show_is_open(tmp_path: Path, claim: str, expected: type) -> None:
    assert isinstance(verdict(tmp_path, "1.9 <= x <= 2", DECAY, claim), expected)
