"""Recorded flows made up to have false claims believed."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.unit.hacheck.flowing import Flowing

from hacheck.rational import Beyond

STEADY = """automaton A {
  var x
  var y
  init R where x == 0 and y == 0
  mode R { flow { x' = 1; y' = 0 } }
}"""


def test_a_run_has_one_length_a_step(tmp_path: Path) -> None:
    """Where lengths differ over the set, their least bound need not be one of them: a run would go on too far."""
    made = Flowing(tmp_path, f"{STEADY}\nproperty p on A {{ within 1.5; always x <= 1.6 }}")
    assert made.shown() == "proved"
    run = {"mode": "R", "values": {"x": "0", "y": "0"}, "params": {}, "steps": [], "last": "3/2"}
    entry = {"flow": made.entry["flow"], "hash": made.entry["hash"], "kind": "flow_run", "run": run}
    made.certificate |= {"verdict": "refuted", "goals": [entry]}
    one, record = 1 << made.record["bits"], made.record
    record["set"], record["order"] = ["x", "y"], 2
    record["monomials"] = [[0, 0], [1, 1], [2, 0]]  # z + z y is -1/4 at least, its bound -1
    paces = [2 * one, one, one]
    record["starts"][0]["pieces"] = {"steps": [{"h": paces, "x": [[paces], [[]]]}, {"h": one, "x": [[[one]], [[]]]}]}
    with pytest.raises(Beyond, match="no one length"):
        made.shown()
