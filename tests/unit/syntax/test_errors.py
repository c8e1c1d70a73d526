"""Errors are said in words, at their place, once, and what is healthy is still read."""

import pytest

from haverify.syntax import tree as t
from haverify.syntax.parse import parse
from haverify.text.source import Source

HEAD = 'spec "x" version "1.0"\n'


def errors(text: str) -> list[tuple[str, int, int, str]]:
    """Code, line, column and message of every finding."""
    source = Source.of_text("a.ha", text)
    found = []
    for finding in parse(source)[1]:
        assert finding.span is not None
        found.append((finding.code, *source.position(finding.span.start), finding.message))
    return found


def names(text: str) -> list[str]:
    """What kinds of declarations were read."""
    return [type(item.body).__name__ for item in parse(Source.of_text("a.ha", text))[0].items]


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("", 1, 1, 'the file is empty: start with `spec "..." version "1.0"`, or run `haverify init`'),
        ("// b", 1, 1, "expected a declaration, found end of file"),
        ('spec "x" version "9.0"', 1, 18, "this version of haverify reads language version 1.0, not '9.0'"),
        (HEAD + "property p { always h < }", 2, 25, "expected an expression after '<', found '}'"),
        (HEAD + "property p { always h <\n}", 2, 24, "expected an expression after '<', found end of line"),
        (HEAD + "const a =", 2, 10, "expected an expression after '=', found end of file"),
        (HEAD + "automaton A { var init: m }", 2, 19, "'init' is a word of the language and cannot be a name"),
        (HEAD + "automaton A { var thé: m }", 2, 21, "'thé' cannot be a name: names are ASCII letters, digits and '_'"),
        (HEAD + "const a = 1 2", 2, 13, "expected a name, an operator or end of line after '1', found '2'"),
        (HEAD + 'const a = "b', 2, 11, "this string does not end on its line"),
        (HEAD + "assume a ≤ b", 2, 10, "'≤' is not a symbol of the language"),
        (HEAD + "let a = 1", 2, 1, "expected a declaration, found the word 'let'"),
        (
            HEAD + "const a = 1 /// b",
            2,
            13,
            "a doc comment stands on a line of its own before a declaration or a member",
        ),
        (HEAD + "/// b\n", 2, 1, "nothing follows this doc comment that it could describe"),
        (HEAD + "automaton A {\n}", 3, 1, "expected a member of an automaton, found '}'"),
        (HEAD + "automaton A { edge go[i + 1]: -> B }", 2, 23, "the index of a declared name is one value of an enum"),
        ("spec \x00", 1, 6, "this is not a text file: it contains the control character 0x00"),
    ],
)
def test_messages(text: str, line: int, column: int, message: str) -> None:
    assert errors(text) == [("HA001", line, column, message)]


@pytest.mark.parametrize(
    ("text", "help"),
    [
        ('"""a room"""', "write `/// ...` above a declaration to describe it"),
        ("const a = 5 [K]", "a unit follows a number, or a colon: `0.5 m/s`, `x: m/s`"),
        ("param a [1/s] in [1, 2]", "a unit follows a number, or a colon: `0.5 m/s`, `x: m/s`"),
        ("param a: 1/s in [0.9 1/s, 2 1/s]", "write a unit below one with a power: `0.5 s^-1`"),
        ("property p: always x < 1", "write `{ ... }` around what follows"),
        ("automaton A { init M: x == 1 }", "no colon stands here"),
        ("assume a = 1", "write `==` to compare"),
        ("property p { always 1 < 2 within 3 s }", "begin a new line, or write `;`, before `within ...`"),
    ],
)
def test_what_other_languages_take_is_met_with_what_to_write(text: str, help: str) -> None:
    assert parse(Source.of_text("a.ha", HEAD + text))[1][0].help == help


def test_an_operator_before_a_reserved_word_is_reported_at_the_operator() -> None:
    text = HEAD + "automaton A {\n  mode M {\n    domain x <\n    edge -> M\n  }\n}\n"
    source = Source.of_text("a.ha", text)
    (finding,) = parse(source)[1]
    assert finding.span is not None
    assert (finding.code, source.at(finding.span)) == ("HA003", "<")
    assert [source.at(label.span) for label in finding.labels] == ["edge"]


@pytest.mark.parametrize(
    ("text", "opened", "found"),
    [
        (HEAD + "automaton A {\n  mode M {\n    terminal\n\n  mode N { terminal }\n}\n", (3, 10), (6, 3)),
        (HEAD + "automaton A {\n  mode M { terminal }\nproperty p { holds true }\n", (2, 13), (4, 1)),
        (HEAD + "automaton A {\n  let a = (x + 3\n  let b = 4\n}\n", (3, 11), (4, 3)),
        (HEAD + "property p {\n  holds true\n", (2, 12), (4, 1)),
        (HEAD + "property p { holds f(x }", (2, 21), (2, 24)),
    ],
)
def test_an_unclosed_bracket_is_shown_with_where_it_was_missed(
    text: str, opened: tuple[int, int], found: tuple[int, int]
) -> None:
    source = Source.of_text("a.ha", text)
    (finding,) = parse(source)[1]
    assert finding.span is not None and finding.code == "HA003"
    assert finding.message == f"'{source.at(finding.span)}' opened here is never closed"
    assert source.position(finding.span.start) == opened
    assert [source.position(label.span.start) for label in finding.labels] == [found]


@pytest.mark.parametrize("bracket", ["}", ")", "]"])
def test_a_bracket_too_many_closes_nothing(bracket: str) -> None:
    text = HEAD + f"automaton A {{ var x }}\n{bracket}\nconst k = 1\n"
    assert errors(text) == [("HA003", 3, 1, f"'{bracket}' closes nothing")]
    assert names(text) == ["SpecHeader", "Automaton", "Const"]


def test_each_error_is_reported_once_and_the_rest_is_read() -> None:
    text = HEAD + (
        "automaton A {\n  var x: m\n  mode R {\n    flow { x' = 1 + ; y' = 2 }\n    domain x < \n  }\n"
        "  mode B { flow { y = 3; z' = 4 } }\n  bogus line here\n  var w: m\n}\n"
        "property p on A { always x < 3 }\nlet k = 1\nconst c = 2\n"
    )
    assert [line for _, line, _, _ in errors(text)] == [5, 6, 8, 9, 13]
    tree = parse(Source.of_text("a.ha", text))[0]
    assert names(text) == ["SpecHeader", "Automaton", "Property", "Const"]
    automaton = tree.items[1].body
    assert isinstance(automaton, t.Automaton)
    assert [type(item.body).__name__ for item in automaton.members] == ["Var", "Mode", "Mode", "Var"]
    flows = [line.body for item in automaton.members if isinstance(item.body, t.Mode) for line in item.body.members]
    assert [d.target.name for flow in flows if isinstance(flow, t.Flow) for d in flow.lines] == ["y", "z"]


def test_many_errors_are_capped() -> None:
    text = HEAD + "".join(f"const a{k} = \nconst b{k} = {k}\n" for k in range(50))
    findings = parse(Source.of_text("a.ha", text))[1]
    assert len(findings) == 20
    assert findings[-1].notes == ("only the first 20 errors of this file are shown",)
    assert names(text).count("Const") == 50


@pytest.mark.parametrize(
    "number", ["1e999999999", "1e-999999999", "1" * 5000, "0." + "1" * 5000, "1e2001", "1e-0002001"]
)
def test_a_number_nobody_can_mean_is_refused_at_its_place(number: str) -> None:
    ((code, line, column, message),) = errors(f"{HEAD}const a = {number}\nconst b = 1\n")
    assert (code, line, column) == ("HA001", 2, 11)
    assert message.startswith("number too large or too small to be meant")


def test_a_code_nobody_can_mean_is_refused() -> None:
    assert [e[0] for e in errors(f"{HEAD}enum E {{ a = 0b{'1' * 5000} }}")] == ["HA001"]


@pytest.mark.parametrize(
    "text",
    [
        "(" * 100_000,
        "-" * 100_000,
        "not " * 50_000,
        "2^" * 50_000,
        "f(" * 50_000,
        "[1, " * 50_000,
        "if a then " * 9_000,
    ],
)
def test_deep_nesting_is_one_finding(text: str) -> None:
    ((code, line, _, message),) = errors(f"{HEAD}assume {text}")
    assert (code, line, message) == ("HA001", 2, "nested too deeply to be meant; the rest of the file was not read")


def test_sixty_levels_of_brackets_are_not_too_deep() -> None:
    assert errors(f"{HEAD}assume {'(' * 60}1{')' * 60} == 1") == []


def test_a_huge_file_is_not_read() -> None:
    ((code, line, column, message),) = errors("x" * 16_000_001)
    assert (code, line, column) == ("HA001", 1, 1)
    assert "16000001 characters" in message


@pytest.mark.parametrize(
    "text", ["}" * 300_000, "x\n" * 300_000, '"' * 300_000, "é " * 300_000, "{}" * 400_000, ",;" * 300_000]
)
def test_garbage_gives_few_findings(text: str) -> None:
    assert 1 <= len(errors(text)) <= 20
    assert 1 <= len(errors(HEAD + "automaton A { mode M { flow {" + text)) <= 20
