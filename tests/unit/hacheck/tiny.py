"""Hand-written cores, certificates and report folders, small enough to check by eye."""

import copy
import hashlib
import json
from pathlib import Path

DOMAIN_A = ["and", ["<=", "0", ["var", "x"]], ["<=", ["var", "x"], "1"]]
DOMAIN_B = ["and", ["<=", "1", ["var", "x"]], ["<=", ["var", "x"], "2"]]


def edge(name, source, target, guard, resets=(), urgent=True):
    return {"name": name, "source": source, "target": target, "urgent": urgent, "guard": guard, "resets": list(resets)}


def mode(name, domain, flow=(("x", "1"),), lets=(), terminal=False):
    return {
        "name": name,
        "domain": domain,
        "flow": [{"var": v, "rate": r} for v, r in flow],
        "lets": [let(n, e) for n, e in lets],
        "terminal": terminal,
    }


def let(name, expr, type_="real"):
    return {"name": name, "type": type_, "unit": None, "expr": expr}


def real(name, low=None, high=None):
    return {"name": name, "type": "real", "unit": None, "low": low, "high": high}


def const(name, value, half=None):
    return {"name": name, "type": "real", "unit": None, "value": value, "half": half}


def param(name, low, high):
    return {"name": name, "unit": None, "low": low, "high": high, "default": None}


def automaton(**changes):
    """A clock that goes 0 to 1 in A, 1 to 2 in B, and back; y = x^2 in A and 5 - x in B."""
    x = ["var", "x"]
    return {
        "name": "Clock", "constants": [], "params": [], "inputs": [], "lets": [], "priorities": [],
        "vars": [real("x", "0", "2")],
        "init": [{"mode": "A", "where": True, "with": [{"var": "x", "to": "0"}]}],
        "modes": [mode("A", DOMAIN_A, lets=[("y", ["^", x, "2"])]), mode("B", DOMAIN_B, lets=[("y", ["-", "5", x])])],
        "edges": [
            edge("ab", "A", "B", [">=", x, "1"]),
            edge("ba", "B", "A", [">=", x, "2"], [{"var": "x", "to": "0"}]),
        ],
        **changes,
    }  # fmt: skip


def goal(kind, condition, window=None, within=None):
    return {"kind": kind, "condition": condition, "window": window, "within": within, "attracting": False}


def claim(name, *goals, **changes):
    return {
        "name": name, "on": "Clock", "kind": "property", "goals": list(goals), "horizon": {"time": None, "jumps": None},
        "assume": [], "which": [], "using": [], "method": None, "expect": None, "inductive": False, **changes,
    }  # fmt: skip


def core(claims, model=None, **changes):
    return {
        "schema": "haverify.core/1", "spec": {"name": "tiny", "version": "1.0", "unitless": True},
        "units": [], "enums": [], "constants": [], "params": [], "inputs": [], "tables": [], "networks": [],
        "assumptions": [], "automata": [model or automaton()], "systems": [], "cellular": [], "relations": [],
        "fuzzy": [], "claims": claims, "cells": [], **changes,
    }  # fmt: skip


def cell(name, dwell, jumps=None, meet=None, sigma=None, **entry):
    out = {"mode": name, "entry": {v: list(i) for v, i in entry.items()}, "dwell": dwell}
    for key, value in (("jumps", jumps), ("meet", meet), ("sigma", sigma)):
        if value is not None:
            out[key] = value
    return out


def cells(*members, **changes):
    return {
        "schema": "haverify.cells/1", "automaton": "Clock", "rho": False, "time": None, "jumps": None,
        "cells": list(members), **changes,
    }  # fmt: skip


LOOP = cells(cell("A", "1", x=["0", "0"]), cell("B", "1", x=["1", "1"]))
START = {"mode": "A", "values": {"x": "0"}, "params": {}}


def run(last, *steps, start=START):
    """A run; a step is (dwell, edge) or (dwell, edge, values)."""
    listed = [{"dwell": s[0], "edge": s[1], "values": s[2] if len(s) > 2 else {}} for s in steps]
    return {**copy.deepcopy(start), "steps": listed, "last": last}


def sha(value):
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def top_constants(data, value):
    """The top-level constants that a value mentions, transitively."""
    names, grown = set(), True
    while grown:
        seen = json.dumps([value, [c["value"] for c in data["constants"] if c["name"] in names]])
        found = {c["name"] for c in data["constants"] if json.dumps(["const", c["name"]]) in seen}
        grown, names = found != names, found
    return [c for c in data["constants"] if c["name"] in names]


def part_hash(data, owner, aim, kind, where, output):
    model = next(a for a in data["automata"] if a["name"] == owner["on"])
    about = {"goal": aim, "horizon": owner["horizon"], "assume": owner["assume"]}
    m = sha({
        "automaton": model, "constants": top_constants(data, model), "params": data["params"], "enums": data["enums"],
        "assumptions": data["assumptions"],
    })  # fmt: skip
    g = sha({**about, "constants": top_constants(data, about)})
    return sha(["haverify.obligation/1", m, g, kind, where, output])


def part(kind, where, output, **evidence):
    return {"kind": kind, "where": where, "output": output, **evidence}


def on_cells(*parts, start=START, name="c"):
    return {"kind": "cells", "cells": name, "start": start, "parts": list(parts)}


def certificate(data, owner, verdict, *goals, rounding=None):
    """A certificate whose hashes are those of the core."""
    entries = copy.deepcopy(list(goals))
    wide = copy.deepcopy(rounding)
    for given in [entries] + ([wide["goals"]] if wide else []):
        for aim, entry in zip(owner["goals"], given, strict=True):
            if entry.get("kind") in ("run", "inevitable"):
                entry["hash"] = part_hash(data, owner, aim, "goal", "", "")
            for p in entry.get("parts", []):
                p["hash"] = part_hash(data, owner, aim, p["kind"], p["where"], p["output"])
    return {
        "schema": "haverify.certificate/1", "claim": owner["name"], "verdict": verdict, "goals": entries,
        "rounding": wide,
    }  # fmt: skip


def listed(owner, proof, trust="checked"):
    """A claim as the report lists it."""
    verdicts = {"proof": "proved", "run": "refuted"}
    parts = [
        {"mode": p["where"], "output": p["output"], "text": "", "margin": None,
         "verdict": next((v for k, v in verdicts.items() if k in p), "unknown")}
        for g in (proof or {"goals": []})["goals"] for p in g.get("parts", [])
    ]  # fmt: skip
    rounding = proof and proof["rounding"] and {"verdict": proof["rounding"]["verdict"], "margin": None}
    return {
        "name": owner["name"], "verdict": proof["verdict"] if proof else "unknown", "trust": trust if proof else None,
        "parts": parts, "rounding": rounding,
    }  # fmt: skip


def write(folder: Path, data, proofs, cell_files=None, inputs=()):
    """A report folder; `proofs` maps claim names to certificates."""
    (folder / "certificates" / "cells").mkdir(parents=True, exist_ok=True)
    stem = {n: n.replace("[", "(").replace("]", ")") for n in proofs}
    for name, proof in proofs.items():
        dump(folder / "certificates" / f"{stem[name]}.json", proof)
    for name, value in (cell_files or {"c": LOOP}).items():
        dump(folder / "certificates" / "cells" / f"{name}.json", value)
    claims = [listed(c, proofs.get(c["name"])) for c in data["claims"]]
    dump(folder / "report.json", {"schema": "haverify.report/1", "inputs": list(inputs), "claims": claims})
    dump(folder / "core.json", data)
    return folder


def dump(path: Path, value):
    path.write_text(json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False) + "\n")
