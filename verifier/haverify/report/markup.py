"""Text within XML and HTML: whatever a spec contains is shown, never obeyed."""

from __future__ import annotations

_SIGNS = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;"}

# What XML 1.0 has no place for: control characters but tab and line ends, halves of pairs, two that are no characters.
_FOREIGN = [*range(9), 11, 12, *range(14, 32), *range(127, 160), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF]
_TURNS = [*range(0x202A, 0x202F), *range(0x2066, 0x206A)]  # they would reorder the text around them
_UNSEEN = dict.fromkeys([*_FOREIGN, *_TURNS], "\N{REPLACEMENT CHARACTER}")
_TABLE = {ord(sign): text for sign, text in _SIGNS.items()} | _UNSEEN


def escape(text: str) -> str:
    """`text` as content of an element or of an attribute in quotes.

    >>> escape('a < b & "c"\\x00')
    'a &lt; b &amp; &quot;c&quot;\N{REPLACEMENT CHARACTER}'
    """
    return text.translate(_TABLE)


def visible(text: str) -> str:
    """`text` with a sign for each character that would be obeyed rather than shown."""
    return text.translate(_UNSEEN)


def clipped(text: str, most: int) -> str:
    """`text`, or its beginning and how much is left out.

    >>> clipped("abcdef", 4)
    'abcd ... (2 more characters)'
    """
    return text if len(text) <= most else f"{text[:most]} ... ({len(text) - most} more characters)"
