"""Only what was re-checked is CHECKED, and what was refused is nothing."""

from tests.unit.report.examples import PROVED, REFUTED, UNKNOWN, evidence, part

from haverify.evidence.evidence import Evidence
from haverify.evidence.grant import Answer, grant
from haverify.evidence.verdict import Proved, Trust, Unknown
from haverify.text.record import replace

ACCEPTED, REFUSED, BEYOND = Answer("accepted"), Answer("refused", "hash"), Answer("beyond")


def trust(e: Evidence) -> Trust | None:
    return e.verdict.trust if not isinstance(e.verdict, Unknown) else None


def test_accepted_is_checked_and_beyond_is_enclosed() -> None:
    assert trust(grant(evidence(Proved()), ACCEPTED, Trust.ENCLOSED)) is Trust.CHECKED
    assert trust(grant(evidence(Proved()), BEYOND, Trust.ENCLOSED)) is Trust.ENCLOSED


def test_the_report_says_why_a_certificate_was_not_checked_again() -> None:
    found = grant(evidence(Proved()), Answer("beyond", "a record is too coarse"), Trust.ENCLOSED)
    assert found.notes == ("not checked again: a record is too coarse",)
    assert grant(evidence(Proved()), ACCEPTED, Trust.ENCLOSED).notes == ()


def test_the_trust_that_an_analysis_claims_counts_for_nothing() -> None:
    assert trust(grant(evidence(PROVED), BEYOND, Trust.ENCLOSED)) is Trust.ENCLOSED


def test_below_the_grade_it_is_unknown() -> None:
    got = grant(evidence(PROVED), BEYOND, Trust.CHECKED).verdict
    assert isinstance(got, Unknown)
    assert got.kind == "grade"
    assert isinstance(grant(evidence(PROVED), None, Trust.ENCLOSED).verdict, Unknown)
    assert trust(grant(evidence(PROVED), None, Trust.SOLVER)) is Trust.SOLVER


def test_refused_leaves_nothing_decided() -> None:
    got = grant(evidence(REFUTED, part("PS", REFUTED), part("LR", PROVED), part("TS", UNKNOWN)), REFUSED, Trust.SOLVER)
    assert isinstance(got.verdict, Unknown)
    assert all(isinstance(p.verdict, Unknown) for p in got.parts)
    assert got.certificate is None
    assert got.run is None


def test_unknown_stays_as_it_is() -> None:
    found = evidence(UNKNOWN, part("PS", UNKNOWN))
    assert grant(found, None, Trust.CHECKED) is found


def test_an_invariant_that_is_not_checked_is_nothing() -> None:
    shown = {"goals": [{}, {"kind": "invariant"}]}
    found = replace(evidence(PROVED, part("PS", PROVED)), certificate=shown)
    assert trust(grant(found, ACCEPTED, Trust.ENCLOSED)) is Trust.CHECKED
    for grade in (Trust.ENCLOSED, Trust.SOLVER):
        got = grant(found, Answer("beyond", "too much work"), grade)
        assert isinstance(got.verdict, Unknown)
        assert got.verdict.kind == "invariant"
        assert all(isinstance(p.verdict, Unknown) for p in got.parts)
