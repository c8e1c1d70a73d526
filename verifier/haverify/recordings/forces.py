"""Heel strike and toe-off from ground forces: the foot is down while the vertical force exceeds a threshold.

Source: the threshold of 20 N is the usual one for plates (e.g. J. A. Zeni, J. G. Richards, J. S. Higginson, Gait &
Posture 27, 2008, use it as reference).
"""

from __future__ import annotations

from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.columns import Columns, numbers
from haverify.recordings.labels import loads
from haverify.recordings.recording import Events, Forces

Q = Fraction

THRESHOLD = Q(20)  # newtons
_SHORTEST = Q(1, 20)  # seconds: a shorter change is noise


def forces(columns: Columns) -> tuple[Forces | None, list[Diagnostic]]:
    """The vertical forces under both feet, where the columns hold them."""
    at = loads(columns.labels)
    if len(at) != 2:
        return None, []
    times, found = numbers(columns, 0)
    vertical = {}
    for side, column in at.items():
        values, more = numbers(columns, column)
        vertical[side] = tuple(v or Q(0) for v in values)
        found += more
    if any(t is None for t in times) or found:
        return None, found
    return Forces(columns.source.path, tuple(t for t in times if t is not None), vertical), found


def contacts(forces: Forces, side: str) -> Events:
    """The strikes and offs of a foot: crossings of the threshold, each at the sample after it.

    A foot that is down when the plates begin, or still when they end, has no strike, or off, there. What lasts less
    than a twentieth of a second is not counted.
    """
    down = [f > THRESHOLD for f in forces.vertical[side]]
    runs: list[tuple[int, int, bool]] = []
    start = 0
    for k in range(1, len(down) + 1):
        if k == len(down) or down[k] != down[start]:
            if runs and forces.times[k - 1] - forces.times[start] < _SHORTEST:
                runs[-1] = (runs[-1][0], k, runs[-1][2])
            elif runs and runs[-1][2] == down[start]:
                runs[-1] = (runs[-1][0], k, down[start])
            else:
                runs.append((start, k, down[start]))
            start = k
    strikes = tuple(forces.times[a] for a, _, is_down in runs if is_down and a > 0)
    offs = tuple(forces.times[b] for _, b, is_down in runs if is_down and b < len(down))
    return Events(strikes, offs, f"ground force above {THRESHOLD} N")
