"""The style sheets, as they lie beside this module."""

from __future__ import annotations

from pathlib import Path


def page_css() -> str:
    """The style of the page and its figures."""
    return _read("page.css") + figure_css()


def figure_css() -> str:
    """The style of a figure alone."""
    return _read("figure.css")


def standalone(svg: str) -> str:
    """A figure as a file of its own: with its style, and text in a font of its own size."""
    head, _, rest = svg.partition(">")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{head}><style>{_SCREEN}{figure_css()}</style>{rest}\n'


_SCREEN = (
    ":root{--ink:#1b2430;--soft:#5b6675;--line:#c9d1da;--rule:#e3e8ee;--band0:#f4f6f9;--band1:#e9eef4;"
    "--blue:#1f5fa8;--red:#b3261e;--green:#1c7a4a;--paper:#fff}svg{background:#fff}"
)


def _read(name: str) -> str:
    return (Path(__file__).parent / name).read_text(encoding="utf-8")
