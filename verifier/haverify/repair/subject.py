"""A spec with all its texts and what was decided about it: what a repair starts from and is compared with."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property

from haverify.analyses.portfolio import decide_all
from haverify.diagnostics.codes import is_meaningless, severity
from haverify.diagnostics.diagnostic import Diagnostic, Edit, Severity
from haverify.diagnostics.edits import edited_source
from haverify.diagnostics.order import settle
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted
from haverify.lint._registry import run_lint
from haverify.model.claim import Claim
from haverify.model.spec import Spec
from haverify.report.gate import expected, violated
from haverify.syntax import tree as t
from haverify.syntax.parse import parse
from haverify.text.record import field, holder, record
from haverify.text.source import Source

Recorded = Mapping[str, tuple[str, ...]]

_ASIDE = ("HA005", "HA107", "HA215", "HA607", "HA8", "HA9")
"""Findings that are no reason to change a number: names unused, hashes, bookkeeping, what could not be decided."""


@record
class Text:
    """A spec with what it imports and reads, as parsed."""

    tree: t.Tree
    files: Files
    sources: Mapping[str, Source]

    @property
    def trees(self) -> list[t.Tree]:
        """The spec's own tree and those of its imports."""
        return [self.tree, *self.files.trees.values()]


@holder
class Subject:
    """A text, the model it gives, its findings, and the evidence about its claims as far as that was asked for."""

    text: Text
    spec: Spec | None
    found: list[Diagnostic]
    recorded: Recorded
    evidence: dict[str, Evidence] = field(default_factory=dict)

    @property
    def has_meaning(self) -> bool:
        """Whether every part of the spec has one."""
        return self.spec is not None and not any(is_meaningless(d) for d in self.found)

    @cached_property
    def claims(self) -> dict[str, Claim]:
        return {c.name: c for c in self.spec.claims} if self.spec else {}

    @cached_property
    def findings(self) -> dict[str, Diagnostic]:
        """The errors and warnings about the model, by what identifies them when places move."""
        return {f"{d.code}: {d.key or d.message}": d for d in self.found if _counts(d)}

    def lint(self) -> None:
        """Add the findings of the rules, where the spec has a meaning."""
        if self.spec is not None and self.has_meaning:
            self.found = settle([*self.found, *run_lint(self.spec, self.text.sources)])
            self.__dict__.pop("findings", None)

    def decide(self, names: Iterable[str]) -> None:
        """Decide the named claims that are not decided yet."""
        wanted = [n for n in names if n in self.claims and n not in self.evidence]
        if wanted and self.spec is not None:
            self.evidence |= decide_all(self.spec, wanted)

    def verdict(self, name: str) -> str:
        """`proved`, `refuted` or `unknown`."""
        verdict = self.evidence[name].verdict
        return "proved" if isinstance(verdict, Proved) else "refuted" if isinstance(verdict, Refuted) else "unknown"

    def violated(self, name: str) -> tuple[str, ...]:
        """The violated parts of a decided claim; the claim's name where it has no parts."""
        if self.verdict(name) != "refuted":
            return ()
        return violated(self.claims[name], self.evidence[name]) or (name,)

    def broken(self, name: str) -> tuple[str, ...]:
        """The violated parts of a claim that nobody expects to be violated."""
        claim = self.claims[name]
        if expected(claim) == "proved":
            return self.violated(name)
        known = self.recorded.get(name)
        return () if known is None or expected(claim) != "refuted" else tuple(
            p for p in self.violated(name) if p not in known
        )  # fmt: skip

    def is_expected(self, name: str) -> bool:
        """Whether a decided claim came out as its spec expects."""
        wanted = expected(self.claims[name])
        return wanted == "unknown" or (self.verdict(name) == wanted and not self.broken(name))

    def edited(self, edits: Iterable[Edit]) -> Subject:
        """The subject after edits, read anew; neither linted nor decided."""
        return read(edited_text(self.text, list(edits)), self.recorded)


def _counts(d: Diagnostic) -> bool:
    return severity(d) in (Severity.ERROR, Severity.WARNING) and not d.code.startswith(_ASIDE)


def read(text: Text | tuple[Text, list[Diagnostic]], recorded: Recorded) -> Subject:
    """The model of a text with the findings of reading it."""
    whole, found = text if isinstance(text, tuple) else (text, [])
    spec, more = elaborate(whole.tree, whole.files)
    return Subject(whole, spec, [*found, *more], recorded)


def edited_text(text: Text, edits: list[Edit]) -> tuple[Text, list[Diagnostic]]:
    """The text after edits, with the syntax errors they make; hashes of edited data files follow."""
    edits = [*edits, *hash_edits(text, edits)]
    changed = {path: edited_source(source, own) for path, own, source in _by_file(text.sources, edits)}
    sources = {**text.sources, **changed}
    parsed: dict[str, t.Tree] = {}
    found: list[Diagnostic] = []
    for tree in text.trees:
        if tree.path in changed and tree.path not in parsed:
            parsed[tree.path], more = parse(changed[tree.path])
            found += more
    trees = {k: parsed.get(tree.path, tree) for k, tree in text.files.trees.items()}
    data = {k: changed.get(s.path, s) for k, s in text.files.data.items()}
    files = Files({**text.files.sources, **changed}, trees, data)
    return Text(parsed.get(text.tree.path, text.tree), files, sources), found


def _by_file(sources: Mapping[str, Source], edits: list[Edit]) -> Iterator[tuple[str, list[Edit], Source]]:
    for path in dict.fromkeys(e.span.path for e in edits):
        yield path, [e for e in edits if e.span.path == path], sources[path]


def hash_edits(text: Text, edits: list[Edit]) -> list[Edit]:
    """What the lines `sha256 "..."` of edited data files have to say afterwards, where they are right today."""
    found: dict[tuple[str, int], Edit] = {}
    for line, source in pinned(text):
        own = [e for e in edits if e.span.path == source.path]
        if own and line.text == source.sha256:
            new = f'sha256 "{edited_source(source, own).sha256}"'
            found[line.span.path, line.span.start] = Edit(line.span, new)
    return list(found.values())


def pinned(text: Text) -> Iterator[tuple[t.TableLine, Source]]:
    """The lines that record the hash of a data file, each with the file."""
    for tree in text.trees:
        for item in tree.items:
            body = item.body
            source = text.files.data.get((tree.path, body.path)) if isinstance(body, t.Table) else None
            if isinstance(body, t.Table) and source is not None:
                yield from ((line, source) for line in body.lines if line.kind == "sha256")
