"""Every spec in the guide's chapters has the verdicts it expects, and no finding that nobody accepted."""

from pathlib import Path

import pytest
from tests import guide

# HA605: an invariant that is not inductive, on purpose. HA900: a condition that a check of the text cannot read.
# HA401: guards that meet at a border, which runs may touch.
TOLD = {"invariants.md": {"HA605", "HA900"}, "reachability.md": {"HA401"}}
SPECS = [(chapter, number) for chapter in TOLD for number in range(len(guide.specs(chapter)))]


@pytest.mark.parametrize(("chapter", "number"), SPECS)
def test_a_spec_of_the_guide_is_decided_as_it_expects(chapter: str, number: int, tmp_path: Path) -> None:
    report = guide.decided(guide.specs(chapter)[number], tmp_path).report
    assert [c.name for c in report.claims if not c.ok] == []
    assert [f.message for f in report.findings if f.accepted is None and f.code not in TOLD[chapter]] == []


def test_the_chapter_on_invariants_shows_proofs_and_what_is_none() -> None:
    specs = guide.specs("invariants.md")
    assert len(specs) >= 3
    for asked in ("inductive expect proved", "inductive expect unknown", "for which"):
        assert any(asked in s for s in specs)
    assert all("expect" in s for s in specs)
    assert any("expect refuted" in s for s in specs)


def test_the_chapter_on_reachability_shows_flows_jumps_and_distance() -> None:
    specs = guide.specs("reachability.md")
    assert len(specs) >= 3
    assert all("expect proved" in s for s in specs)
    assert any("expect refuted" in s for s in specs)
    assert any("urgent edge" in s for s in specs)
