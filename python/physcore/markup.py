"""Tables and pictures for notebooks, in HTML without styles of their own, so that they follow the notebook's theme."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape


def html_table(heads: Sequence[str], rows: Mapping[str, Sequence[str]], caption: str = "") -> str:
    """A table: heads of all columns, and of each row its name with its cells."""
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
    """A picture of some kind, such as "gif", inside the page, with words for those who do not see it."""
    data = base64.b64encode(content).decode()
    return f'<img alt="{escape(words)}" src="data:image/{kind};base64,{data}">'
