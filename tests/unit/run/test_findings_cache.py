"""Findings of a text seen before come back as they were; of any other text, or a file touched, rules look anew."""

from pathlib import Path

import pytest

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label, Severity
from haverify.run import kept
from haverify.run.findings_cache import found_once
from haverify.text.source import Source
from haverify.text.span import Span

TEXT = "mode A { domain x < 1 }\n"
SPAN = Span("a.ha", 5, 6)
FOUND = [
    Diagnostic(
        "HA303",
        "time stops",
        SPAN,
        "here",
        (Label(SPAN, "and here"),),
        ("a note",),
        "include the bound",
        Fix("include it", (Edit(SPAN, "<="),), safe=True),
        "key",
        Severity.WARNING,
    ),
    Diagnostic("HA900", "nowhere", None),
]


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))


def looks(text: str, found: list[Diagnostic]) -> tuple[list[Diagnostic], int]:
    """What is found in a text, and how often it was looked at."""
    calls = []

    def look() -> list[Diagnostic]:
        calls.append(text)
        return found

    return found_once({"a.ha": Source.of_text("a.ha", text)}, look), len(calls)


def test_the_same_text_is_looked_at_once() -> None:
    assert looks(TEXT, FOUND) == (FOUND, 1)
    assert looks(TEXT, []) == (FOUND, 0)


def test_another_text_is_looked_at() -> None:
    looks(TEXT, FOUND)
    assert looks(TEXT + "\n", []) == ([], 1)


def test_no_finding_is_kept_as_well() -> None:
    looks(TEXT, [])
    assert looks(TEXT, FOUND) == ([], 0)


@pytest.mark.parametrize("change", ["[]", '{"schema":"haverify.findings/1","findings":[["HA303"]]}', "{}"])
def test_a_file_of_another_shape_finds_nothing(change: str) -> None:
    import json

    looks(TEXT, FOUND)
    (path,) = kept.folder().glob("findings/*.json")
    kept.store(path.stem, json.loads(change), "findings")
    assert looks(TEXT, []) == ([], 1)


def test_a_place_outside_the_text_finds_nothing() -> None:
    looks(TEXT, [Diagnostic("HA303", "m", Span("a.ha", 5, 1000))])
    assert looks(TEXT, []) == ([], 1)


def test_a_damaged_file_finds_nothing() -> None:
    looks(TEXT, FOUND)
    (path,) = kept.folder().glob("findings/*.json")
    path.write_bytes(path.read_bytes().replace(b"HA303", b"HA302"))
    assert looks(TEXT, []) == ([], 1)
