"""The robot as bodies in a scene: where they are, and what is said where MeshCat is missing."""

import sys

import numpy as np
import pytest
from tests.unit.robot.scene import ROOT, cycle, engine, gait_map, robot

from haverify.cli import main
from haverify.robot.poses import poses
from haverify.robot.trajectory import sampled


def test_the_stance_sole_lies_on_the_ground_and_bodies_keep_their_shape():
    t = sampled(cycle(), gait_map("gait_mended.toml"), robot().robot, 100)
    found = poses(engine(), robot(), t, 9)
    assert len(found.solids) == 17 and found.placed.shape == (9, 17, 4, 4)
    assert found.times[0] == 0 and found.times == sorted(found.times)
    turns = found.placed[:, :, :3, :3]
    assert np.allclose(turns @ turns.swapaxes(2, 3), np.eye(3))
    soles = {side: next(k for k, s in enumerate(found.solids) if s.link == link) for side, link in robot().feet.items()}
    for row, time in zip(found.placed, found.times, strict=True):
        side = t.stance[int(np.argmin(np.abs(t.times - t.times[0] - time)))]
        k = soles[side]
        assert np.allclose(row[k, :3, :3], np.eye(3))
        assert row[k, 2, 3] == pytest.approx(float(found.solids[k].shape.size[2]), abs=1e-9)


def test_without_meshcat_the_extra_is_named_before_anything_is_done(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "meshcat", None)
    monkeypatch.chdir(ROOT)
    assert main(["replay", "spec/gait.ha", "--robot", "models/hoap2", "--no-report", "--meshcat", "view.html"]) == 2
    assert "pip install 'haverify[meshcat]'" in capsys.readouterr().err
