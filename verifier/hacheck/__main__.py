"""`python -m hacheck DIR [--json] [--no-report] [--inputs BASE] [--strict]`: does the evidence show the verdicts?"""

from __future__ import annotations

import atexit
import gc
import json
import os
import sys
from typing import Any

from hacheck.core import NAME, Core, by_name, check_cells, check_inputs, check_shape, read_json
from hacheck.obligations import Setting, established
from hacheck.rational import MAX_BITS, Beyond, Refused, Unreadable

Json = Any
SIGNS = {"and": " and ", "or": " or ", "implies": " implies ", "+": " + ", "-": " - ", "*": "*", "/": "/", "^": "^"}
REPORT = [{"name": str, "verdict": str, "trust": (str, type(None)), "rounding": (dict, type(None)),
           "parts": [{"mode": str, "output": str, "verdict": str}]}]  # fmt: skip


def text(e: Json) -> str:
    """An expression of the core as people read it."""
    if not isinstance(e, list) or not e or not isinstance(e[0], str):
        return str(e).lower() if isinstance(e, bool) else str(e)
    op, args = e[0], e[1:]
    if op in ("const", "param", "input", "var", "let", "bound") and len(args) == 1:
        return str(args[0])
    shown = [text(a) for a in args]
    if len(args) > 1 and (op in SIGNS or op in ("<", "<=", ">", ">=", "==", "!=")):
        return "(" + SIGNS.get(op, f" {op} ").join(shown) + ")"
    return f"{op}({', '.join(shown)})" if args else op


def understood(claim: Json, assumed: list[Json]) -> str:
    """A claim as this checker understood it, with all that is assumed."""
    goals = []
    for g in claim["goals"]:
        during = f" during [{', '.join(map(text, g['window']))}]" if g["window"] else ""
        within = f" within {text(g['within'])}" if g["within"] is not None else ""
        more = " attracting" if g.get("attracting", False) is not False else ""
        goals.append(f"{g['kind']}{during} {text(g['condition'])}{within}{more}")
    limits = [text(claim["horizon"]["time"]) + " s"] if claim["horizon"]["time"] is not None else []
    limits += [f"{claim['horizon']['jumps']} jumps"] if claim["horizon"]["jumps"] is not None else []
    extra = "".join(f"; assume {text(a)}" for a in assumed + claim["assume"])
    return f"on {claim['on']}: {'; '.join(goals)}{'; within ' if limits else ''}{', '.join(limits)}{extra}"


class Check:
    """One report folder: what it claims, and what of that is shown."""

    def __init__(self, folder: str, with_report: bool) -> None:
        self.folder = folder
        self.core = Core(read_json(os.path.join(folder, "core.json")))
        self.report: Json = None
        self.listed: dict[str, Json] = {}
        if with_report:
            self.report = read_json(os.path.join(folder, "report.json"))
            check_shape(self.report, {"claims": REPORT, "inputs": list}, "report")
            self.listed = by_name(self.report["claims"], "claims of the report")
        certificates = os.path.join(folder, "certificates")
        if os.path.islink(certificates) or os.path.islink(os.path.join(certificates, "cells")):
            raise Unreadable("the certificates are elsewhere")
        found = os.listdir(certificates) if os.path.isdir(certificates) else []
        self.present = {n.removesuffix(".json") for n in found if n.endswith(".json")}
        self._settings: dict[tuple[int, bool], Setting] = {}
        self._systems: dict[str, Any] = {}
        self._lemmas, self._open = set[str](), set[str]()

    def setting(self, automaton: Json, rounding: bool) -> Setting:
        """What the claims on an automaton share."""
        key = (id(automaton), rounding)
        if key not in self._settings:
            self._settings[key] = Setting(self.core, automaton, rounding, self.load_cells, self.lemma)
        return self._settings[key]

    def system(self, system: Json) -> Any:
        """What the claims on a system share."""
        from hacheck.systems import SystemCheck

        if system["name"] not in self._systems:
            self._systems[system["name"]] = SystemCheck(self.core, system, self.load_cells, self.lemma)
        return self._systems[system["name"]]

    def lemma(self, name: str) -> Json:
        """A claim that its own certificate proves, and not by way of itself."""
        if name in self._open or name not in self.core.claims:
            raise Refused(f"the invariant {name[:60]!a} uses itself, or is none")
        if name not in self._lemmas:
            self._open.add(name)
            try:
                found = self._established(self.core.claims[name])
            finally:
                self._open.discard(name)
            if found is None or found[0] != "proved":
                raise Refused(f"the invariant {name[:60]!a} is used and not proved")
            self._lemmas.add(name)
        return self.core.claims[name]

    def load_cells(self, name: str) -> Json:
        """A file of cells."""
        if not NAME.fullmatch(name.replace("(", "[").replace(")", "]")):
            raise Refused("cells have a name that is none")
        return read_json(os.path.join(self.folder, "certificates", "cells", f"{name}.json"))

    def inputs(self, base: str) -> str:
        """The table numbers, the hashes of the inputs, and that report and core speak of the same claims."""
        found = "" if self.report is None else check_inputs(self.report["inputs"], base) + "; "
        names = None if self.report is None else [str(i["path"]) for i in self.report["inputs"]]
        if self.report is not None and sorted(c["name"] for c in self.report["claims"]) != sorted(self.core.claims):
            raise Refused("the report speaks of other claims than the core")
        stray = self.present - {file_name(n) for n in self.core.claims}
        if stray:
            raise Refused(f"a certificate of no claim: {min(stray)[:60]!a}")
        return found + check_cells(self.core, names, base)

    def claim(self, claim: Json) -> dict[str, Json]:
        """The outcome for one claim."""
        said = self.listed.get(claim["name"])
        verdict = said["verdict"] if said else None
        try:
            shown = self._established(claim)
        except (Refused, Unreadable, RecursionError, MemoryError, KeyError, IndexError, TypeError, ValueError,
                AttributeError, ArithmeticError) as e:  # fmt: skip
            why = str(e) if isinstance(e, (Refused, Unreadable)) else f"malformed ({type(e).__name__})"
            lower = said is None or (verdict in ("proved", "refuted") and said["trust"] in ("enclosed", "solver"))
            trusted = lower and isinstance(e, Beyond)
            return {"outcome": "beyond" if trusted else "refused", "reason": why[:300], "verdict": verdict}
        return self._compare(said, shown)

    def understood(self, name: str) -> str:
        """What a claim was understood as, if that can be printed."""
        try:
            return understood(self.core.claims[name], self.core.data["assumptions"])
        except (RecursionError, TypeError, AttributeError):
            return "(too deep or malformed to print)"

    def _established(self, claim: Json) -> Json:
        if file_name(claim["name"]) not in self.present:
            return None
        certificate = read_json(os.path.join(self.folder, "certificates", f"{file_name(claim['name'])}.json"))
        return established(self.core, claim, certificate, self.setting, self.system)

    def _compare(self, said: Json, shown: Json) -> dict[str, Json]:
        verdict = said["verdict"] if said else shown[0] if shown else None
        out = {"outcome": "accepted", "reason": "", "verdict": verdict}
        if said is None:
            return out if shown else {**out, "outcome": "absent", "reason": "no certificate"}
        decided = verdict in ("proved", "refuted")
        rounded = (said["rounding"] or {}).get("verdict")
        parts = sorted((p["mode"], p["output"], p["verdict"]) for p in said["parts"])
        if not decided and not shown:
            stated = {rounded, *(p[2] for p in parts)} & {"proved", "refuted"}
            good = verdict == "unknown" and said["trust"] is None and not stated
            kind, reason = ("absent", "nothing to show") if good else ("refused", "a wrong verdict")
            return {**out, "outcome": kind, "reason": reason}
        if shown is None:
            lower = said["trust"] in ("enclosed", "solver")
            return {**out, "outcome": "beyond" if lower else "refused", "reason": "no certificate"}
        listed = sorted(shown[2]), sorted(p for p in shown[2] if p[:2] != ("", ""))  # whole goals need not be listed
        wrong = [what for what, bad in (
            ("the certificate establishes another verdict than the report states", shown[0] != verdict),
            ("the report states another trust than `checked`", said["trust"] != "checked"),
            ("the rounding verdict is another", (rounded if rounded in ("proved", "refuted") else None) != shown[1]),
            ("the parts of the report are others", parts not in listed)) if bad]  # fmt: skip
        return {**out, "outcome": "refused", "reason": wrong[0]} if wrong else out


def file_name(claim: str) -> str:
    """The stem of a claim's certificate."""
    return claim.replace("[", "(").replace("]", ")")


def exit_code(outcomes: dict[str, Json], inputs: Json, strict: bool) -> int:
    """0: all verdicts are shown or listed as beyond; 1: one is not; 5: there are none."""
    kinds = {o["outcome"] for o in outcomes.values()}
    if inputs["outcome"] == "refused" or "refused" in kinds or (strict and "beyond" in kinds):
        return 1
    return 0 if kinds & {"accepted", "beyond"} else 5


def run(folder: str, base: str, options: set[str]) -> int:
    """Check a folder and print what was found."""
    check = Check(folder, "--no-report" not in options)
    try:
        inputs = {"outcome": "accepted", "reason": check.inputs(base)}
    except (Refused, Unreadable) as e:
        inputs = {"outcome": "refused", "reason": str(e)[:300]}
    outcomes = {name: check.claim(c) for name, c in check.core.claims.items()}
    if "--json" in options:
        print(json.dumps({"claims": outcomes, "inputs": inputs}, indent=1, sort_keys=True))
    else:
        for name, o in outcomes.items():
            print(clean(f"{o['outcome']:9} {name} {o['verdict'] or ''}{': ' if o['reason'] else ''}{o['reason']}"))
            print(f"          {clean(check.understood(name))[:2000]}")
        print(f"{inputs['outcome']:9} inputs: {clean(inputs['reason'])}")
    return exit_code(outcomes, inputs, "--strict" in options)


def clean(message: str) -> str:
    """A message as one line of plain characters."""
    return message.encode("ascii", "backslashreplace").decode().translate(dict.fromkeys([*range(32), 127], "?"))


def main(arguments: list[str] | None = None) -> int:
    """The command line; everything that is no answer is exit code 2 and one line."""
    gc.disable()
    atexit.register(gc.freeze)  # what is left ends with the process
    sys.set_int_max_str_digits(MAX_BITS)
    sys.setrecursionlimit(3000)
    words = list(sys.argv[1:] if arguments is None else arguments)
    base = ""
    if "--inputs" in words[:-1]:
        base = words.pop(words.index("--inputs") + 1)
        words.remove("--inputs")
    options, folders = {w for w in words if w.startswith("--")}, [w for w in words if not w.startswith("--")]
    if len(folders) != 1 or options - {"--json", "--no-report", "--strict"}:
        print("usage: python -m hacheck DIR [--json] [--no-report] [--inputs BASE] [--strict]", file=sys.stderr)
        return 2
    try:
        return run(folders[0], base, options)
    except (Unreadable, Refused, RecursionError, MemoryError, OSError, ValueError, KeyError, TypeError,
            IndexError) as e:  # fmt: skip
        why = str(e) if isinstance(e, (Unreadable, Refused)) else f"malformed ({type(e).__name__})"
        print(f"hacheck: {clean(why)[:300]}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
