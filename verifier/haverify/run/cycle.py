"""One cycle of an automaton as curves: its run from the start until it enters its first mode again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from haverify.errors import UsageError
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.recordings.recording import JOINTS

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

LONGEST = 10.0  # seconds of a cycle
_SAMPLES = 4000


def cycle(file: str, spec: Spec, name: str | None) -> tuple[dict[str, Array], list[float], float]:
    """The six joints at 0 .. 100 % of the cycle, the shares at which modes change, and its length in seconds.

    Params have their defaults.

    Raises
    ------
    UsageError      if there is no such automaton, or it does not come round within 10 s
    """
    import numpy as np

    from haverify.simulate.draws import Drawing
    from haverify.simulate.model import SimulatedAutomaton
    from haverify.simulate.run import Settings, followed

    model = SimulatedAutomaton(spec, _chosen(file, spec, name))
    run = followed(model, Drawing(model, LONGEST).nominal(), Settings(LONGEST, jumps=200))
    rows = run.rows([LONGEST * k / _SAMPLES for k in range(_SAMPLES + 1)])
    end = next((k for k in range(1, len(rows)) if rows[k][1] == rows[0][1] != rows[k - 1][1]), None)
    if end is None:
        raise UsageError(f"{file}: `{model.automaton.name}` does not come back to its first mode within {LONGEST:g} s")
    seconds = rows[end][0]
    places = {o.name: i for i, o in enumerate(model.outputs)}
    t = np.array([r[0] for r in rows[:end]])
    grid = np.linspace(0, seconds, 101)
    angles = {j: np.interp(grid, t, [r[4][places[j]] for r in rows[:end]]) for j in JOINTS}
    changes = [rows[k][0] / seconds for k in range(1, end) if rows[k][1] != rows[k - 1][1]]
    return angles, changes, seconds


def _chosen(file: str, spec: Spec, name: str | None) -> HybridAutomaton:
    """The automaton of that name, else the first that has all six joints as outputs."""
    fit = [a for a in spec.automata if all(j in _outputs(a) for j in JOINTS)]
    named = [a for a in fit if name in (None, a.name)]
    if not named:
        raise UsageError(
            f"{file}: no automaton with the outputs {', '.join(JOINTS)}" + (f" called `{name}`" if name else "")
        )
    return named[0]


def _outputs(a: HybridAutomaton) -> set[str]:
    return {o.name for o in (*a.lets, *(o for m in a.modes for o in m.lets))}
