"""Fixes applied to files."""

from pathlib import Path

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.run.fix import apply
from haverify.text.source import Source
from haverify.text.span import Span


def finding(path: Path, start: int, end: int, text: str, safe: bool = True) -> Diagnostic:
    return Diagnostic("HA102", "m", fix=Fix(f"write {text}", (Edit(Span(str(path), start, end), text),), safe))


def sources(path: Path, text: str) -> dict[str, Source]:
    return {str(path): Source.of_text(str(path), text)}


def test_safe_fixes_are_applied_and_others_wait_to_be_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "m.ha"
    path.write_text("sin(30) + cos(60)\n")
    found = [finding(path, 4, 6, "30 deg"), finding(path, 14, 16, "60 deg", safe=False)]
    assert apply(found, sources(path, "sin(30) + cos(60)\n"), unsafe=False) == ["HA102: write 30 deg"]
    assert path.read_text() == "sin(30 deg) + cos(60)\n"


def test_of_two_fixes_to_one_place_the_first_is_applied(tmp_path: Path) -> None:
    path = tmp_path / "m.ha"
    path.write_text("abcdef")
    apply([finding(path, 1, 4, "X"), finding(path, 3, 5, "Y")], sources(path, "abcdef"), unsafe=False)
    assert path.read_text() == "aXef"


def test_line_ends_and_byte_order_mark_stay(tmp_path: Path) -> None:
    path = tmp_path / "m.ha"
    path.write_bytes(b"\xef\xbb\xbfa\r\nb\r\n")
    apply([finding(path, 2, 3, "c")], sources(path, "a\nb\n"), unsafe=False)
    assert path.read_bytes() == b"\xef\xbb\xbfa\r\nc\r\n"


def test_a_file_that_changed_meanwhile_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "m.ha"
    path.write_text("new text")
    apply([finding(path, 0, 3, "X")], sources(path, "old text"), unsafe=False)
    assert path.read_text() == "new text"
