"""Damages of a true report folder: each makes a statement in it false or inconsistent, so a checker must refuse it.

A damage that may leave a true and consistent folder (a wider box that still works, another proof of the same part) is
not made. The list is in a fixed order and depends on the folder alone.
"""

import json
import shutil
from collections.abc import Callable, Collection, Iterator
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

Forge = Callable[[Path], None]
Keys = tuple[str | int, ...]


def copy_of(folder: Path, target: Path) -> Path:
    """A fresh copy of the folder, for one damage."""
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(folder, target)
    return target


class Forger:
    """A copy of a report folder that takes one damage at a time: only what the last one changed is written again."""

    def __init__(self, truth: Path, target: Path) -> None:
        self.copy = copy_of(truth, target)
        self._truth = {p: p.read_bytes() for p in sorted(self.copy.rglob("*")) if p.is_file()}

    def forged(self, forge: Forge) -> Path:
        """The copy with this damage alone."""
        for path, data in self._truth.items():
            if not path.is_file() or path.read_bytes() != data:
                path.write_bytes(data)
        forge(self.copy)
        return self.copy


def damages(folder: Path) -> Iterator[tuple[str, Forge]]:
    """All damages of a folder, each with a name."""
    yield from _report_damages(folder)
    yield from _core_damages(folder)
    for path in sorted((folder / "certificates").glob("*.json")):
        yield from _certificate_damages(path.relative_to(folder), json.loads(path.read_text()))
    for path in sorted((folder / "certificates" / "cells").glob("*.json")):
        yield from _cells_damages(path.relative_to(folder), json.loads(path.read_text()), folder)
    yield from _swaps(folder)


def _edit(path: Path | str, keys: Keys, change: Callable[[object], object]) -> Forge:
    """Replace the value at `keys` of a JSON file; DROP removes it."""

    def forge(folder: Path) -> None:
        file = folder / path
        data = json.loads(file.read_text())
        inner = data
        for k in keys[:-1]:
            inner = inner[k]
        value = change(inner[keys[-1]])
        if value is DROP:
            del inner[keys[-1]]
        else:
            inner[keys[-1]] = value
        file.write_text(json.dumps(data, sort_keys=True, separators=(",", ":")) + "\n")

    return forge


DROP = object()


def _put(path: Path | str, keys: Keys, value: object) -> Forge:
    return _edit(path, keys, lambda _: value)


def _flip(digest: str) -> str:
    return ("0" if digest[0] != "0" else "1") + digest[1:]


def _plus(step: int) -> Callable[[object], object]:
    return lambda q: str(Fraction(str(q)) + step)


def _report_damages(folder: Path) -> Iterator[tuple[str, Forge]]:
    report = json.loads((folder / "report.json").read_text())
    other = {"proved": "refuted", "refuted": "proved", "unknown": "proved"}
    for i, c in enumerate(report["claims"]):
        at, name = ("claims", i), f"report {c['name']}"
        yield f"{name}: verdict", _put("report.json", (*at, "verdict"), other[c["verdict"]])
        yield f"{name}: dropped", _put("report.json", at, DROP)
        yield f"{name}: renamed", _put("report.json", (*at, "name"), c["name"] + "_")
        if c["trust"] != "checked":
            continue
        yield f"{name}: unknown after all", _put("report.json", (*at, "verdict"), "unknown")
        yield f"{name}: trust", _put("report.json", (*at, "trust"), "enclosed")
        rounded = (c.get("rounding") or {}).get("verdict")
        wrong = {"verdict": "refuted" if rounded == "proved" else "proved", "margin": None}
        yield f"{name}: rounding", _put("report.json", (*at, "rounding"), wrong)
        certificate = folder / "certificates" / _file(c["name"])
        if any(g.get("parts") for g in json.loads(certificate.read_text())["goals"]):
            for k, p in enumerate(c["parts"][:6]):
                yield f"{name}: part {k}", _put("report.json", (*at, "parts", k, "verdict"), other[p["verdict"]])
            if c["parts"]:
                yield f"{name}: part dropped", _put("report.json", (*at, "parts", 0), DROP)
    for i, _ in enumerate(report["inputs"]):
        yield f"report input {i}: no hash", _put("report.json", ("inputs", i, "sha256"), DROP)


def _file(claim: str) -> str:
    return claim.replace("[", "(").replace("]", ")") + ".json"


def _core_damages(folder: Path) -> Iterator[tuple[str, Forge]]:
    core = json.loads((folder / "core.json").read_text())
    shown = {p.name for p in (folder / "certificates").glob("*.json")}
    for i, c in enumerate(core["claims"]):
        yield f"core {c['name']}: dropped", _put("core.json", ("claims", i), DROP)
        if _file(c["name"]) in shown:
            at = ("claims", i, "goals", 0, "condition")
            yield f"core {c['name']}: weakened to true", _put("core.json", at, True)
            yield f"core {c['name']}: weakened by an or", _edit("core.json", at, lambda e: ["or", e, ["<", "0", "1"]])
            yield f"core {c['name']}: assumed away", _put("core.json", ("claims", i, "assume"), [["<", "0", "-1"]])
            yield f"core {c['name']}: shorter", _put("core.json", ("claims", i, "horizon", "time"), "1/1000003")
            kinds = {"always": "can_reach", "can_reach": "always", "reach": "always"}
            kind = kinds.get(c["goals"][0]["kind"], "always")
            yield f"core {c['name']}: another kind", _put("core.json", ("claims", i, "goals", 0, "kind"), kind)
    for a, automaton in enumerate(core["automata"]):
        if not any(c["on"] == automaton["name"] and _file(c["name"]) in shown for c in core["claims"]):
            continue
        for m, mode in enumerate(automaton["modes"]):
            at = ("automata", a, "modes", m)
            yield f"core mode {mode['name']}: domain", _put("core.json", (*at, "domain"), False)
            yield f"core mode {mode['name']}: dropped", _put("core.json", at, DROP)
        for k, edge in enumerate(automaton["edges"]):
            yield f"core edge {edge['name']}: dropped", _put("core.json", ("automata", a, "edges", k), DROP)
            yield f"core edge {edge['name']}: guard", _put("core.json", ("automata", a, "edges", k, "guard"), False)
        yield f"core {automaton['name']}: no init", _put("core.json", ("automata", a, "init"), [])
    for i, cell in enumerate(core["cells"][:40]):
        where = {c["name"]: k for k, c in enumerate(core["constants"])}
        if cell["constant"] in where:
            at = ("constants", where[cell["constant"]], "value")
            yield f"core {cell['constant']}: other than its cell", _edit("core.json", at, _plus(1))
        yield f"core cell {i}: number", _edit("core.json", ("cells", i, "number"), _plus(1))


def _certificate_damages(path: Path, data: dict) -> Iterator[tuple[str, Forge]]:
    name = path.stem
    yield f"{name}: removed", lambda folder: (folder / path).unlink()
    for key, value in (("schema", "haverify.certificate/2"), ("claim", "another"), ("goals", [])):
        yield f"{name}: {key}", _put(path, (key,), value)
    other = "refuted" if data["verdict"] == "proved" else "proved"
    yield f"{name}: verdict", _put(path, ("verdict",), other)
    yield f"{name}: a goal more", _edit(path, ("goals",), lambda goals: [*goals, {}])
    for i, entry in enumerate(data["goals"]):
        yield from _entry_damages(f"{name} goal {i}", path, ("goals", i), entry)
    rounding = data["rounding"] or {"verdict": "unknown", "goals": []}
    runs = sum("run" in p for entry in rounding["goals"] for p in entry.get("parts", []))
    for i, entry in enumerate(rounding["goals"]):
        # one run refutes for all: the report says nothing of single parts here, so the others may go
        spare = {"run"} if runs > 1 else set()
        spare |= {"proof"} if rounding["verdict"] == "refuted" else set()
        yield from _entry_damages(f"{name} rounded goal {i}", path, ("rounding", "goals", i), entry, spare)


def _entry_damages(
    name: str, path: Path, at: Keys, entry: dict, spare: Collection[str] = ()
) -> Iterator[tuple[str, Forge]]:
    if not entry:
        return
    yield f"{name}: kind", _put(path, (*at, "kind"), "belief")
    if "hash" in entry:
        yield f"{name}: hash", _put(path, (*at, "hash"), _flip(entry["hash"]))
    proved = entry["kind"] == "inevitable" or any("proof" in p for p in entry.get("parts", []))
    if proved:
        yield f"{name}: no such cells", _put(path, (*at, "cells"), "nowhere")
        yield f"{name}: cells from elsewhere", _put(path, (*at, "cells"), "../cells/x")
        yield f"{name}: start in no mode", _put(path, (*at, "start", "mode"), "nowhere")
        for v in entry["start"]["values"]:
            yield f"{name}: start without {v}", _put(path, (*at, "start", "values", v), DROP)
        for p in entry["start"]["params"]:
            yield f"{name}: start param {p}", _put(path, (*at, "start", "params", p), str(10**9))
    if "run" in entry:
        yield from _run_damages(name, path, (*at, "run"), entry["run"])
    listed = entry.get("parts", [])
    for k, p in enumerate(listed[:8]):
        yield from _part_damages(f"{name} part {k}", path, (*at, "parts", k), p, spare)
    if len(listed) > 1:
        yield f"{name}: parts swapped", _edit(path, (*at, "parts"), lambda ps: [ps[1], ps[0], *ps[2:]])
        yield f"{name}: a part twice", _edit(path, (*at, "parts"), lambda ps: [*ps, ps[0]])


def _part_damages(name: str, path: Path, at: Keys, part: dict, spare: Collection[str]) -> Iterator[tuple[str, Forge]]:
    yield f"{name}: dropped", _put(path, at, DROP)
    yield f"{name}: hash", _put(path, (*at, "hash"), _flip(part["hash"]))
    for key in ("kind", "where", "output"):
        yield f"{name}: {key}", _put(path, (*at, key), part[key] + "?")
    if "run" in part:
        if "run" not in spare:
            yield f"{name}: no run", _put(path, (*at, "run"), DROP)
        yield from _run_damages(name, path, (*at, "run"), part["run"])
    if "proof" not in part:
        return
    if "proof" not in spare:
        yield f"{name}: no proof", _put(path, (*at, "proof"), DROP)
    for t, tree in enumerate(part["proof"][:3] if part["kind"] != "stuck" else []):
        here = (*at, "proof", t)
        yield f"{name} tree {t}: dropped", _put(path, here, DROP)
        yield f"{name} tree {t}: a word", _put(path, here, "true")
        yield f"{name} tree {t}: unknown variable", _edit(path, here, lambda old: ["s", "?", "0", old, old])
        yield f"{name} tree {t}: split outside", _edit(path, here, lambda old: ["s", "@s", str(-(10**9)), old, old])
        if isinstance(tree, list):
            yield f"{name} tree {t}: a leaf dropped", _edit(path, here, lambda old: old[:-1])


def _run_damages(name: str, path: Path, at: Keys, run: dict) -> Iterator[tuple[str, Forge]]:
    yield f"{name} run: negative end", _put(path, (*at, "last"), "-1")
    yield f"{name} run: end at 1/0", _put(path, (*at, "last"), "1/0")
    yield f"{name} run: mode", _put(path, (*at, "mode"), "nowhere")
    for v in run["values"]:
        yield f"{name} run: {v} far away", _put(path, (*at, "values", v), str(10**12 + 7))
        yield f"{name} run: without {v}", _put(path, (*at, "values", v), DROP)
    for p in run["params"]:
        yield f"{name} run: param {p}", _put(path, (*at, "params", p), str(10**12 + 7))
    for k, _ in enumerate(run["steps"][:3]):
        yield f"{name} run step {k}: negative dwell", _put(path, (*at, "steps", k, "dwell"), "-1")
        yield f"{name} run step {k}: edge", _put(path, (*at, "steps", k, "edge"), 10**6)
        yield f"{name} run step {k}: edge from behind", _put(path, (*at, "steps", k, "edge"), -1)
        extra = {"no such variable": "0"}
        yield f"{name} run step {k}: values", _put(path, (*at, "steps", k, "values"), extra)


def _cells_damages(path: Path, data: dict, folder: Path) -> Iterator[tuple[str, Forge]]:
    name = f"cells {path.stem}"
    used = any(f'"cells":"{path.stem}"' in p.read_text() for p in (folder / "certificates").glob("*.json"))
    if not used:
        return
    yield f"{name}: schema", _put(path, ("schema",), "haverify.cells/2")
    yield f"{name}: automaton", _put(path, ("automaton",), "another")
    yield f"{name}: time is tracked or not", _edit(path, ("rho",), lambda rho: not rho)
    yield f"{name}: none", _put(path, ("cells",), [])
    for i, cell in enumerate(data["cells"][:10]):
        at = ("cells", i)
        yield f"{name} {i}: mode", _put(path, (*at, "mode"), "nowhere")
        yield f"{name} {i}: negative dwell", _put(path, (*at, "dwell"), "-1")
        yield f"{name} {i}: dropped", _put(path, at, DROP)
        for v, (low, high) in cell["entry"].items():
            yield f"{name} {i}: without {v}", _put(path, (*at, "entry", v), DROP)
            if low is not None and high is not None:
                turned = [str(Fraction(high) + 1), low]
                yield f"{name} {i}: {v} backwards", _put(path, (*at, "entry", v), turned)
                moved = [str(Fraction(high) + 10**6)] * 2
                yield f"{name} {i}: {v} elsewhere", _put(path, (*at, "entry", v), moved)


def _swaps(folder: Path) -> Iterator[tuple[str, Forge]]:
    files = sorted(p.relative_to(folder) for p in (folder / "certificates").glob("*.json"))
    for a, b in pairwise(files):
        yield f"swapped {a.stem} and {b.stem}", _swap(a, b)
        yield f"{a.stem} with the goals of {b.stem}", _goals_of(a, b)


def _swap(a: Path, b: Path) -> Forge:
    def forge(folder: Path) -> None:
        first, second = (folder / a).read_bytes(), (folder / b).read_bytes()
        (folder / a).write_bytes(second)
        (folder / b).write_bytes(first)

    return forge


def _goals_of(a: Path, b: Path) -> Forge:
    def forge(folder: Path) -> None:
        first, second = json.loads((folder / a).read_text()), json.loads((folder / b).read_text())
        (folder / a).write_text(json.dumps({**second, "claim": first["claim"]}))

    return forge
