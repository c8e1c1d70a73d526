"""The layout of constructs, comments, blank lines and long lines."""

import pytest
from tests.trees import SAMPLES, bare, comments, healthy

from haverify.syntax.format import format, print_expr  # noqa: A004
from haverify.syntax.parse import parse
from haverify.syntax.tree import Assume, Binary, Name, Number, Unary
from haverify.text.source import Source
from haverify.text.span import Span

HEAD = 'spec "x" version "1.0"\n'
NOWHERE = Span("", 0, 0)


def formatted(text: str) -> str:
    """The layout of a text without errors."""
    source = Source.of_text("a.ha", text)
    tree, findings = parse(source)
    assert findings == []
    return format(tree, source)


def body(text: str) -> str:
    """The layout of what follows the header."""
    return formatted(HEAD + text).removeprefix(HEAD)


@pytest.mark.parametrize("name", SAMPLES)
def test_samples_keep_their_meaning_and_comments(name: str) -> None:
    once = formatted(SAMPLES[name])
    before, after = healthy(SAMPLES[name]), healthy(once)
    assert bare(after.items) == bare(before.items)
    assert comments(after) == comments(before)
    assert formatted(once) == once


def test_blanks_are_normal_and_numbers_as_written() -> None:
    assert body("const   a:m/s=1.50e0   m/s+ -(2*b) ^2") == "const a: m/s = 1.50e0 m/s + -(2 * b)^2\n"


def test_one_blank_line_is_kept_between_items() -> None:
    assert body("\n\n\nconst a = 1\n\n// c\n\n\n/// d\nconst b = 2; const c = 3\n\n") == (
        "\nconst a = 1\n\n// c\n\n/// d\nconst b = 2\nconst c = 3\n"
    )


def test_blocks_stay_on_one_line_when_short_and_written_so() -> None:
    short = "automaton A { mode M { domain x <= 1; flow { x' = y, y' = 2 } } }\n"
    assert body(short) == short.replace("y, y'", "y; y'")
    assert body(short.replace("{ mode", "{\nmode")) == (
        "automaton A {\n  mode M { domain x <= 1; flow { x' = y; y' = 2 } }\n}\n"
    )
    long = f"property p {{ always {'x' * 50} < {'y' * 50}; expect proved }}"
    assert body(long) == f"property p {{\n  always {'x' * 50} < {'y' * 50}\n  expect proved\n}}\n"


def test_comments_stay_where_they_were() -> None:
    text = (
        "// above\nautomaton A { // opens\n  // first\n  var x: m // unit\n\n  // alone\n  mode M {\n    flow { // go\n"
        "      // rate\n      x' = 1 m/s // fast\n    } // flow\n    // last\n  }\n  // end\n} // A\n// file\n"
    )
    assert body(text) == text.replace("A { // opens\n", "A {\n  // opens\n").replace(
        "flow { // go\n", "flow {\n      // go\n"
    ).replace("m // unit", "m  // unit").replace("m/s // fast", "m/s  // fast").replace("} // ", "}  // ")


def test_a_comment_inside_a_line_moves_above_it() -> None:
    assert body("/// d\n// a\nassume x < 1 and // b\n  y < 2") == "// a\n// b\n/// d\nassume x < 1 and y < 2\n"


def test_comments_in_braces_of_one_assignment_are_kept() -> None:
    text = "automaton A {\n  edge -> B do { // c\n    x := 1\n  }\n  mode B { // empty {\n  }\n}\n"
    assert comments(healthy(HEAD + body(text))) == comments(healthy(HEAD + text))


def test_attributes_and_docs_have_their_own_lines() -> None:
    assert body('automaton A { @a @b(1, c = "d") var x: m\n}') == (
        'automaton A {\n  @a\n  @b(1, c = "d")\n  var x: m\n}\n'
    )


def test_long_lines_break_at_the_outermost_operators() -> None:
    condition = " and ".join(f"(first{k} < {k} or second{k} > {k})" for k in range(8))
    lines = body(f"assume {condition}").splitlines()
    assert len(lines) > 1 and all(len(line) <= 120 for line in lines)
    assert all(line.startswith("    and (") for line in lines[1:])


def test_long_calls_break_after_commas() -> None:
    lines = body(f"assume f({', '.join(f'argument{k}' for k in range(30))}) > 0").splitlines()
    assert len(lines) > 1 and all(line.endswith(",") for line in lines[:-1])


def test_a_break_is_never_made_inside_a_string() -> None:
    text = f'property p {{ expect refuted because "{"a, b and c " * 30}" }}'
    assert len(body(text).splitlines()) == 3


def test_a_power_of_a_quantity_stays_one() -> None:
    assert body("const a = 2 m ^ 2 + 3 rpm ^ 2 + x ^ 2") == "const a = 2 m ^ 2 + 3 rpm ^ 2 + x^2\n"


def test_expressions_get_the_parentheses_they_need() -> None:
    x, two = Name("x", NOWHERE), Number(2, "2", None, NOWHERE)  # type: ignore[arg-type]
    total = Binary("+", x, two, NOWHERE)
    assert print_expr(Binary("*", total, total, NOWHERE)) == "(x + 2) * (x + 2)"
    assert print_expr(Binary("-", x, total, NOWHERE)) == "x - (x + 2)"
    assert print_expr(Binary("^", Unary("-", x, NOWHERE), Unary("-", x, NOWHERE), NOWHERE)) == "(-x)^-x"
    assert print_expr(Unary("not", Binary("or", x, x, NOWHERE), NOWHERE)) == "not (x or x)"
    assert print_expr(Binary("implies", Binary("implies", x, x, NOWHERE), x, NOWHERE)) == "(x implies x) implies x"


def test_long_chains_do_not_recurse() -> None:
    item = healthy(HEAD + "assume " + "a" + ".b" * 3000 + " < " + " + ".join("x" for _ in range(3000)))
    assume = item.items[1].body
    assert isinstance(assume, Assume)
    assert print_expr(assume.condition).count("+") == 2999


@pytest.mark.parametrize(
    "opening", ["(", "-", "not ", "2^", "f(", "x[", "a implies ", "(a + b * (", "if a then b else ", "-x^(-"]
)
def test_what_is_read_is_not_too_deep_to_be_written(opening: str) -> None:
    deep = [opening * depth + "1" + _closing(opening) * depth for depth in range(1, 200)]
    accepted = [text for text in deep if not parse(Source.of_text("a.ha", HEAD + "assume " + text))[1]]
    assert 10 < len(accepted) < 199
    healthy(HEAD + body("assume " + accepted[-1]))


def _closing(opening: str) -> str:
    return "".join({"(": ")", "[": "]"}.get(letter, "") for letter in reversed(opening))
