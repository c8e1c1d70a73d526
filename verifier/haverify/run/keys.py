"""Hashes of what verdicts depend on: for the cache, and the reproducibility hash of a report."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any

from haverify.report.version import LANGUAGE, VERSION

_ALWAYS = ("units", "enums", "params", "inputs", "tables", "networks", "assumptions", "relations")
_MOST_SOURCE = 1 << 20  # bytes of a module
_FAMILIES = ("automata", "systems", "cellular", "fuzzy")


def digest(value: Any) -> str:
    """SHA-256 of the canonical JSON of a value."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


@cache
def code_hash() -> str:
    """SHA-256 over the source of haverify and hacheck: evidence from other code is not reused."""
    total = hashlib.sha256()
    root = os.path.dirname(os.path.dirname(os.path.dirname(__file__)))
    for package in ("haverify", "hacheck"):
        for path in sorted(_sources(os.path.join(root, package))):
            total.update(f"\0{path.removeprefix(root)}\0".encode())
            total.update(_content(path))
    return total.hexdigest()


def _content(path: str) -> bytes:
    """A module's source; there are hundreds, and this is the quickest way to read them."""
    handle = os.open(path, os.O_RDONLY)
    try:
        return os.read(handle, _MOST_SOURCE)
    finally:
        os.close(handle)


def _sources(folder: str) -> Iterator[str]:
    """The modules below a folder."""
    for at, folders, files in os.walk(folder):
        if "__pycache__" in folders:
            folders.remove("__pycache__")
        yield from (f"{at}/{name}" for name in files if name.endswith(".py"))


def reproducibility(core: str, inputs: Iterable[str], options: Mapping[str, str], versions: Mapping[str, str]) -> str:
    """The hash of a report: core, contents of all files, options, language and tool versions."""
    return digest([core, sorted(inputs), dict(options), LANGUAGE, VERSION, dict(versions)])


class Cones:
    """What each claim of a core depends on: the model it is about, and the claim itself with what it uses."""

    def __init__(self, core: Mapping[str, Any], versions: Mapping[str, str]) -> None:
        self._constants = {c["name"]: c for c in core["constants"]}
        self._claims = {c["name"]: c for c in core["claims"]}
        self._shared = [{key: core.get(key) for key in _ALWAYS}, dict(versions), VERSION]
        self._automata = {a["name"]: a for a in core["automata"]}
        self._rest = {key: core.get(key) for key in _FAMILIES}
        self._models: dict[str | None, str] = {}
        self._inner: dict[str, set[str]] = {}  # constants that the value of one mentions

    def model(self, claim: str) -> str:
        """The key of the model a claim is about: its automaton with the constants it mentions, else everything."""
        on = self._claims[claim]["on"]
        if on not in self._models:
            about = self._automata.get(on, self._rest)
            self._models[on] = digest([self._shared, about, self._mentioned(about)])
        return self._models[on]

    def claim(self, name: str) -> str:
        """The key of a claim: what it says and uses, without what it expects."""
        asked = [{**self._claims[n], "expect": None} for n in self._uses(name)]
        return digest([asked, self._mentioned(asked)])

    def _uses(self, name: str) -> list[str]:
        found = [name]
        for n in found:
            found += [u for u in self._claims[n]["using"] if u in self._claims and u not in found]
        return found

    def _mentioned(self, value: Any) -> list[Any]:
        """The constants that occur in a value, or in one of these, in order of name."""
        names = _constants(value)
        waiting = list(names)
        while waiting:
            found = self._within(waiting.pop()) - names
            names |= found
            waiting += found
        return [self._constants[n] for n in sorted(names) if n in self._constants]

    def _within(self, name: str) -> set[str]:
        if name not in self._inner:
            self._inner[name] = _constants(self._constants.get(name))
        return self._inner[name]


def _constants(value: Any) -> set[str]:
    """The names in `["const", name]` nodes of a JSON value."""
    found = set()
    stack = [value]
    while stack:
        v = stack.pop()
        if isinstance(v, dict):
            stack.extend(v.values())
        elif isinstance(v, (list, tuple)):
            if len(v) == 2 and v[0] == "const" and isinstance(v[1], str):
                found.add(v[1])
            stack.extend([x for x in v if x.__class__ is not str])
    return found
