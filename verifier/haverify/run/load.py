"""Reading a spec with everything it refers to: the only place that opens the inputs of a check."""

from __future__ import annotations

from pathlib import Path
from stat import S_ISDIR, S_ISREG

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.elaborate.files import Files
from haverify.syntax import tree as t
from haverify.syntax.parse import parse
from haverify.text.record import field, holder, record
from haverify.text.source import Source
from haverify.text.span import Span

MAX_BYTES = 64_000_000


@record
class Loaded:
    """A spec as read: its tree, what it refers to, and all texts by path shown (data files included)."""

    source: Source
    tree: t.Tree
    files: Files
    sources: dict[str, Source] = field(default_factory=dict)


@holder
class _Reading:
    trees: dict[tuple[str, str], t.Tree] = field(default_factory=dict)
    data: dict[tuple[str, str], Source] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    parsed: dict[str, t.Tree] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)


def load(path: str | Path) -> tuple[Loaded | None, list[Diagnostic]]:
    """The spec at `path` with its imports and data files; None when the file itself cannot be read."""
    shown = Path(path).as_posix()
    work = _Reading()
    problem, source = read_text(shown)
    if source is None:
        return None, [Diagnostic("HA006", f"cannot read {shown}: {problem}", None)]
    tree = _parse(work, source)
    _follow(work, tree, (shown,))
    files = Files(work.sources, work.trees, work.data)
    return Loaded(source, tree, files, work.sources), work.diagnostics


def _parse(work: _Reading, source: Source) -> t.Tree:
    work.sources[source.path] = source
    tree, found = parse(source)
    work.diagnostics += found
    work.parsed[source.path] = tree
    return tree


def read_text(path: str) -> tuple[str, Source | None]:
    """A text file, or why it is none: missing, too large, not UTF-8, binary."""
    problem, raw = read_bytes(path)
    if problem:
        return problem, None
    if b"\0" in raw:
        return "it is a binary file", None
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        return f"byte {e.start} is not UTF-8", None
    return "", Source(path, text.replace("\r\n", "\n").replace("\r", "\n"), raw)


def read_bytes(path: str) -> tuple[str, bytes]:
    """The bytes of a regular file, or why there are none: a pipe or a device might never end."""
    try:
        status = Path(path).stat()
        if S_ISDIR(status.st_mode):
            return "it is a directory", b""
        if not S_ISREG(status.st_mode):
            return "it is not a regular file", b""
        with Path(path).open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except OSError as e:
        return (e.strerror or "unreadable").lower(), b""
    except ValueError:
        return "not a path", b""
    return ("", raw) if len(raw) <= MAX_BYTES else (f"it has more than {MAX_BYTES // 1_000_000} MB", b"")


def _beside(importer: str, path: str) -> str:
    return (Path(importer).parent / path).as_posix()


def _follow(work: _Reading, tree: t.Tree, chain: tuple[str, ...]) -> None:
    for item in tree.items:
        body = item.body
        if isinstance(body, t.Import):
            _import(work, tree, body, chain)
        elif isinstance(body, t.Table):
            _data(work, tree, body.path, body.path_span)
        elif isinstance(body, t.Network):
            _network(work, tree, body)


def _is_named(work: _Reading, path: str, span: Span) -> bool:
    """Whether a file is named at all; HA006 where none is."""
    if not path.strip():
        work.diagnostics.append(Diagnostic("HA006", "the file name is empty", span))
    return bool(path.strip())


def _import(work: _Reading, tree: t.Tree, decl: t.Import, chain: tuple[str, ...]) -> None:
    if not _is_named(work, decl.path, decl.path_span):
        return
    place = _beside(tree.path, decl.path)
    normal = _normal(place)
    if normal in [_normal(c) for c in chain]:
        names = [Path(c).name for c in (*chain, place)]
        work.diagnostics.append(Diagnostic("HA006", " imports ".join(names), decl.path_span))
        return
    known = next((p for p in work.parsed if _normal(p) == normal), None)
    if known is not None:
        work.trees[(tree.path, decl.path)] = work.parsed[known]
        return
    source = _source(work, place, decl.path, decl.path_span)
    if source is not None:
        inner = _parse(work, source)
        work.trees[(tree.path, decl.path)] = inner
        _follow(work, inner, (*chain, place))


def _normal(path: str) -> str:
    return Path(path).resolve().as_posix()


def _source(work: _Reading, place: str, written: str, span: Span) -> Source | None:
    if place in work.sources:
        return work.sources[place]
    problem, source = read_text(place)
    if source is None:
        work.diagnostics.append(Diagnostic("HA006", f"cannot read {written}: {problem}", span))
        return None
    work.sources[place] = source
    return source


def _data(work: _Reading, tree: t.Tree, path: str, span: Span) -> None:
    source = _source(work, _beside(tree.path, path), path, span) if _is_named(work, path, span) else None
    if source is not None:
        work.data[(tree.path, path)] = source


def _network(work: _Reading, tree: t.Tree, decl: t.Network) -> None:
    if not _is_named(work, decl.path, decl.path_span):
        return
    place = _beside(tree.path, decl.path)
    problem, raw = read_bytes(place)
    if problem:
        work.diagnostics.append(Diagnostic("HA006", f"cannot read {decl.path}: {problem}", decl.path_span))
        return
    work.data[(tree.path, decl.path)] = Source(place, "", raw)
