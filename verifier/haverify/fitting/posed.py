"""A walk on a model of OpenSim (extra `opensim`): where its heels and its centre of mass go over the cycle.

The model's hips, knees and ankles follow the walk; every other coordinate keeps the model's default, so the pelvis
rests and the paths are those that a treadmill would show.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from haverify.errors import UsageError
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

COORDINATES = {
    f"{side}{letter}": f"{name}_{side}"
    for side in "lr"
    for letter, name in (("h", "hip_flexion"), ("k", "knee_angle"), ("a", "ankle_angle"))
}
HEELS = {"left heel": "calcn_l", "right heel": "calcn_r"}
BODY = "centre of mass"


@record
class Model:
    """A model of OpenSim in its default posture, what it is called, and which of its knees bend to positive angles."""

    name: str
    model: Any
    state: Any
    turned: frozenset[str]


def opened(path: str) -> Model:
    """The model in a file.

    Raises
    ------
    UsageError      if OpenSim is missing, or the file is no model with the legs of gait2354
    """
    try:
        import opensim
    except ImportError as e:
        raise UsageError(f"{path}: posing a model needs OpenSim: pip install 'haverify[opensim]'") from e
    if not Path(path).is_file():
        raise UsageError(f"cannot read {path}: there is no such file")
    opensim.Logger.removeFileSink()
    opensim.Logger.setLevelString("error")
    try:
        model = opensim.Model(path)
        state = model.initSystem()
    except RuntimeError as e:
        raise UsageError(f"{path}: OpenSim cannot read it as a model: {str(e).strip().splitlines()[0]}") from e
    known = {c.getName() for c in model.getCoordinateSet()}
    bodies = {b.getName() for b in model.getBodySet()}
    absent = [n for n in COORDINATES.values() if n not in known] + [n for n in HEELS.values() if n not in bodies]
    if absent:
        raise UsageError(f"{path}: a model with {absent[0]} is needed, as gait2354 has it")
    knees = {n: model.getCoordinateSet().get(n) for j, n in COORDINATES.items() if j[1] == "k"}
    turned = frozenset(n for n, c in knees.items() if c.getRangeMin() + c.getRangeMax() > 0)
    return Model(model.getName(), model, state, turned)


def paths(m: Model, angles: Mapping[str, Sequence[float]]) -> dict[str, Array]:
    """Paths (n, 3) in m (forward, up, to the right) of the heels and the centre of mass, of joint angles in deg."""
    import numpy as np

    coordinates, bodies = m.model.getCoordinateSet(), m.model.getBodySet()
    found: dict[str, list[Array]] = {name: [] for name in (*HEELS, BODY)}
    for k in range(len(angles["lh"])):
        for joint, name in COORDINATES.items():
            angle = np.radians(angles[joint][k]) * (-1 if name in m.turned else 1)
            coordinates.get(name).setValue(m.state, float(angle), False)
        m.model.realizePosition(m.state)
        for what, body in HEELS.items():
            found[what].append(bodies.get(body).getPositionInGround(m.state).to_numpy())
        found[BODY].append(m.model.calcMassCenterPosition(m.state).to_numpy())
    return {name: np.array(points) for name, points in found.items()}


def apart(name: str, of: str, model: str, first: Mapping[str, Array], other: Mapping[str, Array]) -> str:
    """How far the paths of one walk are from those of another, to read: distance, forward and up."""
    import numpy as np

    lines = [f"paths of {name} from those of {of}, {model} posed with both, its pelvis at rest, mm:"]
    lines.append("point               rms    peak   forward rms    up rms")
    for what, path in first.items():
        off = 1000 * (other[what] - path)
        far = np.sqrt((off**2).sum(axis=1))
        rms = [float(np.sqrt((d**2).mean())) for d in (far, off[:, 0], off[:, 1])]
        lines.append(f"{what:<16} {rms[0]:>6.1f} {float(far.max()):>7.1f} {rms[1]:>13.1f} {rms[2]:>9.1f}")
    return "\n".join(lines) + "\n"
