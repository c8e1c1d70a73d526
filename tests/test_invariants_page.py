"""Every spec in docs/invariants.md has the verdicts it expects, and no finding that nobody accepted."""

import re
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.evidence.verdict import Trust
from haverify.run.pipeline import Options, check

PAGE = (Path(__file__).parents[1] / "docs" / "invariants.md").read_text(encoding="utf-8")
SPECS = re.findall(r"^```ha\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("number", range(len(SPECS)))
def test_a_spec_of_the_page_is_decided_as_it_expects(number: int, tmp_path: Path) -> None:
    path = tmp_path / "page.ha"
    path.write_text(SPECS[number], encoding="utf-8")
    outcome = check(str(path), Options(None, Fraction(60), 1, None, False, None, Trust.ENCLOSED))
    assert [c.name for c in outcome.report.claims if not c.ok] == []
    told = {"HA605", "HA900"}  # an invariant that is not inductive; a condition that a check of the text cannot read
    assert [f.message for f in outcome.report.findings if f.accepted is None and f.code not in told] == []


def test_the_page_shows_proofs_and_what_is_none() -> None:
    assert len(SPECS) == 3
    assert all("inductive expect proved" in s or "inductive expect unknown" in s for s in SPECS)
    assert any("expect refuted" in s for s in SPECS)
