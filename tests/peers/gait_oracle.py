"""Exact extremes of the gait tables, computed without haverify.

Reads the coefficient tables of `spec/coeffs` and writes `gait_ranges.json`: for every table, joint and phase the
range of the angle and of its first two derivatives over the phase's slot, and the jump of the angle at every edge.

    python tests/peers/gait_oracle.py            rewrite gait_ranges.json
    python tests/peers/gait_oracle.py --check    exit 1 unless gait_ranges.json is what this script computes
"""

import csv
import json
import sys
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import mpmath

HERE = Path(__file__).parent
COEFFS = HERE.parent.parent / "spec" / "coeffs"
RANGES = HERE / "gait_ranges.json"
JOINTS = ("left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle")
PHASES = ("LR", "MST", "TS", "PS", "IS", "MSW", "TSW")
EDGES = tuple(Fraction(t) for t in ("0.4", "0.5", "0.733", "0.9833", "1.1167", "1.2667", "1.4333", "1.6"))
mpmath.mp.dps = 60


def polynomials(path):
    """Coefficients, highest power first, error added to the constant, by phase."""
    with path.open(newline="") as file:
        rows = {row.pop("phase"): row for row in csv.DictReader(file)}
    return {phase: polynomial(rows[phase]) for phase in PHASES}


def polynomial(row):
    coefficients = [Fraction(text) for name, text in row.items() if name != "error" and text != ""]
    return [*coefficients[:-1], coefficients[-1] + Fraction(row["error"])]


def derivative(p):
    return [c * (len(p) - 1 - i) for i, c in enumerate(p[:-1])]


def value(p, x):
    """The polynomial at `x` by Horner's rule, in the arithmetic of `x`."""
    result = x * 0
    for c in p:
        result = result * x + (c if isinstance(x, Fraction) else mpmath.mpf(c.numerator) / c.denominator)
    return result


def critical_points(p, low, high):
    """The real zeros of the derivative strictly between `low` and `high`, to about 50 digits."""
    slope = derivative(p)
    if len(slope) < 2:
        return []
    numbers = [mpmath.mpf(c.numerator) / c.denominator for c in slope]
    zeros = mpmath.polyroots(numbers, maxsteps=500, extraprec=500)
    real = [z.real for z in zeros if abs(z.imag) < mpmath.mpf(10) ** -40]
    return [x for x in real if low.numerator < x * low.denominator and x * high.denominator < high.numerator]


def extremes(p, low, high):
    """Least and greatest value on [low, high] and where: the ends exactly, inner points to 50 digits."""
    ends = [
        (mpmath.mpf(y.numerator) / y.denominator, mpmath.mpf(x.numerator) / x.denominator)
        for x in (low, high)
        for y in [value(p, x)]
    ]
    points = ends + [(value(p, x), x) for x in critical_points(p, low, high)]
    least, greatest = min(points), max(points)
    values = {"min": least[0], "argmin": least[1], "max": greatest[0], "argmax": greatest[1]}
    return {name: digits(number) for name, number in values.items()}


def digits(number):
    """Six decimals, rounded to nearest."""
    scaled = int(mpmath.nint(number * 10**6))
    sign = "-" if scaled < 0 else ""
    return f"{sign}{abs(scaled) // 10**6}.{abs(scaled) % 10**6:06d}"


def joint_ranges(path):
    """Per phase the ranges of angle (deg), velocity (deg/s), acceleration (deg/s^2); per edge the jump (deg)."""
    polys = polynomials(path)
    slots = dict(zip(PHASES, pairwise(EDGES), strict=True))
    phases = {}
    for phase, (low, high) in slots.items():
        p = polys[phase]
        phases[phase] = {
            "angle": extremes(p, low, high),
            "velocity": extremes(derivative(p), low, high),
            "acceleration": extremes(derivative(derivative(p)), low, high),
        }
    jumps = {}
    for phase, following in zip(PHASES, PHASES[1:] + PHASES[:1], strict=True):
        jump = value(polys[following], slots[following][0]) - value(polys[phase], slots[phase][1])
        jumps[f"{phase} -> {following}"] = digits(mpmath.mpf(jump.numerator) / jump.denominator)
    return {"phases": phases, "jumps": jumps}


def compute():
    folders = {"printed": COEFFS / "printed", "corrected": COEFFS}
    return {
        name: {joint: joint_ranges(folder / f"{joint}.csv") for joint in JOINTS} for name, folder in folders.items()
    }


def main(arguments):
    text = json.dumps(compute(), indent=1) + "\n"
    if arguments == ["--check"]:
        return 0 if RANGES.read_text() == text else 1
    RANGES.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
