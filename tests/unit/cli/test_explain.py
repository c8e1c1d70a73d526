"""`haverify explain` of what there is no page of."""

from collections.abc import Callable
from typing import Any


def test_a_code_that_does_not_exist(haverify: Callable[..., Any]) -> None:
    said = haverify("explain", "ha999")
    assert (said.code, said.err) == (2, "haverify: no such code: HA999\n")
