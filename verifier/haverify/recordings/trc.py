"""`.trc` files: markers over time, three columns each, lengths in the unit the header names."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.maths.exact import parse_decimal
from haverify.recordings.planar import Markers, angles_of
from haverify.recordings.points import points_of
from haverify.recordings.recording import Recording
from haverify.text.source import Source
from haverify.text.span import Span

_METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0}


def trc(source: Source) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording in a marker file; the vertical axis is the one along which hips are farthest above ankles."""
    import numpy as np

    lines = source.text.split("\n")
    head = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=False)) if len(lines) > 4 else {}
    names = lines[3].rstrip().split("\t")[2::3] if len(lines) > 4 else []
    unit = head.get("Units", "").strip()
    top = Span(source.path, 0, sum(len(x) + 1 for x in lines[:4]))
    if unit not in _METRES or not names:
        return None, [Diagnostic("HA210", "no header of a .trc file with Units mm, cm or m", top)]
    times, rows, places, found = _rows(source, lines, 3 * len(names))
    if not rows or found:
        return None, found or [Diagnostic("HA210", "no rows of numbers", top)]
    cells = np.array(rows).reshape(len(rows), -1, 3) * _METRES[unit]
    cells[(cells == 0).all(axis=2)] = np.nan  # a marker exactly at the origin is a missing one
    points, missing = points_of({n.strip(): cells[:, k] for k, n in enumerate(names)})
    if missing:
        return None, [
            Diagnostic("HA224", f"no marker for {', '.join(missing)}", top, notes=(f"markers: {', '.join(names)}",))
        ]
    made, more = angles_of(Markers(source.path, source.sha256, times, points, vertical(points), top, {}, places))
    stated = head.get("NumFrames", "").strip()
    if stated.isdigit() and int(stated) != len(rows):
        more.insert(0, Diagnostic("HA221", f"the header says {stated} frames, but {len(rows)} follow", top))
    return made, more


def vertical(points: Mapping[str, object]) -> int:
    """The axis along which hips are farthest from ankles; any, where no frame shows both."""
    import numpy as np

    between = np.asarray(points["lhip"]) - np.asarray(points["lankle"])
    apart = np.nansum(between, axis=0)
    return int(np.argmax(np.abs(apart)))


def _rows(
    source: Source, lines: list[str], width: int
) -> tuple[tuple[Fraction, ...], list[list[float]], tuple[Span, ...], list[Diagnostic]]:
    """Times and coordinates, NaN where a cell is empty; and where the rows are."""
    times, rows, places, found = list[Fraction](), list[list[float]](), list[Span](), list[Diagnostic]()
    at = sum(len(x) + 1 for x in lines[:5])
    for line in lines[5:]:
        cells = line.split("\t")
        if len(cells) > 2 and cells[0].strip():
            t = parse_decimal(cells[1])
            try:
                values = [float(c) if c.strip() else float("nan") for c in cells[2 : 2 + width]]
            except ValueError:
                values = []
            if t is None or not values:
                found.append(
                    Diagnostic("HA210", "a cell of this row is no number", Span(source.path, at, at + len(line)))
                )
            else:
                if times and t <= times[-1]:
                    message = f"time does not increase: {cells[1].strip()} s"
                    found.append(Diagnostic("HA210", message, Span(source.path, at, at + len(line))))
                times.append(t)
                places.append(Span(source.path, at, at + len(line)))
                rows.append(values + [float("nan")] * (width - len(values)))
        at += len(line) + 1
    return _even(times), rows, tuple(places), found[:5]


def _even(times: list[Fraction]) -> tuple[Fraction, ...]:
    """The instants; where the file rounds them to milliseconds so that they are uneven, evenly spaced ones."""
    n = len(times)
    if n < 3:
        return tuple(times)
    step = (times[-1] - times[0]) / (n - 1)
    even = [times[0] + k * step for k in range(n)]
    if max(abs(a - b) for a, b in zip(times, even, strict=True)) <= Fraction(1, 1000):
        return tuple(Fraction(round(t * 1_000_000), 1_000_000) for t in even)
    return tuple(times)
