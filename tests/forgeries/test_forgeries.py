"""Every damage to a true report folder is refused, whatever it damages."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from hacheck import rational
from hacheck.__main__ import main as hacheck
from haverify.cli import main as haverify

from tests.forgeries.damage import copy_of, damages

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
    seen = 0
    for name, forge in damages(truth):
        copy = copy_of(truth, tmp_path / "forged")
        forge(copy)
        assert verdict(copy, place) in (1, 2), name
        seen += 1
    assert seen > 600


@pytest.mark.parametrize("report", ["gait", "gait_printed"])
def test_a_damage_of_each_sort_to_the_gait_reports_is_refused(place: Path, tmp_path: Path, report: str) -> None:
    truth = place / "reports" / report
    sorts = {re.sub(r"\d+|^\S+ \S+ ", "#", name): (name, forge) for name, forge in damages(truth)}
    for name, forge in sorts.values():
        copy = copy_of(truth, tmp_path / "forged")
        forge(copy)
        assert verdict(copy, place) in (1, 2), name
    assert len(sorts) > 40
