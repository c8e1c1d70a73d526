"""A spec read and looked over: its findings, and which of them are accepted and why."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.diagnostics.order import settle
from haverify.errors import UsageError
from haverify.model.spec import Spec
from haverify.report import allow, baseline
from haverify.run import lockfile
from haverify.run.confinement import is_confined
from haverify.syntax.tree import Tree
from haverify.text.record import field, record
from haverify.text.source import Source
from haverify.text.span import Span

if TYPE_CHECKING:
    from datetime import date


@record
class Examined:
    """What was read and found. `spec` is None where the text has no meaning; `accepted` maps findings to reasons.

    `record` holds the entries of the lock file about this spec, which that file calls `name`.
    """

    path: str
    spec: Spec | None
    sources: Mapping[str, Source]
    found: list[Diagnostic]
    accepted: dict[Diagnostic, str]
    record: baseline.Baseline = field(default_factory=baseline.Baseline)
    lock: Path | None = None
    name: str = ""
    is_confined: bool = True  # whether errors without meaning concern only what the model lacks

    @property
    def can_decide(self) -> bool:
        """Whether the claims of the model mean what their author wrote."""
        return self.spec is not None and (self.has_meaning or self.is_confined)

    @property
    def has_meaning(self) -> bool:
        """Whether every part of the spec has a meaning."""
        return self.spec is not None and not any(is_meaningless(d) for d in self.found)

    @property
    def new(self) -> list[Diagnostic]:
        """The findings that no reason accepts."""
        return [d for d in self.found if d not in self.accepted] if self.accepted else list(self.found)


def examine(path: str, lock: Path | None = None, select: tuple[str, ...] = (), use_cache: bool = False) -> Examined:
    """Read a spec and lint it; with `select`, only findings whose code starts so are kept.

    With `use_cache`, rules look at a spec that they have seen before only once.

    Raises
    ------
    UsageError      if the spec or its lock file cannot be read
    """
    spec, sources, found, trees = _read(path)
    if spec is not None and not any(is_meaningless(d) for d in found):
        found += _linted(spec, sources, use_cache)
    confined = spec is not None and is_confined(spec, found, trees)
    kept = [d for d in settle(found) if _selected(d, select)]
    return _with_reasons(Examined(path, spec, sources, kept, {}, is_confined=confined), lock, bool(select))


def _linted(spec: Spec, sources: Mapping[str, Source], use_cache: bool) -> list[Diagnostic]:
    def look() -> list[Diagnostic]:
        from haverify.lint._registry import run_lint

        return run_lint(spec, sources)

    if not use_cache:
        return look()
    from haverify.run.findings_cache import found_once

    return found_once(sources, look)


def read(path: str) -> tuple[Spec | None, dict[str, Source], list[Diagnostic]]:
    """The model of a spec, all texts it came from by path, and what is wrong with it; None where there is no model.

    Raises
    ------
    UsageError      if the file itself cannot be read
    """
    return _read(path)[:3]


def _read(path: str) -> tuple[Spec | None, dict[str, Source], list[Diagnostic], list[Tree]]:
    from haverify.elaborate.elaborate import elaborate
    from haverify.run.load import load

    loaded, found = load(os.path.relpath(path))
    if loaded is None:
        raise UsageError(found[0].message)
    spec, more = elaborate(loaded.tree, loaded.files)
    others = {s.path: s for s in loaded.files.data.values()}
    trees = [loaded.tree, *loaded.files.trees.values()]
    return spec, {**others, **loaded.sources}, [*found, *_independent(more, found, trees)], trees


_SYNTAX = ("HA001", "HA003")
_UNUSED = ("HA005", "HA107")


def _independent(more: list[Diagnostic], found: list[Diagnostic], trees: Sequence[Tree]) -> list[Diagnostic]:
    """The findings about meaning that what could not be read did not cause.

    A name may be declared or used in a file that is missing, or where the text is broken; a declaration with an error
    in its text is no longer as its author wrote it.
    """
    if not found:
        return more
    places = [d.span for d in found if d.code in _SYNTAX and d.span is not None]
    silent = (*_UNUSED, "HA002") if places else _UNUSED
    broken = [i.span for tree in trees for i in tree.items if any(_holds(i.span, p) for p in places)]
    return [d for d in more if d.code not in silent and not any(d.span and _holds(b, d.span) for b in broken)]


def _holds(outer: Span, inner: Span) -> bool:
    return outer.path == inner.path and outer.start <= inner.start <= outer.end


def _selected(d: Diagnostic, select: tuple[str, ...]) -> bool:
    return not select or is_meaningless(d) or d.code.startswith(select)


def _today() -> date:
    from datetime import date

    return date.today()


def _with_reasons(e: Examined, lock: Path | None, is_partial: bool) -> Examined:
    """The same with what `@allow` and the lock file accept, and findings about these two."""
    file = lock or lockfile.nearest(Path(e.path))
    sources, record, name = dict(e.sources), baseline.Baseline(), ""
    if file is not None:
        everything, source = lockfile.read(file)
        name = lockfile.name_in(file, Path(e.path))
        record, sources[source.path] = everything.of(name), source
    today = _today() if any(x.expires for x in record.findings) else None
    allowed = e.spec.allowed if e.spec else ()
    accepted = allow.allow(e.found, allowed)
    others = [d for d in e.found if d not in accepted]
    accepted |= baseline.accept(others, record.findings, sources, today)
    about = []
    if e.spec is not None and e.has_meaning and not is_partial:
        claims = {c.name for c in e.spec.claims if c.expect and c.expect.verdict == "refuted"}
        about = allow.about(allowed, e.found) + baseline.stale(record, others, claims, sources, today)
    found = settle([*e.found, *about])
    return Examined(e.path, e.spec, sources, found, accepted, record, file, name, e.is_confined)
