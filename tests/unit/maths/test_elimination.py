"""Linear equations and definite matrices, exactly."""

from fractions import Fraction

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from haverify.maths.definite import squares
from haverify.maths.elimination import echelon, kernel

Q = Fraction
ENTRY = st.integers(min_value=-6, max_value=6).map(lambda k: Q(k, 2))
CALM = settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
ROW = st.lists(ENTRY, min_size=4, max_size=4)


def _equation(row: list[Q]) -> dict[int, Q]:
    return {k: c for k, c in enumerate(row) if c}


def test_two_equations() -> None:
    solved = echelon([({0: Q(1), 1: Q(1)}, Q(3)), ({0: Q(1), 1: Q(-1)}, Q(1))])
    assert solved is not None
    assert solved.solution({}) == {0: Q(2), 1: Q(1)}


def test_a_contradiction() -> None:
    assert echelon([({0: Q(1)}, Q(1)), ({0: Q(2)}, Q(3))]) is None


@CALM
@given(st.lists(ROW, min_size=1, max_size=4), ROW)
def test_a_solution_solves(rows: list[list[Q]], point: list[Q]) -> None:
    right = [sum((a * x for a, x in zip(row, point, strict=True)), Q(0)) for row in rows]
    solved = echelon((_equation(row), r) for row, r in zip(rows, right, strict=True))
    assert solved is not None
    found = solved.solution({3: Q(7)})
    assert all(
        sum((c * found.get(k, Q(0)) for k, c in enumerate(row)), Q(0)) == r for row, r in zip(rows, right, strict=True)
    )


@CALM
@given(st.lists(ROW, min_size=1, max_size=4))
def test_the_kernel_is_mapped_to_0(rows: list[list[Q]]) -> None:
    for v in kernel([_equation(row) for row in rows], 4):
        assert v
        assert all(sum((c * v.get(k, Q(0)) for k, c in enumerate(row)), Q(0)) == 0 for row in rows)


@CALM
@given(st.lists(st.lists(ENTRY, min_size=3, max_size=3), min_size=1, max_size=3))
def test_sums_of_squares_are_found_again(vectors: list[list[Q]]) -> None:
    gram = [[sum((v[i] * v[j] for v in vectors), Q(0)) for j in range(3)] for i in range(3)]
    parts = squares(gram)
    assert parts is not None
    assert gram == [[sum((q * v[i] * v[j] for q, v in parts), Q(0)) for j in range(3)] for i in range(3)]


def test_what_is_not_definite() -> None:
    assert squares([[Q(1), Q(2)], [Q(2), Q(1)]]) is None
    assert squares([[Q(0), Q(1)], [Q(1), Q(0)]]) is None
