"""A fitted walk as a spec with its tables: names of files to their texts."""

from __future__ import annotations

import hashlib
import textwrap
from collections.abc import Sequence

from haverify.fitting import tables
from haverify.fitting.bands import coverage, csv
from haverify.fitting.claims import claims
from haverify.fitting.curve import Curve, Residual, farthest
from haverify.fitting.walk import Walk
from haverify.recordings.cycles import Cycle
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import JOINTS, told
from haverify.syntax import format as layout
from haverify.syntax.parse import parse
from haverify.text.source import Source

LEGS = {"l": "left", "r": "right"}


def emit(walk: Walk, stem: str) -> dict[str, str]:
    """`<stem>.ha` and the tables in `<stem>/` beside it; the same walk gives the same bytes."""
    files = {f"{stem}/phases.csv": tables.phases(walk.knots)}
    files |= {f"{stem}/{c.joint}.csv": tables.polynomials(c) for c in walk.curves}
    recorded, held = (_picked(walk, cycles) for cycles in (walk.training, walk.held_out))
    for name, rows in (("recorded", recorded), ("held_out", held)):
        if rows:
            files[f"{stem}/{name}.csv"] = tables.samples(rows)
    if walk.bands:
        files[f"{stem}/bands.csv"] = csv(walk.bands)
    parts = [_head(walk, stem), _tables(walk, stem, files), _automaton(walk), claims(walk, recorded, held)]
    return {f"{stem}.ha": _formatted("\n".join(parts))} | files


def _picked(walk: Walk, cycles: Sequence[Cycle]) -> list[tables.Row]:
    """The samples that a spec states: all, or of many those farthest from the curves and others."""
    return tables.picked(cycles, walk.knots, {place for c in walk.curves for place in farthest(c, cycles)})


def _formatted(text: str) -> str:
    """The text in the one layout, with doc comments of at most 120 columns."""
    lines = [part for line in text.split("\n") for part in _wrapped(line)]
    source = Source.of_text("fitted.ha", "\n".join(lines))
    tree, found = parse(source)
    assert not found, found
    return layout.format(tree, source)


def _wrapped(line: str) -> list[str]:
    lead, doc, said = line.partition("/// ")
    if not doc or lead.strip() or len(line) <= 120:
        return [line]
    return [f"{lead}/// {part}" for part in textwrap.wrap(said, 116 - len(lead), break_long_words=False)]


def _head(walk: Walk, stem: str) -> str:
    sources = "".join(
        f"/// {r.path.rsplit('/', 1)[-1]}, sha256 {r.sha256}: {len(r.times)} samples, {'; '.join(r.facts)}.\n"
        for r in walk.recordings
    )
    leg, cycles = LEGS[walk.options.leg], len(walk.training)
    held = f" {len(walk.held_out)} more were held out." if walk.held_out else ""
    if walk.bands and walk.held_out:
        shares = [coverage(b, walk.held_out).samples for b in walk.bands]
        held += (
            f" The band of 95 % in {stem}/bands.csv, mean +- {walk.bands[0].k:.2f} standard deviations, holds"
            f" {min(shares):.1%} to {max(shares):.1%} of the held-out samples of a joint."
        )
    whole = {"repeats": "", "closes": ""}.get(walk.strides[0].kind, " It is no whole stride: the period is estimated.")
    return f"""spec "Walk {stem}" version "1.0"

/// Phases of the {leg} leg: loading response, mid stance, terminal stance, pre-swing, initial swing, mid swing,
/// terminal swing. Angles are in degrees: flexion of the hip +, of the knee -, dorsiflexion of the ankle +.
///
/// Fitted by `haverify fit` to:
///
{sources}///
/// Cycles used: {cycles}.{held}{whole} Events: {", ".join(dict.fromkeys(walk.methods))}.
enum Phase {{ {", ".join(PHASES)} }}
"""


def _tables(walk: Walk, stem: str, files: dict[str, str]) -> str:
    parts = [
        f'''/// When the phases begin, counted from the heel strike, and how long they last.
table Slot from "{stem}/phases.csv" {{
  key phase: Phase
  column begin: s
  column length: s
  sha256 "{_sha(files[f"{stem}/phases.csv"])}"
}}
'''
    ]
    parts += [_table(c, r, stem, files) for c, r in zip(walk.curves, walk.residuals, strict=True)]
    shown = [
        ("Recorded", "recorded", "Recorded samples", walk.training),
        ("Held", "held_out", "Samples of held-out cycles", walk.held_out),
    ]
    for name, file, what, cycles in shown:
        if f"{stem}/{file}.csv" in files:
            parts.append(_samples(name, f"{stem}/{file}.csv", files[f"{stem}/{file}.csv"], what, cycles))
    return "".join(parts)


def _samples(name: str, file: str, text: str, what: str, cycles: Sequence[Cycle]) -> str:
    """The table of samples, and the numbers that are its second key."""
    columns = "\n".join(f"  column {j}: deg" for j in JOINTS)
    rows = [line.split(",") for line in text.splitlines()[1:]]
    count, stated = sum(len(c.at) for c in cycles), len({(phase, *values) for phase, _, *values in rows})
    some = "all" if stated >= count else f"{stated} of {count}, the ones farthest from the curves among them,"
    return f'''enum {name}Pick = 0..{len(rows) // len(PHASES) - 1}

/// {what}, {some} at their local times. A phase with fewer repeats its last one.
table {name} from "{file}" {{
  key phase: Phase
  key pick: {name}Pick
  column u: 1
{columns}
  sha256 "{_sha(text)}"
}}
'''


def _table(c: Curve, r: Residual, stem: str, files: dict[str, str]) -> str:
    low, high = float(r.low), float(r.high)
    return f'''/// The {told(c.joint)}, degree {c.degree}: {r.count} samples lie {low:.3f} .. {high:.3f} deg from it,
/// {r.rms:.3f} deg in root mean square.
table {c.joint.upper()} from "{stem}/{c.joint}.csv" {{
  key phase: Phase
  poly c0..c{c.degree} ascending in u: 1 -> deg
  sha256 "{_sha(files[f"{stem}/{c.joint}.csv"])}"
}}
'''


def _sha(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _automaton(walk: Walk) -> str:
    lengths = [float(c.length) for c in walk.cycles]
    period = float(walk.knots.period)
    low, high = period / max(lengths), period / min(lengths)
    spread = f"[{int(low * 1000) / 1000:g}, {-int(-high * 1000 // 1) / 1000:g}]"
    why = f"between the slowest and the fastest of {len(lengths)} recorded cycles"
    if len(lengths) == 1 or low == high:
        spread, why = "[0.9, 1.1]", "a declared tenth around that of the one recorded cycle"
    at = [tables.text(t) for t in walk.knots.at]
    slots = "\n".join(f"    {name} until {t} s" for name, t in zip(PHASES, at[1:], strict=True))
    more = {j: f" + shift_{j}" for j in JOINTS} if walk.shifts else dict.fromkeys(JOINTS, "")
    lets = "\n".join(f"  /// {told(j).capitalize()}.\n  let {j}: deg = {j.upper()}[phase](u){more[j]}" for j in JOINTS)
    shifts = "".join(
        f"param shift_{c.joint}: deg in [{tables.text(a)} deg, {tables.text(b)} deg] default 0 deg\n"
        for c, (a, b) in zip(walk.curves, walk.shifts, strict=bool(walk.shifts))
    )
    if shifts:
        shifts = "/// How far whole recordings lie from the mean curve: unknown, constant along a run.\n" + shifts
    return f"""/// Walking speed as a multiple of the mean one: {why}. Claims hold for all its values.
param speed: 1 in {spread} default 1
{shifts}
/// The walk: a clock from heel strike to heel strike, in each phase a polynomial of the local time u for each joint.
automaton Walk {{
  var x: s in [0 s, {tables.text(walk.knots.period)} s]
  let u: 1 = (x - Slot[phase].begin) / Slot[phase].length
{lets}
  init {PHASES[0]} with x := 0 s
  mode Run for phase in Phase {{
    flow {{ x' = speed }}
  }}
  schedule on x from 0 s {{
{slots} then {PHASES[0]} do x := 0 s
  }}
}}
"""
