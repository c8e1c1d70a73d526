"""What `@allow` and `haverify.lock` accept, and what they no longer match."""

from datetime import date

import pytest

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.model.spec import Allowed
from haverify.report.allow import about, allow
from haverify.report.baseline import Baseline, FindingEntry, RefutedEntry, accept, stale
from haverify.text.source import Source
from haverify.text.span import Span

TEXT = "mode A { domain x < 1 }\nmode B { domain x < 1 }\n"
SOURCES = {"m.ha": Source.of_text("m.ha", TEXT)}
TODAY = date(2030, 1, 2)

IN_A, IN_B = Span("m.ha", 9, 21), Span("m.ha", 33, 45)
LOCK = Diagnostic("HA303", "mode A: time-lock", IN_A)
AGAIN = Diagnostic("HA303", "mode A: time-lock", IN_B)
MODE_A = Span("m.ha", 0, 23)


def entry(**changes: object) -> FindingEntry:
    values = {"spec": "m.ha", "code": "HA303", "key": "mode A: time-lock", "text": "domain x < 1", "reason": "known"}
    return FindingEntry(**{**values, **changes})  # type: ignore[arg-type]


def test_an_entry_accepts_its_finding_wherever_the_line_has_moved() -> None:
    assert accept([AGAIN], [entry()], SOURCES, TODAY) == {AGAIN: "known"}


def test_an_entry_accepts_one_finding_only() -> None:
    assert list(accept([LOCK, AGAIN], [entry()], SOURCES, TODAY)) == [LOCK]


def test_another_text_message_or_code_is_a_new_finding() -> None:
    for other in (entry(text="domain x < 2"), entry(key="mode C"), entry(code="HA304"), entry(reason="")):
        assert accept([LOCK], [other], SOURCES, TODAY) == {}


def test_an_acceptance_ends() -> None:
    assert accept([LOCK], [entry(expires=date(2030, 1, 2))], SOURCES, TODAY) == {LOCK: "known"}
    over = entry(expires=date(2030, 1, 1))
    assert accept([LOCK], [over], SOURCES, TODAY) == {}
    assert [d.code for d in stale(Baseline((over,)), [LOCK], set(), SOURCES, TODAY)] == ["HA801"]


def test_what_has_no_meaning_is_never_accepted() -> None:
    lost = Diagnostic("HA002", "mode A: time-lock", IN_A)
    assert accept([lost], [entry(code="HA002")], SOURCES, TODAY) == {}
    assert allow([lost], [Allowed("HA002", "because", MODE_A, MODE_A)]) == {}


def test_entries_that_match_nothing_are_stale() -> None:
    record = Baseline(
        (entry(), entry()), (RefutedEntry("m.ha", "gone", (), "r"), RefutedEntry("m.ha", "there", (), "r"))
    )
    messages = [d.message for d in stale(record, [LOCK], {"there"}, SOURCES, TODAY)]
    assert messages == [
        "haverify.lock: HA303 in m.ha no longer occurs; remove the entry",
        "haverify.lock: no claim `gone` with `expect refuted` in m.ha; remove the entry",
    ]


def test_allow_covers_its_declaration_and_nothing_else() -> None:
    assert allow([LOCK, AGAIN], [Allowed("HA303", "meant", MODE_A, MODE_A)]) == {LOCK: "meant"}


def test_allow_covers_a_table_cell_through_a_label() -> None:
    cell = Diagnostic("HA212", "leaves", Span("t.csv", 3, 5), labels=(Label(IN_A),))
    assert allow([cell], [Allowed("HA212", "meant", MODE_A, MODE_A)]) == {cell: "meant"}


def test_allow_without_reason_accepts_nothing_and_is_reported() -> None:
    bare = Allowed("HA303", None, MODE_A, MODE_A)
    assert allow([LOCK], [bare]) == {}
    assert [d.message for d in about([bare], [LOCK])] == [
        '@allow(HA303) needs reason = "..."; without one it accepts nothing'
    ]


def test_allow_that_covers_nothing_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haverify.report.allow.pages", lambda: ["HA303"])
    assert [d.code for d in about([Allowed("HA303", "r", MODE_A, MODE_A)], [AGAIN])] == ["HA802"]
    assert [d.code for d in about([Allowed("HA999", "r", MODE_A, MODE_A)], [])] == ["HA802"]
