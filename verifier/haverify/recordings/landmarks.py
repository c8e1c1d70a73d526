"""JSON landmarks: frames with named points of both legs, a frame rate, and events annotated as frame numbers."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.planar import POINTS, Markers, angles_of
from haverify.recordings.recording import Events, Recording
from haverify.recordings.trc import vertical
from haverify.text.source import Source
from haverify.text.span import Span

_SIDES = {"l": "left", "r": "right"}


def landmarks(source: Source) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording in a file of landmarks, in millimetres or metres as the length of the thigh shows."""
    import numpy as np

    top = Span(source.path, 0, min(60, len(source.text)))
    try:
        data = json.loads(source.text)
    except json.JSONDecodeError as e:
        return None, [_unreadable(source, e)]
    except RecursionError:
        return None, [Diagnostic("HA210", "no file of landmarks: too deep", top)]
    try:
        rate = Fraction(str(data["fps"]))
        frames = [f["landmark_positions"] for f in data["angle_frames"]]
        points = {
            s + p: np.array([f[f"{side}_{p}"] for f in frames], dtype=float)
            for s, side in _SIDES.items()
            for p in POINTS
        }
    except (ValueError, KeyError, TypeError) as e:
        message = f"no file of landmarks (`fps`, `angle_frames` with `landmark_positions`): {type(e).__name__} {e}"[
            :200
        ]
        return None, [Diagnostic("HA210", message, top)]
    if rate <= 0 or not frames or any(v.ndim != 2 or v.shape[1] != 3 for v in points.values()):
        return None, [Diagnostic("HA210", "no frames of points in space", top)]
    for v in points.values():
        v[(v == 0).all(axis=1) | ~np.isfinite(v).all(axis=1)] = np.nan
    thigh = float(np.nanmedian(np.linalg.norm(points["lhip"] - points["lknee"], axis=1)))
    scale = 0.001 if thigh > 10 else 1.0
    metres = {k: v * scale for k, v in points.items()}
    times = tuple(Fraction(round(k / rate * 1_000_000), 1_000_000) for k in range(len(frames)))
    marked = _marked(data.get("ground_truth"), rate, len(frames))
    made, more = angles_of(Markers(source.path, source.sha256, times, metres, vertical(metres), top, marked))
    return made, [*_no_json(source), *more]


def _unreadable(source: Source, e: json.JSONDecodeError) -> Diagnostic:
    """Where the text is no JSON, and what stands there."""
    word = re.match(r"[A-Za-z_]+|\S?", source.text[e.pos :])
    said = word[0] if word else ""
    advice = {"True": "true", "False": "false", "None": "null"}.get(said)
    message = f"no JSON: {e.msg}" + (f", and here stands `{said}`" if said else ", and here the file ends")
    place = Span(source.path, e.pos, max(e.pos + len(said), min(e.pos + 1, len(source.text))))
    return Diagnostic("HA210", message, place, help=f"a word of Python: write `{advice}`" if advice else None)


def _no_json(source: Source) -> list[Diagnostic]:
    """A warning at the first NaN or infinity, which JSON does not have, but Python writes."""
    m = re.search(r"(?<![\w\"])-?(NaN|Infinity)\b", source.text)
    if m is None:
        return []
    message = f"`{m[0]}` is no JSON; such a coordinate counts as missing"
    return [Diagnostic("HA222", message, Span(source.path, m.start(), m.end()))]


def _marked(truth: Any, rate: Fraction, frames: int) -> dict[str, Events]:
    """The annotated events of both legs, as the file lists them."""
    if not isinstance(truth, Mapping):
        return {}
    marked = {}
    for s, side in _SIDES.items():
        times = []
        for kind in ("hs_frames", "to_frames"):
            listed = truth.get(kind)
            listed = listed.get(side) if isinstance(listed, Mapping) else None
            whole = (
                sorted({k for k in listed if isinstance(k, int) and 0 <= k < frames})
                if isinstance(listed, list)
                else []
            )
            times.append(tuple(Fraction(round(k / rate * 1_000_000), 1_000_000) for k in whole))
        marked[s] = Events(times[0], times[1], "annotated in the file")
    return marked
