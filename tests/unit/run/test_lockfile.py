"""`haverify.lock` on disk."""

from datetime import date
from pathlib import Path

import pytest

from haverify.errors import UsageError
from haverify.report.baseline import Baseline, FindingEntry, RefutedEntry
from haverify.run import lockfile

ENTRIES = Baseline(
    (
        FindingEntry("spec/b.ha", "HA303", 'mode "TSW"', "domain x < 1.6 s\n\t\x7f", "as printed", date(2031, 5, 1)),
        FindingEntry("spec/a.ha", "HA213", "k", "t", "r"),
    ),
    (RefutedEntry("spec/a.ha", "knee_range", ("Gait / PS / lk", "Gait / LR -> MST / lk"), "sign lost in print"),),
)


def without_places(b: Baseline) -> tuple[set[tuple[object, ...]], set[tuple[object, ...]]]:
    findings = {(e.spec, e.code, e.key, e.text, e.reason, e.expires) for e in b.findings}
    return findings, {(e.spec, e.claim, e.parts, e.reason) for e in b.refuted}


def test_reading_gives_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "haverify.lock"
    lockfile.write(path, ENTRIES)
    again, source = lockfile.read(path)
    assert without_places(again) == without_places(ENTRIES)
    assert lockfile.written(again) == path.read_text(encoding="utf-8")
    assert source.at(again.findings[0].span).startswith('[[finding]]\nspec = "spec/a.ha"')  # type: ignore[arg-type]


def test_order_of_entries_does_not_matter() -> None:
    turned = Baseline(ENTRIES.findings[::-1], ENTRIES.refuted)
    assert lockfile.written(turned) == lockfile.written(ENTRIES)


def test_the_nearest_lock_is_beside_or_above(tmp_path: Path) -> None:
    deep = tmp_path / "a" / "b"
    deep.mkdir(parents=True)
    (tmp_path / "haverify.lock").write_text("version = 1\n")
    assert lockfile.nearest(deep / "m.ha") == tmp_path / "haverify.lock"
    (deep / "haverify.lock").write_text("version = 1\n")
    assert lockfile.nearest(deep / "m.ha") == deep / "haverify.lock"
    assert lockfile.name_in(tmp_path / "haverify.lock", deep / "m.ha") == "a/b/m.ha"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "version = 2\n",
        "version = 1\nnews = 3\n",
        "version = 1\n[[finding]]\nspec = 1\n",
        'version = 1\n[[finding]]\nspec = "a"\ncode = "HA303"\nkey = "k"\ntext = "t"\nreason = "r"\nexpires = "soon"\n',
        'version = 1\n[[refuted]]\nspec = "a"\nclaim = "c"\nreason = "r"\nparts = "all"\n',
        "version = 1\nfinding = 3\n",
        "\x00",
    ],
)
def test_anything_else_is_no_lock_file(tmp_path: Path, text: str) -> None:
    path = tmp_path / "haverify.lock"
    path.write_text(text)
    with pytest.raises(UsageError):
        lockfile.read(path)


def test_the_quick_way_reads_what_the_parser_reads() -> None:
    text = lockfile.written(ENTRIES)
    assert lockfile._as_written("haverify.lock", text) is None  # a date is left to the parser
    parts = ("Impact / r in [-2, 1] / -", "] = [", "Gait / PS / lk")
    plain = Baseline(ENTRIES.findings[1:], (*ENTRIES.refuted, RefutedEntry("spec/a.ha", "hip", parts, "as printed")))
    text = lockfile.written(plain)
    assert lockfile._as_written("haverify.lock", text) == lockfile._parsed("haverify.lock", text)
    head, *blocks = text.split("\n[[")
    text = "\n[[".join([head, *reversed(blocks)])
    assert lockfile._as_written("haverify.lock", text) == lockfile._parsed("haverify.lock", text)


@pytest.mark.parametrize(
    ("old", "new"),
    [('"t"', '"t" # a note'), ('"t"', "'t'"), ('"r"\n', '"r"\nreason = "again"\n'), ('"a.ha"', '"\\/a.ha"')],
)
def test_the_quick_way_is_not_taken_where_the_text_is_another(tmp_path: Path, old: str, new: str) -> None:
    text = lockfile.written(Baseline((FindingEntry("a.ha", "HA213", "k", "t", "r"),), ())).replace(old, new)
    assert lockfile._as_written("haverify.lock", text) is None
    path = tmp_path / "haverify.lock"
    path.write_text(text)
    if new in ('"t" # a note', "'t'"):
        assert lockfile.read(path)[0].findings[0].text == "t"
    else:
        with pytest.raises(UsageError):
            lockfile.read(path)
