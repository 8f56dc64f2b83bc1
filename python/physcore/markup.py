"""Tables and pictures of results. HTML is without inline colors, so that it follows the theme of a notebook."""

from __future__ import annotations

import base64
from collections.abc import Collection, Mapping, Sequence
from html import escape


class Printed:
    """Base class of results that a prompt shows as `print` does. A dataclass of this kind needs repr=False."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def text_table(lines: Sequence[Sequence[str]], left: Collection[int]) -> list[str]:
    """The lines of a table as text, the head first. The columns in `left` are left-aligned, others right-aligned."""
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    return [
        "  ".join(
            cell.ljust(width) if column in left else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    ]


def html_table(heads: Sequence[str], rows: Mapping[str, Sequence[str]], caption: str = "") -> str:
    """An HTML table from column heads and rows. Each row has a name and its cells."""
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    top = f"<thead><tr>{''.join(f'<th>{escape(head)}</th>' for head in heads)}</tr></thead>" if heads else ""
    body = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        + "".join(f'<td style="text-align:left">{escape(cell)}</td>' for cell in cells)
        + "</tr>"
        for name, cells in rows.items()
    )
    return f"<table>{title}{top}<tbody>{body}</tbody></table>"


def inline_image(content: bytes, kind: str, words: str) -> str:
    """An HTML image of the given type, such as "gif", embedded in the page, with an alternative text."""
    data = base64.b64encode(content).decode()
    return f'<img alt="{escape(words)}" src="data:image/{kind};base64,{data}">'


def inline_page(page: str, words: str) -> str:
    """A page within the page, with a title."""
    return (
        f'<iframe title="{escape(words)}" srcdoc="{escape(page)}" sandbox="allow-scripts" '
        'style="width:100%;height:46em;border:0"></iframe>'
    )


def inline_video(content: bytes, words: str) -> str:
    """An HTML video in MP4, embedded in the page, which plays in a loop; with an alternative text."""
    data = base64.b64encode(content).decode()
    return (
        f'<video aria-label="{escape(words)}" autoplay loop muted playsinline controls '
        f'src="data:video/mp4;base64,{data}"></video>'
    )
