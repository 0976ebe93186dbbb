"""How results show themselves in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

#: Height of a page in a notebook, pixels: a guess at what a screen of a laptop shows beside a cell.
_HEIGHT = 560


def framed(page: str, title: str) -> str:
    """A page in a frame of its own, whose scripts reach nothing around it."""
    from html import escape

    return (
        f'<iframe title="{escape(title)}" sandbox="allow-scripts" loading="lazy" '
        f'style="width: 100%; height: {_HEIGHT}px; border: 0" srcdoc="{escape(page)}"></iframe>'
    )


class Bar(NamedTuple):
    """A stretch of time in a table, drawn."""

    began: float
    ended: float
    whole: float
    failed: bool = False

    def html(self) -> str:
        if self.whole <= 0:
            return ""
        left, width = (100 * seconds / self.whole for seconds in (self.began, self.ended - self.began))
        colour = "#c0392b" if self.failed else "#4a78b0"
        # What is too short to be seen is a hair wide all the same.
        return (
            '<div style="width: 16em; height: 0.7em; background: rgba(128, 128, 128, 0.15)">'
            f'<div style="margin-left: {left:.2f}%; width: {width:.2f}%; min-width: 1px; height: 100%; '
            f'background: {colour}"></div></div>'
        )


def table(head: list[str], rows: Sequence[Sequence[str | Bar]], caption: str = "") -> str:
    """A table of texts, and of stretches of time."""
    from html import escape

    told = f"<caption>{escape(caption)}</caption>" if caption else ""
    cells = "".join(f"<th>{escape(one)}</th>" for one in head)
    shown = (
        "".join(f"<td>{one.html() if isinstance(one, Bar) else escape(one)}</td>" for one in row)
        for row in rows
    )
    body = "".join(f"<tr>{row}</tr>" for row in shown)
    return f"<table>{told}<thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table>"
