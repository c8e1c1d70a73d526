"""Changes in the text of a spec."""

from __future__ import annotations

import pytest

from haverify.repair.written import written_changes
from haverify.text.source import Source
from haverify.text.span import Span


def changes(text: str) -> list[tuple[str, str]]:
    """Each change as its kind and the whole text after it."""
    source = Source.of_text("a.ha", text)
    found = written_changes(source, Span("a.ha", 0, len(text)))
    edits = [(c.kind, c.edits[0]) for c in found]
    return [(kind, text[: e.span.start] + e.text + text[e.span.end :]) for kind, e in edits]


@pytest.mark.parametrize(
    ("text", "change"),
    [
        ("when x > 1.6 s", ("strictness", "when x >= 1.6 s")),
        ("y <= a", ("strictness", "y < a")),
        ("rule 0b01 -> 0b10", ("bit", "rule 0b11 -> 0b10")),
        ("rule 0b01 -> 0b10", ("bit", "rule 0b01 -> 0b11")),
        ("y >= -7 deg", ("sign", "y >= 7 deg")),
        ("y >= 7 deg", ("sign", "y >= -7 deg")),
        ("a - b", ("sign", "a + b")),
        ("x >= 7.33 s", ("point", "x >= 0.733 s")),
        ("[1, 12]", ("digits", "[1, 21]")),
    ],
)
def test_a_slip(text: str, change: tuple[str, str]) -> None:
    assert change in changes(text)


@pytest.mark.parametrize("text", ["A -> B", "a := b", "(a, b) => c", "x2 and p1", '"1 < 2"', "// x < 3", "A ++ B"])
def test_nothing_to_change(text: str) -> None:
    assert changes(text) == []


def test_the_sign_of_a_number_is_not_the_sign_between_terms() -> None:
    assert ("sign", "implies 18 deg <= y") in changes("implies -18 deg <= y")
    assert ("sign", "implies +18 deg <= y") not in changes("implies -18 deg <= y")
