"""Paths of a posed model: their distances, and what is said where OpenSim or the model is missing."""

import sys
from pathlib import Path

import numpy as np
import pytest

from haverify.cli import main
from haverify.fitting.posed import BODY, HEELS, apart

ROOT = Path(__file__).parents[3]
WALKS = [str(ROOT / "models/walks/normal_gait.mot"), str(ROOT / "spec/gait.ha")]


def test_paths_are_told_apart_in_mm_forward_and_up() -> None:
    still = {name: np.zeros((4, 3)) for name in (*HEELS, BODY)}
    moved = {**still, "left heel": np.array([[0.003, 0.004, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0.012]])}
    lines = apart("b", "a", "M", still, moved).splitlines()
    assert lines[0] == "paths of b from those of a, M posed with both, its pelvis at rest, mm:"
    assert lines[2].split() == ["left", "heel", "6.5", "12.0", "1.5", "2.0"]
    assert lines[4].split()[-4:] == ["0.0"] * 4


def test_without_opensim_the_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "opensim", None)
    code = main(["compare", *WALKS, "--osim", "models/gait2354/gait2354.osim"])
    assert code == 2
    assert "pip install 'haverify[opensim]'" in capsys.readouterr().err
