"""Verdicts against expectations: which exit code, and what is said."""

from dataclasses import replace
from itertools import permutations

import pytest
from tests.unit.report.examples import PROVED, REFUTED, UNKNOWN, claim, evidence, margin, part

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.evidence.verdict import Verdict
from haverify.report.exit_codes import finding_code, worst
from haverify.report.gate import judge, violated


@pytest.mark.parametrize(
    ("expect", "verdict", "code"),
    [
        (None, PROVED, 0),
        (None, REFUTED, 1),
        (None, UNKNOWN, 3),
        ("proved", PROVED, 0),
        ("proved", REFUTED, 1),
        ("proved", UNKNOWN, 3),
        ("refuted", PROVED, 1),
        ("refuted", REFUTED, 0),
        ("refuted", UNKNOWN, 3),
        ("unknown", PROVED, 1),
        ("unknown", REFUTED, 1),
        ("unknown", UNKNOWN, 0),
    ],
)
def test_every_verdict_under_every_expectation(expect: str | None, verdict: Verdict, code: int) -> None:
    judged = judge(claim(expect), evidence(verdict), None)
    assert judged.exit_code == code
    assert any(d.code == "HA701" for d in judged.problems) == (code == 1)


def test_unexpectedly_proved_says_what_to_remove() -> None:
    (problem,) = judge(claim("refuted"), evidence(PROVED), None).problems
    assert problem.message == "range: expected refuted, got proved: remove the expectation or the fix"


def test_a_new_violation_beside_an_expected_one_is_named() -> None:
    found = evidence(REFUTED, part("MST", REFUTED), part("PS", REFUTED))
    judged = judge(claim("refuted"), found, ("Gait / PS / lk",))
    assert judged.exit_code == 1
    assert [d.message for d in judged.problems] == ["range: newly violated: Gait / MST / lk"]


def test_a_violation_that_is_gone_is_named() -> None:
    found = evidence(REFUTED, part("MST", PROVED), part("PS", REFUTED))
    judged = judge(claim("refuted"), found, ("Gait / MST / lk", "Gait / PS / lk"))
    assert judged.exit_code == 1
    assert "no longer violated: Gait / MST / lk" in judged.problems[0].message


def test_a_violation_that_is_undecided_now_is_not_called_gone() -> None:
    found = evidence(REFUTED, part("MST", UNKNOWN), part("PS", REFUTED))
    judged = judge(claim("refuted"), found, ("Gait / MST / lk", "Gait / PS / lk"))
    assert (judged.exit_code, judged.problems) == (3, ())
    assert "undecided now: Gait / MST / lk" in judged.notes[0]


def test_parts_of_several_goals_have_names_of_their_own() -> None:
    found = evidence(REFUTED, part("PS", REFUTED), part("PS", REFUTED, goal=1))
    assert violated(claim("refuted", goals=2), found) == ("Gait / PS / lk / goal 1", "Gait / PS / lk / goal 2")


@pytest.mark.parametrize(
    ("stated", "low", "high", "code"),
    [
        (("<", "0"), "-5/2", "-5/2", 0),
        (("<", "-3"), "-5/2", "-5/2", 1),
        ((">=", "-2.5"), "-5/2", "-5/2", 0),
        ((">", "-2.5"), "-5/2", "-5/2", 1),
        (("<", "-2.5"), "-26/10", "-24/10", 1),
        (("==", "-2.5"), "-5/2", "-5/2", 0),
        (("==", "-2.5"), "-26/10", "-24/10", 1),
        (("!=", "-2"), "-26/10", "-24/10", 0),
    ],
)
def test_margins_are_compared_exactly(stated: tuple[str, str], low: str, high: str, code: int) -> None:
    found = evidence(replace(REFUTED, margin=margin(low, high)))
    assert judge(claim("refuted", stated), found, None).exit_code == code


def test_a_margin_too_close_to_its_bound_is_not_called_met() -> None:
    found = evidence(replace(PROVED, margin=margin("19/10", "21/10")))
    (problem,) = judge(claim("proved", (">", "2")), found, None).problems
    assert "too close to tell" in problem.message


def test_a_margin_in_another_unit_is_converted() -> None:
    found = evidence(replace(PROVED, margin=replace(margin("1/100"), unit="rad")))
    assert judge(claim("proved", ("<", "0.573")), found, None).exit_code == 0
    assert judge(claim("proved", ("<", "0.572")), found, None).exit_code == 1


def test_a_stated_margin_needs_one() -> None:
    assert judge(claim("proved", (">", "0")), evidence(replace(PROVED, margin=None)), None).exit_code == 1


def test_precedence_of_exit_codes() -> None:
    order = (130, 4, 2, 1, 3, 5, 0)
    for codes in permutations(order, 3):
        assert worst(codes) == min(codes, key=order.index)
    assert worst([]) == 5


def test_errors_without_meaning_cannot_be_accepted_and_are_2() -> None:
    fault, lost = Diagnostic("HA303", "time-lock"), Diagnostic("HA002", "no name")
    assert finding_code([fault], []) == 1
    assert finding_code([fault], [fault]) == 0
    assert finding_code([fault, lost], []) == 2
    assert finding_code([Diagnostic("HA204", "gap")], []) == 0
