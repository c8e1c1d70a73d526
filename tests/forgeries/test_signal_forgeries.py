"""Certificates of claims over time: every damage that makes one false is refused, and none brings the checker down."""

import json
import shutil
from contextlib import redirect_stdout
from fractions import Fraction
from io import StringIO
from pathlib import Path

import pytest

from hacheck import rational
from hacheck.__main__ import main as hacheck
from haverify.cli import main as haverify

SMALL = Path(__file__).parent / "small" / "signals.ha"
WORK = rational.Meter.left
OTHER = {"t": "f", "f": "t", "u": "t"}
HOSTILE = [None, [], {}, "", "1/0", -1, True, "t", [["start", 7, "x"]], "9" * 5000]


def answers(folder, base):
    rational.Meter.left = WORK
    said = StringIO()
    with redirect_stdout(said):
        code = hacheck([str(folder), "--inputs", str(base), "--json"])
    return code, json.loads(said.getvalue())["claims"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    path = tmp_path_factory.mktemp("signals")
    shutil.copy(SMALL, path)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        patch.setenv("HAVERIFY_CACHE", str(path / "cache"))
        with redirect_stdout(StringIO()):
            assert haverify(["check", SMALL.name]) == 0
    return path


def paths(value, at=()):
    """All places in a JSON value."""
    yield at, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for k, inner in items:
        yield from paths(inner, (*at, k))


def changed(value, at, new):
    """A copy with another value at a place; DROP takes an element away."""
    if not at:
        return new
    copy = dict(value) if isinstance(value, dict) else list(value)
    if len(at) == 1 and new is DROP:
        del copy[at[0]]
    else:
        copy[at[0]] = changed(value[at[0]], at[1:], new)
    return copy


DROP = object()


def is_item(at, value):
    return isinstance(value, list) and len(value) in (3, 4) and "atoms" in at and value[-1:] != [] and (
        isinstance(value[0], str) and value[1] in (True, False) and value[2] in OTHER)  # fmt: skip


def forgeries(certificate):
    """Damages of a certificate that make it false, each with its name."""
    entry = certificate["goals"][0]
    yield (
        "verdict",
        changed(certificate, ("verdict",), {"proved": "refuted", "refuted": "proved"}[certificate["verdict"]]),
    )
    yield "hash", changed(certificate, ("goals", 0, "hash"), "0" * 64)
    yield "entry", changed(certificate, ("goals", 0), {"kind": "signals", "hash": entry["hash"]})
    yield "claim", changed(certificate, ("claim",), "another")
    for at, value in paths(entry):
        where = ("goals", 0, *at)
        if is_item(at, value):
            yield (
                f"{at} truth",
                changed(certificate, where, [*value[:2], OTHER[value[2]], *([value[3] or "u"] if value[3:] else [])]),
            )
            if Fraction(value[0]) > 0:
                yield f"{at} end", changed(certificate, where, ["-1", *value[1:]])
        elif value and isinstance(value, list) and "atoms" in at and all(is_item((*at, 0), x) for x in value):
            yield f"{at} short", changed(certificate, where, value[:-1])
        elif at[-2:-1] == ("jumps",) and value[2] in OTHER:
            yield f"{at} landing", changed(certificate, where, [*value[:2], OTHER[value[2]], value[3]])
        elif at[-1:] == ("dwell",) and "steps" in at:
            yield f"{at} dwell", changed(certificate, where, str(Fraction(value) + 1))
        elif at[-1:] == ("edge",):
            yield f"{at} edge", changed(certificate, where, 7)
        elif at[-1:] == ("last",):
            yield f"{at} last", changed(certificate, where, "-1/2")
        elif at[-1:] in (("speed",), ("x",), ("z",)) and isinstance(value, str):
            yield f"{at} value", changed(certificate, where, "17")
        elif isinstance(value, list) and value[:1] == ["split"]:
            yield f"{at} half", changed(certificate, where, value[3])
            yield f"{at} place", changed(certificate, (*where, 1), ["param", "nobody"])
            yield f"{at} cut", changed(certificate, (*where, 2), "5")


def cell_forgeries(cells):
    """Damages of the cells that a proof over time rests on."""
    yield "no cells", {**cells, "cells": []}
    yield "time", {**cells, "time": "1/8"}
    yield "untimed", {**cells, "rho": False}
    yield "jumps", {**cells, "jumps": 3}
    for n in range(len(cells["cells"])):
        yield f"{n} dropped", changed(cells, ("cells", n), DROP)
        yield f"{n} dwell", changed(cells, ("cells", n, "dwell"), "1/100")
        yield f"{n} sigma", changed(cells, ("cells", n, "sigma"), ["9", "9"])


def refused_of(place, tmp_path, file, forged):
    """Whether the checker refuses the claim whose certificate is forged, and everything else stands."""
    folder = tmp_path / "forged"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(place / "reports" / "signals", folder)
    (folder / file).write_text(json.dumps(forged, sort_keys=True, separators=(",", ":")) + "\n")
    code, _ = answers(folder, place)
    return code != 0


def test_the_true_report_is_accepted_and_has_every_kind_of_entry(place):
    code, found = answers(place / "reports" / "signals", place)
    assert code == 0 and all(a["outcome"] == "accepted" for a in found.values())
    text = "".join(f.read_text() for f in sorted((place / "reports/signals/certificates").glob("*.json")))
    for word in ('"split"', '"run"', '"stays"', '"jumps":[[', '"u"', '"f"'):
        assert word in text, word


def test_every_forged_certificate_is_refused(place, tmp_path):
    made = 0
    for path in sorted((place / "reports/signals/certificates").glob("*.json")):
        for name, forged in list(forgeries(json.loads(path.read_text())))[::2]:
            made += 1
            assert refused_of(place, tmp_path, f"certificates/{path.name}", forged), (path.name, name)
    assert made >= 50


def test_every_forged_cell_is_refused(place, tmp_path):
    for path in sorted((place / "reports/signals/certificates/cells").glob("Two-*.json"))[:1]:
        for name, forged in cell_forgeries(json.loads(path.read_text())):
            assert refused_of(place, tmp_path, f"certificates/cells/{path.name}", forged), (path.name, name)


@pytest.mark.parametrize("claim", ["returns", "split", "too_soon"])
def test_hostile_values_anywhere_are_refused_without_a_traceback(place, tmp_path, claim):
    path = place / "reports/signals/certificates" / f"{claim}.json"
    true = json.loads(path.read_text())
    places = [at for at, _ in paths(true["goals"][0]) if at][::5]
    for n, at in enumerate(places):
        forged = changed(true, ("goals", 0, *at), HOSTILE[n % len(HOSTILE)])
        refused_of(place, tmp_path, f"certificates/{claim}.json", forged)
