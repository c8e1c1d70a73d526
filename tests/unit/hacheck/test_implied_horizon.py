"""Which conditions speak of no instant after some time, by their shape; both programs agree."""

from fractions import Fraction
from typing import Any

import pytest

from hacheck.obligations import Question
from haverify.model.core import expr_from_json
from haverify.obligations.horizon import implied_end

UP_TO_2: Any = ["<=", ["time"], "2"]
OTHER: Any = ["<=", ["var", "x"], "1"]
CASES = [
    (["implies", UP_TO_2, OTHER], 2),
    (["implies", [">", "2", ["time"]], OTHER], 2),
    (["implies", ["and", OTHER, UP_TO_2, ["<", ["time"], "1"]], OTHER], 1),
    (["implies", OTHER, ["implies", UP_TO_2, OTHER]], 2),
    (["not", ["and", UP_TO_2, OTHER]], 2),
    (["and", ["implies", UP_TO_2, OTHER], ["implies", ["<", ["time"], "3"], OTHER]], 3),
    (["and", ["implies", UP_TO_2, OTHER], OTHER], None),
    (["implies", ["or", UP_TO_2, OTHER], OTHER], None),
    (["implies", ["not", UP_TO_2], OTHER], None),
    (["implies", [">=", ["time"], "2"], OTHER], None),
    (["implies", ["==", ["time"], "2"], OTHER], None),
    (["implies", OTHER, UP_TO_2], None),
    (UP_TO_2, None),
]


def checker_says(condition: Any) -> Fraction | None:
    from hacheck.obligations import conjuncts, pushed

    question = Question.__new__(Question)
    question._time = Fraction  # type: ignore[method-assign,assignment]
    ends = [question._true_after(c) for c in conjuncts(pushed(condition))]
    return None if None in ends else max(e for e in ends if e is not None)


@pytest.mark.parametrize(("condition", "end"), CASES)
def test_the_end_that_a_condition_brings(condition: Any, end: int | None) -> None:
    assert checker_says(condition) == end
    number = implied_end(expr_from_json(condition), lambda e: e.args[0] if e.op == "num" else None)  # type: ignore[arg-type,return-value]
    assert number == end
