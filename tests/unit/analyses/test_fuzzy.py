"""Claims about fuzzy systems: each verdict is the one worked out by hand, and the checker agrees."""

from fractions import Fraction

import pytest
from tests.unit.analyses.fuzzy_texts import FORCE, decided, spec_of, verdict, witness

from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.syntax.parse import parse
from haverify.text.source import Source

PUSHES = "param push: N in [0 N, 12 N]\nparam harder: N in [0 N, 12 N]\n"
RANK = "fn rank(q: S): 1 = if q is low then 0 else 1\n"
OTHER = """
fuzzy G {
  input force: N over [0 N, 12 N] { small = trap(0 N, 0 N, 4 N, 5 N) }
  input side: 1 over [0, 1] { yes = ramp(0, 1) }
  output o { low, high }
  logic min max
  rule force is small and side is yes => o is low
  rule not force is small and side is yes => o is high
}
fuzzy Chained {
  input a from F.o
  output answer { stay, go }
  logic min max
  rule a is low and not a is high => answer is stay
  rule a is high => answer is go
}
"""


@pytest.mark.parametrize(
    ("claim", "expected"),
    [
        ("on F { holds covered(force, 0.5) }", "proved"),
        ("on F { holds covered(force, 0.51) }", "refuted"),
        ("on F { assume force != 4.5 N\n holds covered(force, 0.5001) }", "refuted"),
        ("on F { assume force in [12.1 N, 15 N]\n holds covered(force, 0.1) }", "refuted"),
        ("on F { assume force >= 8 N\n holds strength(high) == side }", "proved"),
        ("on F { holds strength(low) + strength(high) <= side }", "refuted"),
        ("on F { holds strength(low) + strength(high) == side }", "refuted"),
        ("on F { assume side == 1\n holds strength(low) + strength(high) == 1 }", "proved"),
        ("on F { holds max_firing(o) >= min(0.5, side) }", "proved"),
        ("on F { holds max_firing(o) > min(0.5, side) }", "refuted"),
        ("on F { holds strength(low) == 1 implies force <= 4 N and side == 1 }", "proved"),
        ("on F { holds strength(low) == 1 implies force < 4 N }", "refuted"),
        ("on F { holds not (strength(low) > 0.5 and strength(high) > 0.5) }", "proved"),
        ("on F { holds not (strength(low) >= 0.5 and strength(high) >= 0.5) }", "refuted"),
        ("on F { assume force >= 9 N\n assume force <= 8 N\n holds covered(force, 1) }", "vacuous"),
        ("on F { assume force < 0 N\n holds covered(force, 1) }", "vacuous"),
        ("on F { holds force * side >= 0 N }", "fragment"),
        ("on F { holds side == 1 implies F.o(force = force, side = side) is high or force <= 4.5 N }", "proved"),
        ("on F { holds side > 0 implies F.o(force = force, side = side) is high or force <= 4.5 N }", "refuted"),
        (
            "on F { holds F.o(force = force, side = side) is high or F.o(force = force, side = side) is low }",
            "fragment",
        ),
        ("on F { holds side > 0 implies F.o(force = force, side = side) is high or force < 4.5 N }", "refuted"),
        ("on F { holds F.o(force = force, side = side) is high }", "refuted"),
    ],
)
def test_one_system(claim, expected):
    assert verdict(FORCE, claim) == expected


@pytest.mark.parametrize(
    ("claim", "expected"),
    [
        ("on F { holds strength(low) == G.strength(low) and strength(high) == G.strength(high) }", "proved"),
        ("on F { assume side == 1\n holds strength(high) == G.strength(high) }", "proved"),
        ("on F { holds strength(low) == G.strength(low) }", "proved"),
        ("on Chained { holds strength(go) == F.strength(high) }", "proved"),
        ("on Chained { holds strength(stay) <= F.strength(low) }", "proved"),
        ("on Chained { holds strength(stay) == F.strength(low) }", "proved"),
        ("on Chained { holds strength(go) + strength(stay) == side }", "refuted"),
        ("on Chained { holds covered(a, 0.5) or side < 0.5 }", "proved"),
    ],
)
def test_several_systems(claim, expected):
    assert verdict(FORCE + OTHER, claim.replace("side == 1\n", "side == 1\n ")) == expected


def test_two_pushes_tell_monotony_and_jumps():
    text = FORCE + PUSHES + RANK
    at = "rank(F.o(force = {}, side = 1))"
    harder, push = at.format("harder"), at.format("push")
    assert verdict(text, f"{{ holds harder >= push implies {harder} >= {push} }}") == "proved"
    assert verdict(text, f"{{ holds harder >= push implies {harder} <= {push} }}") == "refuted"
    point = witness(text, f"{{ holds abs(harder - push) <= 0.01 N implies abs({harder} - {push}) <= 0.5 }}")
    assert sorted(point.values())[0] <= Fraction(9, 2) < sorted(point.values())[1]


def test_an_output_applied_to_shifted_inputs():
    claim = (
        "{ holds push <= 11 N implies rank(F.o(force = push + 1 N, side = 1)) >= rank(F.o(force = push, side = 1)) }"
    )
    assert verdict(FORCE + PUSHES + RANK, claim) == "proved"


def test_a_point_that_decides_is_shown_with_units_and_rules():
    held = decided(spec_of(FORCE + "property p on F { holds covered(force, 0.51) }"))
    assert held.witness == (("force", "4.5 N"), ("side", "1"))
    assert held.facts == ("rule 1 -> low 0.5, rule 2 -> high 0.5",)


def test_inference_by_other_norms_is_not_decided():
    assert verdict(FORCE.replace("logic min max", "logic prod sum"), "on F { holds covered(force, 0.5) }") == "fragment"


def test_a_search_that_is_too_long_says_so():
    held = decided(spec_of(FORCE + "property p on F { holds max_firing(o) >= min(0.5, side) }"), units=0)
    assert held.verdict.kind == "budget"
    assert held.entry == {}


def test_corners_out_of_order_are_reported_and_claims_about_them_are_open():
    text = FORCE.replace("trap(0 N, 0 N, 4 N, 5 N)", "trap(0 N, 6 N, 4 N, 5 N)")
    claim = "property p on F { holds covered(force, 0) }"
    source = Source.of_text("page.ha", f'spec "Test" version "1.0"\n{text}\n{claim}\n')
    spec, found = elaborate(parse(source)[0], Files({source.path: source}))
    assert [d.code for d in found] == ["HA201"]
    assert spec is not None
    assert decided(spec).verdict.reason == "the corners of `small` do not ascend"


def test_for_which_is_not_decided():
    text = FORCE + "param u: 1 in [0, 1]\n"
    assert verdict(text, "on F { for which u in [0, 2]\n holds covered(force, 0.5) or u > 0 }") == "fragment"
