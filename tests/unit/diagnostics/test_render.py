"""The message form: a summary, the place with carets, notes, a help to paste."""

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render, render_all
from haverify.text.source import Source
from haverify.text.span import Span

PATH = "spec/ranges.ha"
TEXT = 'spec "R" version "1.0"\n  domain -7.576 deg <= lh < -17.0965 deg\n'


def span(part: str, text: str = TEXT, path: str = PATH) -> Span:
    start = text.index(part)
    return Span(path, start, start + len(part))


def shown(d: Diagnostic, text: str = TEXT, path: str = PATH) -> str:
    return render(d, {path: Source.of_text(path, text)})


def test_the_form_of_a_finding() -> None:
    d = Diagnostic(
        "HA201",
        "empty interval: the lower bound is above the upper bound",
        span("-17.0965 deg"),
        "below the lower bound by 9.5205 deg",
        (Label(span("-7.576 deg")),),
        ("no value of `lh` satisfies this", "two lines\nof a note"),
        "as a range: `-17.0965 deg < lh <= -7.576 deg`",
    )
    assert shown(d) == (
        "error[HA201]: empty interval: the lower bound is above the upper bound\n"
        "  --> spec/ranges.ha:2:29\n"
        "   |\n"
        " 2 |   domain -7.576 deg <= lh < -17.0965 deg\n"
        "   |          ----------         ^^^^^^^^^^^^ below the lower bound by 9.5205 deg\n"
        "   = note: no value of `lh` satisfies this\n"
        "   = note: two lines\n"
        "           of a note\n"
        "   = help: as a range: `-17.0965 deg < lh <= -7.576 deg`\n"
    )


def test_a_tab_is_one_column() -> None:
    text = "\tdomain x < 1\n"
    lines = shown(Diagnostic("HA002", "m", span("x", text)), text).splitlines()
    assert lines[1].endswith(":1:9")
    assert lines[3].index("x") == lines[4].index("^")


def test_other_files_get_an_excerpt_of_their_own() -> None:
    table = "phase,p1\nPS,8138\n"
    d = Diagnostic("HA212", "leaves", span("8138", table, "k.csv"), labels=(Label(span("domain"), "declared here"),))
    text = render(d, {PATH: Source.of_text(PATH, TEXT), "k.csv": Source.of_text("k.csv", table)})
    assert text.index("--> k.csv:2:4") < text.index(f"--> {PATH}:2:3")
    assert "------ declared here" in text


def test_a_long_line_is_clipped_around_the_place() -> None:
    text = "x" * 5000 + "HERE" + "y" * 5000
    lines = shown(Diagnostic("HA001", "m", span("HERE", text)), text).splitlines()
    assert max(map(len, lines)) < 140
    at = lines[4].index("^")
    assert lines[3][at : at + 4] == "HERE"
    assert lines[4].count("^") == 4


def test_a_place_behind_a_long_line_is_shown() -> None:
    text = "x" * 5000 + "\n"
    lines = shown(Diagnostic("HA001", "m", Span(PATH, 5000, 5001)), text).splitlines()
    assert lines[3].endswith("x" * 50)
    assert lines[4].index("^") == len(lines[3]) and lines[4].count("^") == 1


def test_a_place_at_the_end_of_the_file_is_one_column_wide() -> None:
    lines = shown(Diagnostic("HA003", "m", Span(PATH, len(TEXT), len(TEXT)))).splitlines()
    assert lines[-1].count("^") == 1


def test_control_characters_do_not_reach_the_terminal() -> None:
    text = "a\x1b[31mb\n"
    assert "\x1b" not in shown(Diagnostic("HA001", "m", span("b", text)), text)


def test_findings_are_shown_in_order_of_place_and_once() -> None:
    a, b = Diagnostic("HA002", "b", span("lh")), Diagnostic("HA101", "a", span("domain"))
    nowhere = Diagnostic("HA006", "file")
    assert settle([a, b, nowhere, a]) == [nowhere, b, a]


def test_a_cascade_is_capped_and_says_so() -> None:
    many = [Diagnostic("HA002", f"no variable 'x{k}'", span("lh")) for k in range(25)]
    text = render_all(many, {PATH: Source.of_text(PATH, TEXT)})
    assert text.count("error[HA002]") == 20
    assert "... and 5 more of HA002" in text


def test_colour_marks_the_code_only() -> None:
    d = Diagnostic("HA002", "m", fix=Fix("f", (Edit(span("lh"), "rh"),)))
    assert render(d, {}, colour=True) == "\x1b[1;31merror[HA002]\x1b[0m: m\n"
