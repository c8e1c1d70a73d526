"""Reading a report folder: bounded, strict JSON; the shape of the core; table numbers against the CSV cells."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import re
import stat
from fractions import Fraction
from typing import Any, NoReturn

from hacheck.rational import Refused, Unreadable, number

Json = Any
MAX_BYTES = 128 << 20
NAME = re.compile(r"[\w][\w.\[\], '-]{0,199}", re.ASCII)
_DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,4})?", re.ASCII)
EXPR, MAYBE = (str, bool, list), (str, bool, list, type(None))
_VALUE = {"name": str}
SHAPES: dict[str, Json] = {
    "spec": {"name": str}, "enums": [{"name": str, "values": [str], "low": (str, type(None))}],
    "constants": [{"name": str, "value": (*EXPR, dict), "half": (str, type(None))}],
    "params": [{"name": str, "low": EXPR, "high": EXPR}], "inputs": [_VALUE], "assumptions": [EXPR],
    "tables": [dict],
    "cells": [{"file": str, "row": int, "column": (str, int), "number": str, "constant": str}],
    "claims": [{"name": str, "on": (str, type(None)), "kind": str, "assume": [EXPR], "which": list, "inductive": bool,
                "horizon": {"time": MAYBE, "jumps": (int, type(None))},
                "goals": [{"kind": str, "condition": EXPR, "window": (list, type(None)), "within": MAYBE}]}],
}  # fmt: skip
_LETS, _RESETS = [{"name": str, "type": str, "expr": EXPR}], [{"var": str}]
SHAPES["automata"] = [{
    "name": str, "constants": SHAPES["constants"], "params": SHAPES["params"], "inputs": [_VALUE], "lets": _LETS,
    "vars": [{"name": str, "type": str, "low": MAYBE, "high": MAYBE}], "priorities": list,
    "init": [{"mode": (str, type(None)), "where": EXPR, "with": _RESETS}],
    "modes": [{"name": str, "domain": EXPR, "flow": _RESETS, "lets": _LETS, "terminal": bool}],
    "edges": [{"name": str, "source": str, "target": str, "urgent": bool, "guard": EXPR, "resets": _RESETS}],
}]  # fmt: skip
SHAPES["systems"] = [{
    **{key: SHAPES["automata"][0][key] for key in ("name", "constants", "vars", "lets", "init")}, "flow": _RESETS,
    "parts": [{"name": str, "of": str, "bindings": [_VALUE]}], "priorities": [{"over": [str], "when": EXPR}],
    "syncs": [{"name": str, "edges": [str], "listeners": [str], "guard": EXPR, "resets": _RESETS}],
}]  # fmt: skip


def read_bytes(path: str) -> bytes:
    """A regular file of bounded size."""
    name = os.path.basename(path)
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise Unreadable(f"{name!a} is no file")
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as e:
        raise Unreadable(f"cannot read {name!a}: {getattr(e, 'strerror', '')}") from None
    if len(data) > MAX_BYTES:
        raise Unreadable(f"{name!a} is too large")
    return data


def read_json(path: str) -> Json:
    """JSON without floats, duplicate keys, or integers of more than 18 digits; a report's times are left as text."""
    name = os.path.basename(path)
    times = str if name == "report.json" else _refuse
    try:
        return json.loads(read_bytes(path).decode("utf-8"), object_pairs_hook=_object, parse_float=times,
                          parse_int=_integer, parse_constant=_refuse)  # fmt: skip
    except (ValueError, RecursionError, MemoryError) as e:
        why = str(e) if isinstance(e, ValueError) else "too deep or too large"
        raise Unreadable(f"{name!a} is not the JSON expected: {why.splitlines()[0][:100]!a}") from None


def _object(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    out = dict(pairs)
    if len(out) != len(pairs):
        raise ValueError("a key twice")
    return out


def _refuse(text: str) -> NoReturn:
    raise ValueError(f"{text[:20]} is no exact number")


def _integer(text: str) -> int:
    return int(text) if len(text) < 19 else _refuse(text)


def check_shape(value: Json, shape: Json, where: str) -> None:
    """Raise Unreadable unless the value has the keys and types of a shape."""
    if isinstance(shape, list):
        if not isinstance(value, list):
            raise Unreadable(f"{where} is no list")
        for item in value:
            check_shape(item, shape[0], where)
    elif isinstance(shape, dict):
        for key, inner in shape.items():
            if not isinstance(value, dict) or key not in value:
                raise Unreadable(f"{where} lacks {key}")
            check_shape(value[key], inner, f"{where}.{key}")
    elif not isinstance(value, shape) or (isinstance(value, bool) and shape in (int, (str, int), (int, type(None)))):
        raise Unreadable(f"{where} has a wrong type")


def by_name(items: list[Json], what: str) -> dict[str, Json]:
    """Items by name, each name once."""
    out = {item["name"]: item for item in items}
    if len(out) != len(items):
        raise Unreadable(f"two {what} of one name")
    return out


class Core:
    """`core.json`, with the shape it must have; expressions are looked at where they are used."""

    def __init__(self, data: Json) -> None:
        check_shape(data, SHAPES, "core")
        if data.get("schema") != "haverify.core/1":
            raise Unreadable("core.json has another schema than haverify.core/1")
        self.data = data
        self.enums, self.constants = by_name(data["enums"], "enums"), by_name(data["constants"], "constants")
        self.automata, self.claims = by_name(data["automata"], "automata"), by_name(data["claims"], "claims")
        self.order = {name: i for i, name in enumerate(self.constants)}
        by_name(data["params"], "params")
        self.systems = by_name(data["systems"], "systems")
        by_name(data["systems"] + data["automata"], "systems or automata")
        for e in data["enums"]:
            whole = e["low"] is None or number(e["low"]).denominator == 1
            if not whole or len(set(e["values"])) < len(e["values"]) or e["name"] in ("real", "bool"):
                raise Unreadable(f"the enumeration {e['name']!a} is none")
        for a in data["automata"]:
            self.check_automaton(a)
        if not all(NAME.fullmatch(n) for n in self.claims):
            raise Unreadable("a claim has a name that is none")

    def check_automaton(self, a: Json) -> None:
        """Raise Unreadable unless an automaton is well formed, apart from its expressions."""
        variables, modes = by_name(a["vars"], "variables"), by_name(a["modes"], "modes")
        for what in ("constants", "params", "lets"):
            by_name(a[what], what)
        reals = sorted(v["name"] for v in a["vars"] if v["type"] == "real")
        ends = {m for e in a["edges"] for m in (e["source"], e["target"])} | {i["mode"] for i in a["init"]} - {None}
        if not ends <= set(modes) or any(v["type"] not in {"real", "bool", *self.enums} for v in a["vars"]):
            raise Unreadable(f"automaton {a['name']!a} refers to a mode or type that it does not have")
        for m in a["modes"]:
            by_name(m["lets"], "lets")
            if any(set(f) not in ({"var", "rate"}, {"var", "low", "high"}) for f in m["flow"]):
                raise Unreadable(f"mode {m['name']!a} has a flow line with no rate, or two")
            if sorted(f["var"] for f in m["flow"]) != reals:
                raise Unreadable(f"mode {m['name']!a} does not have one flow line for each real variable")
        for assigns in [e["resets"] for e in a["edges"]] + [i["with"] for i in a["init"]]:
            targets = [r["var"] for r in assigns]
            if len(set(targets)) < len(targets) or not set(targets) <= set(variables):
                raise Unreadable(f"a reset of automaton {a['name']!a} assigns twice, or to no variable")
            if any(set(r) not in ({"var", "to"}, {"var", "low", "high"}) for r in assigns):
                raise Unreadable("a reset gives no value, or two")

    def number_of(self, name: str) -> set[Fraction]:
        """The literal values of a constant: of the top level, else of the automata that have it."""
        found = [self.constants[name]] if name in self.constants else [
            c for a in self.data["automata"] for c in a["constants"] if c["name"] == name]  # fmt: skip
        return {number(c["value"]) for c in found}


def check_cells(core: Core, inputs: list[str] | None, base: str) -> str:
    """Compare every table number with its constant and, where the file is found, with the text of its cell."""
    folders = {os.path.dirname(p) for p in inputs or () if p.endswith(".ha")}
    files: dict[str, list[list[str]] | None] = {}
    for cell in core.data["cells"]:
        where = f"{cell['file']!a} row {cell['row']} column {cell['column']!a}"
        if core.number_of(cell["constant"]) != {number(cell["number"])}:
            raise Refused(f"the constant {cell['constant']!a} is not the number of {where}")
        name = cell["file"]
        if name not in files:
            paths = sorted({os.path.normpath(os.path.join(d, name)) for d in folders} & set(inputs or ()))
            if inputs is not None and not paths:
                raise Refused(f"the report lists no input {name!a}")
            path = os.path.join(base, paths[0] if paths else name)
            files[name] = _rows(path) if os.path.isfile(path) else None
        rows = files[name]
        if rows is not None and _cell(rows, cell["row"], cell["column"]) != number(cell["number"]):
            raise Refused(f"{where} does not hold the number of the core")
    absent = sum(rows is None for rows in files.values())
    how = f", {absent} of {len(files)} tables not found here: their numbers were not compared with their files"
    return f"{len(core.data['cells'])} table numbers" + how * bool(absent)


def _rows(path: str) -> list[list[str]]:
    lines = read_bytes(os.path.realpath(path)).decode("utf-8-sig", "replace").splitlines()
    return [next(csv.reader([line]), []) for line in lines]


def _cell(rows: list[list[str]], row: int, column: str | int) -> Fraction | None:
    header = [h.strip() for h in rows[0]] if rows else []
    index = header.index(column) if column in header else int(column) - 1 if str(column).isdecimal() else -1
    if not (1 <= row <= len(rows) and 0 <= index < len(rows[row - 1])):
        return None
    text = rows[row - 1][index].strip()
    return Fraction(text) if len(text) < 4000 and _DECIMAL.fullmatch(text) else None


def check_inputs(inputs: Json, base: str) -> str:
    """Compare the hashes of the inputs that are there with those of the report."""
    check_shape(inputs, [{"path": str, "sha256": str}], "report.inputs")
    seen = 0
    for item in inputs:
        path = os.path.join(base, item["path"])
        if os.path.isfile(path):
            seen += 1
            if hashlib.sha256(read_bytes(os.path.realpath(path))).hexdigest() != item["sha256"]:
                raise Refused(f"the input {item['path']!a} has changed since the report")
    return f"{seen} of {len(inputs)} inputs found and unchanged"
