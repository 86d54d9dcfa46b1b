"""What MkDocs does to a page beyond Markdown: formulas become MathML, which browsers show without scripts.

``$$ ... $$`` on lines of its own is a displayed formula, ``$...$`` one within a line; code is left alone.
"""

from __future__ import annotations

import re
from typing import Any

from latex2mathml.converter import convert

_CODE = re.compile(r"(^```.*?^```$|`[^`\n]+`)", re.DOTALL | re.MULTILINE)
_DISPLAYED = re.compile(r"^\$\$\n(.+?)\n\$\$$", re.DOTALL | re.MULTILINE)
_INLINE = re.compile(r"(?<![\\$\w])\$(?!\s)((?:[^$\n]|\n(?!\n))+?)(?<![\s\\])\$(?![\w$])")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """The text of a page with its formulas converted."""
    parts = _CODE.split(markdown)
    for place in range(0, len(parts), 2):
        text = _DISPLAYED.sub(lambda found: f"\n{convert(found[1], display='block')}\n", parts[place])
        parts[place] = _INLINE.sub(lambda found: f"<span>{convert(found[1])}</span>", text)
    return "".join(parts)
