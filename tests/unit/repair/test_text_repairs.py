"""Repairs of what stands in the text of a spec."""

from __future__ import annotations

from pathlib import Path

import pytest

from haverify.repair.change import Change

from .subjects import CLOCK, mended, subject, texts

LOCKED = """spec "Lock" version "1.0"
automaton A {
  var x: s in [0 s, 5 s]
  init M with x := 0 s
  mode M {
    domain x < 1.6 s
    flow { x' = 1 }
    edge go: -> M when x > 1.6 s do x := 0 s
  }
}
property alive on A { never stuck; expect proved }
"""

RULES = """spec "Rules" version "1.0"
enum Leg { Left = 0b0, Right = 0b1 }
enum Sub { Stance = 0b0, Swing = 0b1 }
cellular Partner {
  cell Cell = Leg ++ Sub
  rule 0b00 -> 0b11
  rule 0b11 -> 0b00
  rule 0b01 -> 0b10
  rule 0b10 -> 0b01
}
property involution on Partner { holds forall c in Cell: next(next(c)) == c; expect proved }
property other on Partner { holds forall c in Cell: next(c).leg != c.leg; expect proved }
"""


def first(change: Change) -> tuple[str, str]:
    return change.kind, change.edits[0].text


def test_silent_where_nothing_is_wrong(tmp_path: Path) -> None:
    s = subject(tmp_path, CLOCK + "property fine on A { always -7 deg <= y <= 3 deg; expect proved }\n")
    outcome = mended(s)
    assert outcome.proposals == () and outcome.left == () and outcome.edits == ()


def test_silent_about_what_is_expected_to_be_refuted(tmp_path: Path) -> None:
    s = subject(tmp_path, CLOCK + 'property known on A { always y <= 0.32 deg; expect refuted because "3 deg" }\n')
    assert mended(s).proposals == () and mended(s).left == ()


def test_a_violation_that_is_not_on_record_is_a_problem(tmp_path: Path) -> None:
    text = CLOCK + 'property known on A { always y <= 0.32 deg; expect refuted because "3 deg" }\n'
    assert mended(subject(tmp_path, text, {"known": ("A / M / y",)})).left == ()
    assert mended(subject(tmp_path, text, {"known": ()})).left != ()


@pytest.mark.parametrize(
    ("claim", "kind", "new"),
    [
        ("always 3 deg <= y <= -7 deg", "bounds", "always -7 deg <= y <= 3 deg"),
        ("always y <= 0.32 deg", "point", "always y <= 3.2 deg"),
        ("always y >= 7.2 deg", "sign", "always y >= -7.2 deg"),
        ("always y < 3 deg", "strictness", "always y <= 3 deg"),
    ],
)
def test_a_slip_in_a_claim(tmp_path: Path, claim: str, kind: str, new: str) -> None:
    s = subject(tmp_path, CLOCK + f"property p on A {{ {claim}; expect proved }}\n")
    outcome = mended(s)
    (p,) = outcome.proposals
    assert p.change.kind == kind
    assert new in texts(s, outcome)["a.ha"]
    assert p.effect.mended == ("p",)


def test_changes_that_do_as_well_are_said(tmp_path: Path) -> None:
    (p,) = mended(subject(tmp_path, CLOCK + "property p on A { always y <= 0.32 deg }\n")).proposals
    assert first(p.change) == ("point", "3.2")
    assert [first(c) for c in p.equals] == [("digits", "3.02")]


def test_a_claim_that_is_simply_false_is_not_bent(tmp_path: Path) -> None:
    s = subject(tmp_path, CLOCK + "property no on A { always y <= 1 deg; expect proved }\n")
    assert mended(s).proposals == ()
    assert [text for text in mended(s).left if text.startswith("no: violated")]


def test_a_guard_just_outside_the_domain(tmp_path: Path) -> None:
    outcome = mended(subject(tmp_path, LOCKED))
    (p,) = outcome.proposals
    assert first(p.change) == ("strictness", ">=")
    assert p.effect.mended == ("alive",)
    assert any(key.startswith("HA303") for key in p.effect.findings)
    assert outcome.left == ()


def test_a_decimal_place_in_a_guard_is_told_from_a_sign(tmp_path: Path) -> None:
    s = subject(tmp_path, LOCKED.replace("x < 1.6", "x <= 1.6").replace("x > 1.6", "x >= 16"))
    (p,) = mended(s).proposals
    assert first(p.change) == ("point", "1.6")


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("0b00 -> 0b11", "0b00 -> 0b10"), ("0b10 -> 0b01", "0b11 -> 0b01"), ("0b01 -> 0b10", "0b01 -> 0b00")],
)
def test_one_bit_of_a_rule(tmp_path: Path, right: str, wrong: str) -> None:
    s = subject(tmp_path, RULES.replace(f"rule {right}", f"rule {wrong}"))
    outcome = mended(s)
    assert texts(s, outcome)["a.ha"] == RULES
    assert {p.change.kind for p in outcome.proposals} == {"bit"}


def test_one_claim_alone(tmp_path: Path) -> None:
    text = CLOCK + "property a on A { always y < 3 deg }\nproperty b on A { always y >= 7.2 deg }\n"
    outcome = mended(subject(tmp_path, text), "b")
    assert [p.effect.mended for p in outcome.proposals] == [("b",)]


def test_the_search_ends_when_time_is_up(tmp_path: Path) -> None:
    from haverify.repair.repair import repair

    s = subject(tmp_path, CLOCK + "property p on A { always y >= 7.2 deg }\n")
    outcome = repair(s, (), None, lambda: False)
    assert outcome.proposals == () and outcome.left != ()
    assert any("more changes" in r for r in outcome.remarks)
