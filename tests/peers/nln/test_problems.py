"""The problems are readable specs: laid out, without findings, each with figures of peers and claims to prove."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from haverify.run.examine import examine
from haverify.syntax.format import format as laid_out
from haverify.syntax.parse import parse
from haverify.text.source import Source

FOLDER = Path(__file__).parent
# HA900: a condition that a check of the text cannot read. HA309: a mode without an edge, in which time goes on.
TOLD = {"HA900", "HA309"}
SPECS = sorted(FOLDER.glob("*.ha"))
PEERS = json.loads((FOLDER / "peers.json").read_text(encoding="utf-8"))["instances"]


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
def test_a_problem_reads_well(path: Path) -> None:
    found = examine(str(path))
    assert found.spec is not None
    assert [d for d in found.new if d.code not in TOLD] == []
    assert all(a.doc for a in found.spec.automata)
    assert all(c.doc and c.expect and c.expect.verdict == "proved" for c in found.spec.claims)


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
def test_a_problem_is_laid_out(path: Path) -> None:
    source = Source(str(path), path.read_text(encoding="utf-8"))
    tree, _ = parse(source)
    assert laid_out(tree, source) == source.text


def test_every_problem_has_peers() -> None:
    assert sorted(i["spec"] for i in PEERS) == sorted(p.name for p in SPECS)
    for instance in PEERS:
        assert instance["peers"] or instance["spec"] == "spacecraft_rendezvous.ha"
        told = [instance["floor"], *(p["figures"] for p in instance["peers"])]
        assert all(f is None or len(f) == len(instance["measures"]) for f in told)
