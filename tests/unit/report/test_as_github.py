"""Annotations: what a report has to say, beside the lines it is about."""

from tests.unit.report.facts import claim, finding, hostile, whole, wrong

from haverify.report.as_github import as_github


def test_errors_warnings_and_undecided_claims_are_annotated() -> None:
    found = [finding(), finding(severity="warning", code="HA212"), finding(severity="information", code="HA309")]
    lines = as_github(whole(wrong("high", "unknown"), claim(), findings=found)).splitlines()
    assert [line.split(" ")[0] for line in lines] == ["::error", "::warning", "::error"]
    assert lines[2] == "::error file=spec/a b.ha,line=9,title=unknown::high: stopped"


def test_a_claim_of_which_a_finding_tells_is_told_once() -> None:
    problem = finding(code="HA701", message="low: expected proved, got refuted")
    assert len(as_github(whole(wrong(), findings=[problem])).splitlines()) == 1


def test_what_explains_an_expected_verdict_is_silent() -> None:
    why = finding(code="HA702", severity="verdict", message="low: stopped")
    assert as_github(whole(claim("low", "unknown"), findings=[why])) == ""


def test_hostile_texts_stay_on_their_lines() -> None:
    for line in as_github(hostile()).splitlines():
        assert line.startswith("::error ")
