"""Every damage to a true report folder is refused, whatever it damages."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from tests.forgeries.damage import Forger, copy_of, damages
from tests.forgeries.selection import chosen, thin

from hacheck import rational
from hacheck.__main__ import main as hacheck
from haverify.analyses import clocked, goals
from haverify.cli import main as haverify

ROOT = Path(__file__).parents[2]
SMALL = Path(__file__).parent / "small"
WORK = rational.Meter.left


def verdict(folder: Path, base: Path) -> int:
    """What the checker says of a folder, with the work of a fresh process."""
    rational.Meter.left = WORK
    with redirect_stdout(StringIO()):
        return hacheck([str(folder), "--inputs", str(base)])


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A directory with the specs and true reports on them."""
    path = tmp_path_factory.mktemp("true")
    shutil.copytree(ROOT / "spec", path / "spec")
    shutil.copytree(SMALL, path / "small")
    shutil.copy(ROOT / "haverify.lock", path)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        patch.setenv("HAVERIFY_CACHE", str(path / "cache"))
        for spec in ("small/two_phase.ha", "spec/gait.ha", "spec/gait_printed.ha", "spec/limits.ha"):
            haverify(["check", spec])
        yield path


@pytest.mark.parametrize("report", ["two_phase", "gait", "gait_printed"])
def test_true_reports_are_accepted(place: Path, report: str) -> None:
    assert verdict(place / "reports" / report, place) == 0


def test_the_small_spec_has_every_kind_of_certificate(place: Path) -> None:
    text = "".join(f.read_text() for f in sorted((place / "reports/two_phase/certificates").rglob("*.json")))
    for word in ('"cells"', '"inevitable"', '"kind":"run"', '"stuck"', '"jump"', '"dwell"', '"rounding":{', '"meet"'):
        assert word in text, word


def test_every_damage_of_the_small_report_is_refused(place: Path, tmp_path: Path) -> None:
    truth = place / "reports" / "two_phase"
    forger, seen = Forger(truth, tmp_path / "forged"), 0
    for name, forge in damages(truth):
        assert verdict(forger.forged(forge), place) in (1, 2), name
        seen += 1
    assert seen > 1000
    assert verdict(forger.forged(lambda _: None), place) == 0


@pytest.mark.parametrize("report", ["gait", "gait_printed"])
def test_a_damage_of_each_sort_to_the_gait_reports_is_refused(place: Path, tmp_path: Path, report: str) -> None:
    truth = copy_of(place / "reports" / report, tmp_path / "thin")
    thin(truth)
    assert verdict(truth, place) == 0
    forger, forged = Forger(truth, tmp_path / "forged"), chosen(truth, 60)
    for name, forge in forged:
        assert verdict(forger.forged(forge), place) in (1, 2), name
    assert len(forged) >= 60
    assert verdict(forger.forged(lambda _: None), place) == 0


def said(place: Path, patch: pytest.MonkeyPatch, spec: str) -> tuple[int, dict[str, dict]]:
    """Exit code and claims, by name, of a check of a spec without the cache."""
    patch.chdir(place)
    rational.Meter.left = WORK
    code = haverify(["check", spec, "--no-cache", "--report", "patched"])
    claims = json.loads((place / "patched" / "report.json").read_text())["claims"]
    return code, {c["name"]: c for c in claims}


def without(mode: str, listed: Callable[..., Iterator]) -> Callable[..., Iterator]:
    """The generator without what is about a mode, which it gives by name or by position."""

    def some(*given):
        return (p for p in listed(*given) if p.mode != mode)

    return some


def test_a_part_that_the_prover_forgets_is_missed_by_the_checker(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(goals, "parts", without("PS", goals.parts))
    code, claims = said(place, monkeypatch, "spec/gait_printed.ha")
    assert code == 4
    assert claims["left_knee"]["verdict"] == "unknown"
    assert "parts are to be shown, the certificate has another number" in claims["left_knee"]["reason"]


def test_a_mode_that_the_prover_never_enters_is_missed_by_the_checker(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clocked, "landed", without(1, clocked.landed))
    code, claims = said(place, monkeypatch, "small/two_phase.ha")
    assert code == 4
    for name in ("step", "speed_limit", "no_lock", "wide"):
        assert claims[name]["verdict"] == "unknown"
        assert "mode Swing that are in no cell" in claims[name]["reason"]
    assert claims["range"]["verdict"] == "unknown"
