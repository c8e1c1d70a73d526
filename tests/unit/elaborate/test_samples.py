"""Every sample and every spec elaborates, and its expansion has the same core."""

from pathlib import Path

import pytest

from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.expand import expand
from haverify.model.core import canonical, to_core
from haverify.model.spec import Spec
from haverify.run.load import load

ROOT = Path(__file__).parents[3]
SPECS = sorted([*(ROOT / "tests" / "samples").glob("*.ha"), *(ROOT / "spec").glob("*.ha")])
WARNINGS = {"HA005", "HA107", "HA215"}
OUTDATED = {"cruise.ha", "gait.ha"}  # their sha256 lines hold "0000"


def elaborated(path: Path) -> tuple[Spec, set[str]]:
    loaded, found = load(path)
    assert loaded is not None
    spec, more = elaborate(loaded.tree, loaded.files)
    assert spec is not None
    return spec, {d.code for d in [*found, *more]}


def core(spec: Spec) -> bytes:
    return canonical({k: v for k, v in to_core(spec).items() if k != "cells"})


@pytest.mark.parametrize("path", SPECS, ids=lambda p: f"{p.parent.name}-{p.stem}")
def test_elaborates_and_expands(path: Path, tmp_path: Path) -> None:
    spec, codes = elaborated(path)
    assert codes <= WARNINGS
    assert spec.lost == ()
    for folder in ("data", "nets"):
        if (path.parent / folder).is_dir():
            (tmp_path / folder).symlink_to(path.parent / folder)
    again = tmp_path / path.name
    again.write_text(expand(spec), encoding="utf-8")
    expanded, codes = elaborated(again)
    assert codes <= WARNINGS
    assert core(expanded) == core(spec)
    assert expand(expanded) == expand(spec)


def test_samples_with_outdated_hashes_say_so() -> None:
    samples = [p for p in SPECS if p.parent.name == "samples"]
    assert {p.name for p in samples if "HA215" in elaborated(p)[1]} == OUTDATED
