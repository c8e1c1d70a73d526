"""Certificates about cells, rules, relations and params that show nothing, or another thing: all are refused."""

import copy
import hashlib
import json

import pytest

from hacheck.core import Core
from hacheck.holds import held, obligation
from hacheck.rational import Meter, Refused, Unreadable

BITS = ["000", "001", "010", "100", "101", "110"]
C, D = ["bound", "c"], ["bound", "d"]
NEXT = ["next", "R", C]
SUB = ["field", C, "sub"]
ALL = "forall", "c", "Cell"
PARTNERS = [["000", "110"], ["001", "101"], ["010", "100"], ["100", "010"], ["101", "001"], ["110", "000"]]


def enum(name, values, codes=None, low=None, high=None):
    return {"name": name, "values": values, "codes": codes or [None] * len(values), "low": low, "high": high}


def param(name, low, high):
    return {"name": name, "unit": None, "low": low, "high": high, "default": None}


def cellular(name="R", rules=None, cell="Cell", first="Leg", second="Sub", argument=None, formula=None):
    return {
        "name": name,
        "cell": cell,
        "first": first,
        "second": second,
        "rules": PARTNERS if rules is None else rules,
        "argument": argument,
        "formula": formula,
    }


def core(*goals, on="R", assume=(), **changes):
    """A core with one claim; `changes` replace its parts."""
    listed = [{"kind": "holds", "condition": g, "window": None, "within": None, "attracting": False} for g in goals]
    claim = {
        "name": "c",
        "on": on,
        "kind": "property",
        "goals": listed,
        "horizon": {"time": None, "jumps": None},
        "assume": list(assume),
        "which": [],
        "using": [],
        "method": None,
        "expect": None,
        "inductive": False,
    }
    empty = (
        "units",
        "constants",
        "params",
        "inputs",
        "tables",
        "networks",
        "assumptions",
        "automata",
        "systems",
        "fuzzy",
        "cells",
    )
    return {
        "schema": "haverify.core/1",
        "spec": {"name": "t", "version": "1", "unitless": False},
        "enums": [
            enum("Leg", ["Left", "Right"], ["0b0", "0b1"]),
            enum("Sub", ["A", "B", "C"], ["0b00", "0b01", "0b10"]),
        ],
        "cellular": [cellular()],
        "relations": [{"name": "S", "pairs": [["A", "C"], ["B", "B"], ["C", "A"]], "map": True}],
        "claims": [claim],
        **{k: [] for k in empty},
        **changes,
    }


def entry(kind, params=None, **fields):
    return {"kind": kind, "params": params or {}, **fields}


def witness(*values, params=None):
    return entry("witness", params, values=[list(v) for v in values])


def copied(data):
    """As it comes from a file."""
    return json.loads(json.dumps(data))


def outcome(data, verdict, *entries):
    """What the checker says of the certificate with all hashes as they have to be: `shown` or `refused`."""
    Meter.left = 1_000_000
    try:
        read = Core(copied(data))
        claim = read.data["claims"][0]
        full = [e and {"hash": obligation(read, claim, g), **e} for e, g in zip(entries, claim["goals"], strict=False)]
        said = {"schema": "haverify.certificate/1", "claim": "c", "verdict": verdict}
        return "shown" if held(read, claim, {**said, "goals": full, "rounding": None})[0] == verdict else "another"
    except (
        Refused,
        Unreadable,
        RecursionError,
        KeyError,
        IndexError,
        TypeError,
        ValueError,
        AttributeError,
        ArithmeticError,
    ):
        return "refused"


TRIED = entry("enumerated")
TOTAL = [*ALL, ["defined", NEXT]]
BACK = [*ALL, ["==", ["next", "R", NEXT], C]]
SAME = [*ALL, ["==", ["field", NEXT, "leg"], ["field", C, "leg"]]]
ONTO = [*ALL, ["exists", "d", "Cell", ["==", ["next", "R", D], C]]]
FIXED = ["exists", "c", "Cell", ["==", NEXT, C]]
FAR = ["exists", "c", "Cell", ["==", NEXT, ["cell", "Cell", "110"]]]
APPLIED = [*ALL, ["==", ["field", NEXT, "sub"], ["apply", "S", SUB]]]
PARTIAL = PARTNERS[:2] + PARTNERS[3:]
MASS = {"params": [param("m", "6", "8"), param("k", "0", "1")]}
M, K = ["param", "m"], ["param", "k"]
POINT = {"m": "7", "k": "1/2"}
COUNT = enum("Count", ["4", "5"], low="4", high="5")

TRUE = {
    "total": (core(TOTAL), "proved", TRIED),
    "back": (core(BACK), "proved", TRIED),
    "onto": (core(ONTO), "proved", TRIED),
    "applied": (core(APPLIED), "proved", TRIED),
    "same, tried": (core(SAME), "refuted", TRIED),
    "same, by a cell": (core(SAME), "refuted", witness(("c", "101"))),
    "far, tried": (core(FAR), "proved", TRIED),
    "far, by a cell": (core(FAR), "proved", witness(("c", "000"))),
    "fixed": (core(FIXED), "refuted", TRIED),
    "one of two": (core(TOTAL, SAME), "refuted", {}, witness(("c", "000"))),
    "shadowed": (
        core([*ALL, [*ALL, ["!=", C, ["cell", "Cell", "110"]]]]),
        "refuted",
        witness(("c", "000"), ("c", "110")),
    ),
    "partial, guarded": (
        core([*ALL, ["implies", ["defined", NEXT], ["!=", NEXT, C]]], cellular=[cellular(rules=PARTIAL)]),
        "proved",
        TRIED,
    ),
    "false beside undefined": (core(SAME, cellular=[cellular(rules=PARTIAL)]), "refuted", witness(("c", "000"))),
    "formula": (
        core(BACK, cellular=[cellular("Q"), cellular("R", [], argument="x", formula=["next", "Q", ["bound", "x"]])]),
        "proved",
        TRIED,
    ),
    "part of an integer": (
        core(
            [*ALL, ["<=", ["field", C, "count"], "5"]],
            enums=[COUNT, enum("Sub", ["A", "B"])],
            cellular=[cellular(rules=[], first="Count")],
            relations=[],
        ),
        "proved",
        TRIED,
    ),
    "constant": (
        core(["<", ["const", "g"], "10"], constants=[{"name": "g", "value": ["*", "2", "3"], "half": None}]),
        "proved",
        TRIED,
    ),
    "params": (core(["<=", ["*", M, M], "64"], **MASS), "proved", entry("boxes", POINT, verdict="proved", proof="b")),
    "params, at a point": (core(["<", M, "7"], **MASS), "refuted", witness(params=POINT)),
    "pi": (core(["<", ["pi"], "3"]), "refuted", entry("boxes", verdict="refuted", proof="b")),
    "assumed": (
        core(["<", M, "7"], assume=[["<", M, "13/2"]], **MASS),
        "proved",
        entry("boxes", {"m": "6", "k": "0"}, verdict="proved", proof=["s", "m", "13/2", "b", "b"]),
    ),
}


@pytest.mark.parametrize("name", TRUE)
def test_true_certificates_are_accepted(name):
    data, verdict, *entries = TRUE[name]
    assert outcome(data, verdict, *entries) == "shown"


def other(verdict):
    return "refuted" if verdict == "proved" else "proved"


@pytest.mark.parametrize("name", TRUE)
def test_the_other_verdict_is_refused(name):
    data, verdict, *entries = TRUE[name]
    assert outcome(data, other(verdict), *entries) == "refused"


@pytest.mark.parametrize("name", TRUE)
def test_no_entry_shows_the_other_verdict(name):
    data, verdict, *_ = TRUE[name]
    count = len(data["claims"][0]["goals"])
    params = POINT if data["params"] else {}
    tried = [entry("enumerated", params), witness(params=params), *(witness(("c", b), params=params) for b in BITS)]
    tried += [entry("boxes", params, verdict=other(verdict), proof=t) for t in ("b", "u", ["s", "m", "7", "b", "b"])]
    for e in tried:
        assert outcome(data, other(verdict), *[e] * count) == "refused"


def changed(data, *path, to):
    """A copy with one value replaced."""
    data = copy.deepcopy(data)
    inner = data
    for k in path[:-1]:
        inner = inner[k]
    inner[path[-1]] = to
    return data


LACKING = core(BACK, cellular=[cellular(rules=PARTIAL)])
DOUBLE = core(BACK, cellular=[cellular(rules=[*PARTNERS, ["000", "000"]])])
CLASH = [enum("Leg", ["Left", "Right"], ["0b0", "0b1"]), enum("Sub", ["A", "B", "C"], ["0b00", "0b01", "0b01"])]
LENGTHS = [enum("Leg", ["Left", "Right"], ["0b0", "9"]), enum("Sub", ["A", "B", "C"])]
HUGE = [enum(n, [f"{n}{i}" for i in range(400)]) for n in ("Leg", "Sub")]
WIDE = [
    *ALL,
    [
        "forall",
        "d",
        "Cell",
        ["exists", "e", "Cell", ["exists", "f", "Cell", ["or", ["==", C, D], ["==", ["bound", "e"], ["bound", "f"]]]]],
    ],
]
MANY = [enum("Leg", [f"L{i}" for i in range(32)]), enum("Sub", [f"S{i}" for i in range(32)])]

FORGED = {
    "a goal that something undefined decides": (LACKING, "proved", TRIED),
    "the same as refuted": (LACKING, "refuted", TRIED),
    "the same by the cell without a rule": (LACKING, "refuted", witness(("c", "010"))),
    "the same by its partner": (LACKING, "refuted", witness(("c", "100"))),
    "two rules that disagree": (DOUBLE, "proved", TRIED),
    "two rules that disagree, as refuted": (DOUBLE, "refuted", witness(("c", "000"))),
    "a total table without one rule": (core(TOTAL, cellular=[cellular(rules=PARTIAL)]), "proved", TRIED),
    "an image that is not unique": (
        core(
            APPLIED, relations=[{"name": "S", "pairs": [["A", "C"], ["A", "B"], ["B", "B"], ["C", "A"]], "map": False}]
        ),
        "proved",
        TRIED,
    ),
    "a witness that is none": (
        core(SAME, cellular=[cellular(rules=[["000", "000"], *PARTNERS[1:]])]),
        "refuted",
        witness(("c", "000")),
    ),
    "a witness of a true goal": (core(BACK), "refuted", witness(("c", "000"))),
    "a witness for a false exists": (core(FIXED), "proved", witness(("c", "000"))),
    "no value of the first quantifier": (core(FIXED), "proved", witness()),
    "another name": (core(SAME), "refuted", witness(("d", "000"))),
    "a name bound further inside": (core(ONTO), "refuted", witness(("d", "000"))),
    "a value too many": (core(SAME), "refuted", witness(("c", "000"), ("c", "000"))),
    "a value of an exists under forall": (core(ONTO), "refuted", witness(("c", "000"), ("d", "001"))),
    "an exists taken for forall": (
        core(["exists", "c", "Cell", ["==", NEXT, ["cell", "Cell", "110"]]]),
        "refuted",
        witness(("c", "010")),
    ),
    "unique taken for exists": (
        core(["unique", "c", "Cell", ["==", ["field", NEXT, "leg"], ["sym", "Leg", "Right"]]]),
        "proved",
        witness(("c", "000")),
    ),
    "a cell that is none": (core(SAME), "refuted", witness(("c", "011"))),
    "a cell with too few bits": (core(SAME), "refuted", witness(("c", "00"))),
    "a cell of another set": (core(SAME), "refuted", witness(("c", "Cell"))),
    "bits as a number": (core(SAME), "refuted", witness(("c", 0))),
    "a list as bits": (core(SAME), "refuted", witness(("c", ["0"]))),
    "values as an object": (core(SAME), "refuted", entry("witness", values={"c": "000"})),
    "no values at all": (core(SAME), "refuted", entry("witness")),
    "values in an enumeration": (core(TOTAL), "proved", entry("enumerated", values=[])),
    "a hash of another goal": (core(TOTAL), "proved", entry("enumerated", hash="0" * 64)),
    "no params": (core(TOTAL), "proved", {"kind": "enumerated"}),
    "params that there are not": (core(TOTAL), "proved", entry("enumerated", {"m": "7"})),
    "an unknown kind": (core(TOTAL), "proved", entry("trusted")),
    "no kind": (core(TOTAL), "proved", {"params": {}}),
    "an entry too few": (core(TOTAL, BACK), "proved", TRIED),
    "an entry left out": (core(TOTAL, BACK), "proved", TRIED, {}),
    "one code with two names": (core(TOTAL, enums=CLASH), "proved", TRIED),
    "codes of two lengths": (core(TOTAL, enums=LENGTHS), "proved", TRIED),
    "a code that is none": (
        core(TOTAL, enums=[enum("Leg", ["Left", "Right"], ["0b0", "0b2"]), enum("Sub", ["A", "B", "C"])]),
        "proved",
        TRIED,
    ),
    "too few codes": (
        core(TOTAL, enums=[enum("Leg", ["Left", "Right"], ["0b0"]), enum("Sub", ["A", "B", "C"])]),
        "proved",
        TRIED,
    ),
    "two parts of one name": (
        core(TOTAL, enums=[enum("Sub", ["A", "B"]), enum("sub", ["A", "B", "C"])], cellular=[cellular(first="sub")]),
        "proved",
        TRIED,
    ),
    "no such enumeration": (core(TOTAL, cellular=[cellular(first="Foot")]), "proved", TRIED),
    "cells that are two things": (
        core(TOTAL, cellular=[cellular(), cellular("Q", [], first="Sub", second="Leg")]),
        "proved",
        TRIED,
    ),
    "two automata of one name": (core(TOTAL, cellular=[cellular(rules=PARTIAL), cellular()]), "proved", TRIED),
    "two relations of one name": (
        changed(core(APPLIED), "relations", to=[{"name": "S", "pairs": [], "map": True}] * 2),
        "proved",
        TRIED,
    ),
    "a rule from nowhere": (core(TOTAL, cellular=[cellular(rules=[*PARTNERS, ["011", "000"]])]), "proved", TRIED),
    "a rule to nowhere": (
        core(["not", [*ALL, ["==", NEXT, C]]], cellular=[cellular(rules=[["000", "111"], *PARTNERS[1:]])]),
        "proved",
        TRIED,
    ),
    "a formula that asks for itself": (
        core(TOTAL, cellular=[cellular(rules=[], argument="x", formula=["next", "R", ["bound", "x"]])]),
        "proved",
        TRIED,
    ),
    "a formula that leads elsewhere": (
        core(TOTAL, cellular=[cellular(rules=[], argument="x", formula=["field", ["bound", "x"], "sub"])]),
        "proved",
        TRIED,
    ),
    "a name that nothing binds": (core(["defined", ["next", "R", ["bound", "z"]]]), "proved", TRIED),
    "a set that is none": (core(["forall", "c", "Nothing", False]), "proved", TRIED),
    "a cell against a number": (core([*ALL, ["!=", C, "0"]]), "proved", TRIED),
    "a truth against a number": (core([*ALL, ["==", ["defined", C], "1"]]), "proved", TRIED),
    "an order of names": (core([*ALL, ["<=", SUB, SUB]]), "proved", TRIED),
    "an order of truths": (core([*ALL, ["<=", ["defined", C], ["defined", C]]]), "proved", TRIED),
    "not with two operands": (core(["not", False, True]), "proved", TRIED),
    "implies with one operand": (core(["implies", False]), "proved", TRIED),
    "a comparison of three": (core(["==", "0", "0", "1"]), "proved", TRIED),
    "an operator that is none": (core(["surely", TOTAL]), "proved", TRIED),
    "a fuzzy word": (core([*ALL, ["or", True, ["covered", "F", "x", "0"]]]), "proved", TRIED),
    "more cells than are tried": (core(TOTAL, enums=HUGE), "proved", TRIED),
    "more combinations than are tried": (core(WIDE, enums=MANY, cellular=[cellular(rules=[])]), "proved", TRIED),
    "a constant that reads itself": (
        core(["<", ["const", "g"], "10"], constants=[{"name": "g", "value": ["const", "g"], "half": None}]),
        "proved",
        TRIED,
    ),
    "a constant that is a set": (
        core(["<", ["const", "g"], "10"], constants=[{"name": "g", "value": {"low": "0", "high": "1"}, "half": None}]),
        "proved",
        TRIED,
    ),
    "a division by zero": (core(["<", ["/", "1", "0"], "10"]), "proved", TRIED),
    "a division by zero, denied": (core(["not", ["<", ["/", "1", "0"], "10"]]), "proved", TRIED),
    "a tower of powers": (core(["<", ["^", ["^", "9", "1000"], "1000"], "10"]), "refuted", TRIED),
    "pi as a number": (core(["<", ["pi"], "4"]), "proved", TRIED),
    "a param that is not looked at": (core(["<", M, "7"], **MASS), "proved", entry("enumerated", {"m": "6", "k": "0"})),
    "a param at its best value": (
        core(["<", M, "7"], **MASS),
        "proved",
        entry("boxes", {"m": "6", "k": "0"}, verdict="proved", proof="b"),
    ),
    "a param outside its range": (core(["<", M, "9"], **MASS), "refuted", witness(params={"m": "10", "k": "0"})),
    "a param left out": (core(["<", M, "7"], **MASS), "refuted", witness(params={"m": "7"})),
    "a param too many": (core(["<", M, "7"], **MASS), "refuted", witness(params={**POINT, "n": "0"})),
    "no param at all": (core(["<", M, "7"], **MASS), "refuted", witness()),
    "a float as a param": (core(["<", M, "7"], **MASS), "refuted", witness(params={"m": "7.5", "k": "0"})),
    "a param that an assumption excludes": (
        core(["<", M, "7"], assume=[["<", M, "7"]], **MASS),
        "refuted",
        witness(params=POINT),
    ),
    "proved of nothing": (core(TOTAL, assume=[["<", M, "6"]], **MASS), "proved", entry("enumerated", POINT)),
    "proved of nothing, without a point": (core(TOTAL, assume=[["<", M, "6"]], **MASS), "proved", TRIED),
    "assumed false": (core(SAME, assume=[False]), "proved", TRIED),
    "assumed undefined": (
        core(TOTAL, assume=[LACKING["claims"][0]["goals"][0]["condition"]], cellular=[cellular(rules=PARTIAL)]),
        "proved",
        TRIED,
    ),
    "an assumption of the file forgotten": (
        core(["<", M, "7"], assumptions=[["<", M, "13/2"]], **MASS),
        "refuted",
        witness(params=POINT),
    ),
    "a tree for a false goal": (
        core(["<=", ["*", M, M], "63"], **MASS),
        "proved",
        entry("boxes", POINT, verdict="proved", proof="b"),
    ),
    "a tree that splits outside": (
        core(["<=", ["*", M, M], "64"], **MASS),
        "proved",
        entry("boxes", POINT, verdict="proved", proof=["s", "m", "9", "b", "b"]),
    ),
    "a tree without a point": (
        core(["<=", ["*", M, M], "64"], **MASS),
        "proved",
        entry("boxes", verdict="proved", proof="b"),
    ),
    "a tree about cells": (core(TOTAL), "proved", entry("boxes", verdict="proved", proof="b")),
    "a tree with a third verdict": (core(["<", ["pi"], "3"]), "refuted", entry("boxes", verdict="unknown", proof="b")),
    "a box without a range": (
        core(["<", M, "7"], params=[param("m", "8", "6")]),
        "proved",
        entry("boxes", {"m": "7"}, verdict="proved", proof="b"),
    ),
    "two params of one name": (
        core(["<", M, "7"], params=[param("m", "6", "6"), param("m", "6", "9")]),
        "proved",
        entry("boxes", {"m": "6"}, verdict="proved", proof="b"),
    ),
    "a quotient that has no value somewhere": (
        core(["<=", ["/", "1", ["-", M, "7"]], "1"], **MASS),
        "proved",
        entry("boxes", POINT, verdict="proved", proof="b"),
    ),
    "a window": (changed(core(TOTAL), "claims", 0, "goals", 0, "window", to=["0", "1"]), "proved", TRIED),
    "a time": (changed(core(TOTAL), "claims", 0, "goals", 0, "within", to="1"), "proved", TRIED),
    "for which": (
        changed(core(TOTAL), "claims", 0, "which", to=[{"name": "m", "low": "0", "high": "1"}]),
        "proved",
        TRIED,
    ),
}


@pytest.mark.parametrize("name", FORGED)
def test_forged_certificates_are_refused(name):
    data, verdict, *entries = FORGED[name]
    assert outcome(data, verdict, *entries) == "refused"


def test_the_hash_is_of_the_whole_finite_model():
    """What a goal rests on is in its hash, so a certificate belongs to one core."""
    data = core(TOTAL)
    read = Core(copied(data))
    digest = obligation(read, data["claims"][0], data["claims"][0]["goals"][0])
    parts = ("constants", "params", "enums", "assumptions", "cellular", "relations", "fuzzy", "tables")
    value = ["haverify.obligation/1", {k: data[k] for k in parts}, data["claims"][0]["goals"][0], [], "R"]
    assert digest == hashlib.sha256(json.dumps(value, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
    assert len(FORGED) + 2 * len(TRUE) > 110
