"""Reading what `expand` prints gives the same core, for specs of random expressions."""

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.elaborate.texts import read

from haverify.elaborate.expand import expand
from haverify.model.core import canonical, expr_from_json, expr_to_json, to_core

LAW = settings(max_examples=150, deadline=None, derandomize=True)
DECLARED = """
unit rpm = 6 deg/s
param x in [1, 2]
param a: rad in [0 rad, 1 rad]
param d: deg in [0 deg, 90 deg]
param w: rpm in [1 rpm, 9 rpm]
"""
NUMBERS = st.sampled_from(["0", "1", "2.5", "0.001", "7", "1e3", "(1 / 3)", "3 / 7"])


def combined(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    pair = st.tuples(inner, inner)
    return st.one_of(
        st.tuples(pair, st.sampled_from(["+", "-", "*"])).map(lambda t: f"({t[0][0]}) {t[1]} ({t[0][1]})"),
        st.tuples(pair, st.sampled_from(["+", "-", "*", "/"])).map(lambda t: f"{t[0][0]} {t[1]} {t[0][1]}"),
        inner.map(lambda e: f"-({e})"),
        inner.map(lambda e: f"-{e}"),
        inner.map(lambda e: f"({e})^2"),
        pair.map(lambda t: f"max({t[0]}, {t[1]})"),
        inner.map(lambda e: f"abs({e})"),
        st.tuples(inner, inner, inner).map(lambda t: f"(if {t[0]} < {t[1]} then {t[2]} else {t[0]})"),
    )


PLAIN = st.recursive(st.one_of(NUMBERS, st.just("x"), st.just("a"), st.just("pi")), combined, max_leaves=12)
ANGLES = st.recursive(
    st.sampled_from(["a", "d", "30 deg", "1 rad", "w * 2 s", "(90 deg / 7)", "6 rpm * 1 s", "0.5 * d"]),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-"]), inner).map(lambda t: f"{t[0]} {t[1]} ({t[2]})"),
        st.tuples(inner, st.sampled_from(["+", "-"]), inner).map(lambda t: f"{t[0]} {t[1]} {t[2]}"),
        inner.map(lambda e: f"2 * ({e})"),
        inner.map(lambda e: f"-({e})"),
        st.tuples(inner, inner).map(lambda t: f"min({t[0]}, {t[1]})"),
    ),
    max_leaves=8,
)
TRUTHS = st.recursive(
    st.one_of(
        st.tuples(PLAIN, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), PLAIN).map(" ".join),
        st.tuples(ANGLES, st.sampled_from(["<", ">="]), ANGLES).map(" ".join),
        st.tuples(ANGLES, ANGLES, ANGLES).map(lambda t: f"{t[0]} < {t[1]} <= {t[2]}"),
        st.tuples(ANGLES).map(lambda t: f"sin({t[0]}) in [0, 1]"),
    ),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["and", "or", "implies"]), inner).map(lambda t: f"({t[0]}) {t[1]} ({t[2]})"),
        st.tuples(inner, st.sampled_from(["and", "or", "implies"]), inner).map(" ".join),
        inner.map(lambda e: f"not ({e})"),
    ),
    max_leaves=5,
)


@LAW
@given(TRUTHS, ANGLES)
def test_expansion_keeps_the_core(condition: str, angle: str) -> None:
    spec, found, _ = read(f"{DECLARED}const k: deg = {angle}\nproperty p {{ holds {condition} }}\n")
    assert {d.code for d in found} <= {"HA403"}
    again, found, _ = read(expand(spec))
    assert found == []
    assert canonical(to_core(again)) == canonical(to_core(spec))
    settled = expand(again)  # beside `0 rad` a plain `0` is an angle as well: what is read once more says so or not
    assert expand(read(settled)[0]) == settled


@LAW
@given(TRUTHS)
def test_expressions_survive_json(condition: str) -> None:
    spec, _, _ = read(f"{DECLARED}property p {{ holds {condition} }}\n")
    for claim in spec.claims:
        value = expr_to_json(claim.goals[0].condition)
        assert expr_to_json(expr_from_json(value)) == value
        assert expr_from_json(value) == claim.goals[0].condition
