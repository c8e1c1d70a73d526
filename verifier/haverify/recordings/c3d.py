"""`.c3d` files through the library ezc3d (extra `c3d`), which reads from a path."""

from __future__ import annotations

from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.errors import UsageError
from haverify.recordings.planar import Markers, angles_of
from haverify.recordings.points import points_of
from haverify.recordings.recording import Recording
from haverify.recordings.trc import vertical
from haverify.text.span import Span

_METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0}


def c3d(path: str, sha256: str) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording in a file of markers; coordinates that are exactly 0 are missing."""
    import numpy as np

    try:
        import ezc3d
    except ImportError as e:
        raise UsageError(f"{path}: reading .c3d needs the library ezc3d: pip install 'haverify[c3d]'") from e
    top = Span(path, 0, 0)
    try:
        file = ezc3d.c3d(path)
        point = file["parameters"]["POINT"]
        unit, rate = str(point["UNITS"]["value"][0]), float(point["RATE"]["value"][0])
        labels, cells = list(point["LABELS"]["value"]), file["data"]["points"][:3]
    except (OSError, RuntimeError, ValueError, KeyError, IndexError) as e:
        return None, [Diagnostic("HA210", f"{path}: no readable .c3d file: {' '.join(str(e).split())[:160]}", None)]
    if unit not in _METRES or not rate > 0:
        return None, [Diagnostic("HA210", f"{path}: points in `{unit}` at {rate} Hz; mm, cm or m are known", None)]
    cells = np.where((cells == 0).all(axis=0), np.nan, cells) * _METRES[unit]
    points, missing = points_of({n: cells[:, k].T for k, n in enumerate(labels)})
    if missing:
        notes = (f"markers: {', '.join(labels)}",)
        return None, [Diagnostic("HA224", f"{path}: no marker for {', '.join(missing)}", None, notes=notes)]
    first = int(file["header"]["points"]["first_frame"])
    step = 1 / Fraction(rate).limit_denominator(1000)
    times = tuple(Fraction(round((first + k) * step * 1_000_000), 1_000_000) for k in range(cells.shape[2]))
    return angles_of(Markers(path, sha256, times, points, vertical(dict(points)), top, {}))
