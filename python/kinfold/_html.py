"""How results show themselves in a notebook."""

from __future__ import annotations

#: Height of a page in a notebook, pixels: a guess at what a screen of a laptop shows beside a cell.
_HEIGHT = 560


def framed(page: str, title: str) -> str:
    """A page in a frame of its own, whose scripts reach nothing around it."""
    from html import escape

    return (
        f'<iframe title="{escape(title)}" sandbox="allow-scripts" loading="lazy" '
        f'style="width: 100%; height: {_HEIGHT}px; border: 0" srcdoc="{escape(page)}"></iframe>'
    )


def table(head: list[str], rows: list[list[str]], caption: str = "") -> str:
    """A table of texts."""
    from html import escape

    told = f"<caption>{escape(caption)}</caption>" if caption else ""
    cells = "".join(f"<th>{escape(one)}</th>" for one in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(one)}</td>" for one in row) + "</tr>" for row in rows)
    return f"<table>{told}<thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table>"
