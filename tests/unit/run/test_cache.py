"""The cache gives back what was kept, and nothing at all when it was touched."""

import json
from pathlib import Path

import pytest
from tests.unit.report.examples import PROVED, REFUTED, UNKNOWN, evidence, part

from haverify.evidence.evidence import Evidence
from haverify.run import cache, kept

KEYS = {"range": "k1"}


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))


def example() -> Evidence:
    found = evidence(REFUTED, part("PS", REFUTED), part("LR", PROVED), part("MST", UNKNOWN))
    return Evidence(found.verdict, found.parts, "m", {"c": ["1/3"]}, {"Gait": {"cells": [1]}}, run=found.run)


def bare(e: Evidence) -> object:
    from haverify.evidence.as_json import evidence_to

    return evidence_to(e)


def test_what_is_kept_comes_back() -> None:
    cache.keep("m", KEYS, {"range": example()})
    again = cache.fetch("m", KEYS)["range"]
    assert (bare(again), again.cells) == (bare(example()), example().cells)


def test_trust_is_not_kept() -> None:
    cache.keep("m", KEYS, {"range": example()})
    verdict = cache.fetch("m", KEYS)["range"].verdict
    assert verdict.trust is None  # type: ignore[union-attr]


def test_another_key_finds_nothing() -> None:
    cache.keep("m", KEYS, {"range": example()})
    assert cache.fetch("m", {"range": "k2"}) == {}
    assert cache.fetch("n", KEYS) == {}


def test_unknown_is_not_kept() -> None:
    cache.keep("m", KEYS, {"range": evidence(UNKNOWN)})
    assert cache.fetch("m", KEYS) == {}


@pytest.mark.parametrize("change", [b"proved", b"", b"{}", b"\xff\xfe"])
def test_a_damaged_file_finds_nothing(change: bytes) -> None:
    cache.keep("m", KEYS, {"range": example()})
    (path,) = kept.folder().glob("*.json")
    path.write_bytes(change + path.read_bytes().replace(b"refuted", b"proved") if change else b"")
    assert cache.fetch("m", KEYS) == {}


def test_an_entry_of_another_shape_finds_nothing() -> None:
    cache.keep("m", KEYS, {"range": example()})
    (path,) = kept.folder().glob("*.json")
    pack = json.loads(path.read_bytes().partition(b"\n")[2])
    pack["claims"]["k1"]["evidence"]["parts"] = [{}]
    kept.store(path.stem, pack)
    assert cache.fetch("m", KEYS) == {}


def test_a_cache_that_cannot_be_written_is_no_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "file" / "cache"))
    cache.keep("m", KEYS, {"range": example()})
    assert cache.fetch("m", KEYS) == {}
