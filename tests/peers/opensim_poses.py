"""Gait2354 posed through OpenSim: `python opensim_poses.py MODEL.osim`, with haverify on the path.

Runs in an environment of its own (`make test-opensim`). What a joint does to a heel is known from how legs are built.
"""

from __future__ import annotations

import sys
from math import dist, isclose

from haverify.fitting.posed import apart, opened, paths

JOINTS = ("lh", "rh", "lk", "rk", "la", "ra")


def main() -> int:
    model = opened(sys.argv[1])
    rest = {j: [0.0] for j in JOINTS}

    def heel(side: str, joint: str, angle: float) -> list[float]:
        found = paths(model, {**rest, joint: [angle]})
        return [float(x) for x in found[f"{side} heel"][0]]

    for side, letter in (("left", "l"), ("right", "r")):
        straight = heel(side, f"{letter}h", 0.0)
        flexed, bent, up = (heel(side, f"{letter}{j}", a) for j, a in (("h", 30.0), ("k", -60.0), ("a", 20.0)))
        assert flexed[0] - straight[0] > 0.35 and flexed[1] > straight[1], "a flexed hip brings the heel forward"
        assert bent[0] - straight[0] < -0.3 and bent[1] - straight[1] > 0.15, "a bent knee brings it back and up"
        assert abs(up[0] - straight[0]) < 0.05, "a flexed ankle turns the foot about the ankle near the heel"
        assert isclose(dist(flexed, straight), dist(heel(side, f"{letter}h", -30.0), straight), rel_tol=1e-9)
    same = paths(model, rest)
    assert " 0.0 " in apart("a", "a", model.name, same, same)
    print(f"{model.name} is posed by hips, knees and ankles with the signs of the gait")
    return 0


if __name__ == "__main__":
    sys.exit(main())
