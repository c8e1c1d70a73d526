"""The page docs/gait_refit.md, made from the recording and the printed tables.

`python -m tests.refit_page` prints it; `tests/test_refit_page.py` compares it with what is committed.
"""

import csv
from fractions import Fraction as Q
from pathlib import Path

from haverify.fitting.refit import Row, refit
from haverify.recordings.read import read
from haverify.recordings.recording import told
from haverify.text.source import Source

ROOT = Path(__file__).parents[1]
RECORDING = ROOT / "models" / "walks" / "subject01_walk1_ik.mot"
PRINTED = ROOT / "spec" / "coeffs" / "printed"
PHASES = ("LR", "MST", "TS", "PS", "IS", "MSW", "TSW")
WINDOWS = {
    "LR": (0, 6),
    "MST": (7, 20),
    "TS": (22, 35),
    "PS": (37, 43),
    "IS": (44, 52),
    "MSW": (53, 62),
    "TSW": (64, 72),
}
TABLES = {"lh": "5.1", "rh": "5.2", "lk": "5.3", "rk": "5.4", "la": "5.5", "ra": "5.6"}

HEAD = """\
# Where the gait tables come from, cell by cell

Tables 5.1 to 5.6 of V. B. Semwal, "Data Driven Computational Model for Bipedal Walking and Push Recovery", IIIT
Allahabad, 2016, have 42 cells: a polynomial for each of six joints and seven phases. Each is refitted here as the
tables were made: least squares in raw time through the samples of its window, every row by itself, no continuity, the
printed degree; exactly, in rationals. The recording is `models/walks/subject01_walk1_ik.mot`, 73 samples at 60 Hz.
This page is made by `tests/refit_page.py`, and a test makes it again.

*Furthest* is the largest distance of a refitted coefficient from the printed one, in units of the last of its four
printed digits: up to 0.5 is what rounding gives. *Error* is the constant printed beside the coefficients; *needed* is
the mean distance of the samples from the printed polynomial, in degrees, which such a constant has to make up for.

"""


def rows() -> dict[tuple[str, str], Row]:
    """All 42 cells, refitted."""
    recording = read(Source.of_text(RECORDING.name, RECORDING.read_text(encoding="utf-8"))).recording
    assert recording is not None
    found = {}
    for joint in TABLES:
        name = told(joint).replace(" ", "_")
        with (PRINTED / f"{name}.csv").open(encoding="utf-8") as file:
            printed = {row["phase"]: row for row in csv.DictReader(file)}
        for phase, (first, last) in WINDOWS.items():
            row = printed[phase]
            cells = [Q(row[p]) for p in ("p1", "p2", "p3", "p4", "p5") if row.get(p)]
            angles = [a for a in recording.angles[joint][first : last + 1] if a is not None]
            found[joint, phase] = refit(recording.times[first : last + 1], angles, cells, Q(row["error"]))
    return found


def page() -> str:
    """The page, as committed."""
    cells = rows()
    parts = [HEAD, _summary(cells)]
    for joint, table in TABLES.items():
        parts.append(f"## Table {table}: {told(joint)}\n\n")
        parts.append("| phase | samples | degree | furthest | error | needed | |\n|---|---|---|---|---|---|---|\n")
        parts += [_line(phase, cells[joint, phase]) for phase in PHASES]
        parts.append("\n")
    return "".join(parts).rstrip("\n") + "\n"


def _summary(cells: dict[tuple[str, str], Row]) -> str:
    every = [c for row in cells.values() for c in row.coefficients]
    within = sum(abs(c.units) <= Q(1, 2) for c in every)
    signs = [(j, p, i) for (j, p), row in cells.items() for i, c in enumerate(row.coefficients) if c.has_other_sign]
    lines = [
        f"Of {len(every)} coefficients in {len(cells)} cells, {within} are the refitted ones rounded to four digits, "
        f"{sum(c.agrees for c in every) - within} differ by up to one unit of the last digit,",
        f"{len(signs)} have the other sign, and {sum(not c.agrees and not c.has_other_sign for c in every)} differ "
        "otherwise.",
        "",
        "Every difference between print and refit:",
        "",
        "| cell | printed | refitted |",
        "|---|---|---|",
    ]
    for j, p, i in signs:
        c = cells[j, p].coefficients[i]
        lines.append(f"| {told(j)}, {p}, p{i + 1} | {float(c.printed):.4g} | {float(c.refitted):.6g} |")
    for (j, p), row in cells.items():
        for i, c in enumerate(row.coefficients):
            if not c.has_other_sign and abs(c.units) > Q(1, 2):
                lines.append(f"| {told(j)}, {p}, p{i + 1} | {float(c.printed):.4g} | {float(c.refitted):.6g} |")
    far = [(j, p, row) for (j, p), row in cells.items() if abs(row.error - row.offset) > 1]
    lines += [
        f"| {told(j)}, {p}, error | {float(row.error):g} deg | {float(row.offset):.2f} deg needed |"
        for j, p, row in far
    ]
    return "\n".join(lines) + "\n\n"


def _line(phase: str, row: Row) -> str:
    first, last = WINDOWS[phase]
    furthest = max(abs(c.units) for c in row.coefficients if not c.has_other_sign)
    said = [f"p{i + 1}: sign" for i, c in enumerate(row.coefficients) if c.has_other_sign]
    said += ["error: -0.3 for -3 or -3.7"] if abs(row.error - row.offset) > 1 else []
    return (
        f"| {phase} | {first}-{last} | {len(row.coefficients) - 1} | {float(furthest):.2f} "
        f"| {float(row.error):g} | {float(row.offset):.2f} | {', '.join(said)} |\n"
    )


if __name__ == "__main__":
    print(page(), end="")
