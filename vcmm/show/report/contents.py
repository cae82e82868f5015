"""The list of contents of a page, the anchors it leads to, and the facts below the answers (part, machine, date ...)."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence

from vcmm.show.report.text import escape

_HEADING = re.compile(r"<h2>(.*?)</h2>", re.S)
_LINK = re.compile(r'<a data-to="([^"]*)">(.*?)</a>', re.S)
LEAST = 3  # sections from which on a page has a list of contents


def with_anchors(body: str) -> tuple[str, dict[str, str]]:
    """The page with an id at every section, and heading -> id in their order."""
    found: dict[str, str] = {}
    taken: set[str] = set()

    def anchored(match: re.Match[str]) -> str:
        title = html.unescape(re.sub(r"<[^>]+>", "", match[1]))
        plain = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "section"
        name = next(n for n in _numbered(plain) if n not in taken)
        taken.add(name)
        found.setdefault(title, name)
        return f'<h2 id="{name}">{match[1]}</h2>'

    return _HEADING.sub(anchored, body), found


def _numbered(plain: str) -> list[str]:
    return [plain, *(f"{plain}-{k}" for k in range(2, 1000))]


def linked(block: str, found: Mapping[str, str]) -> str:
    """Links to headings by their words; where the page has no such section the words stand alone."""

    def one(match: re.Match[str]) -> str:
        name = found.get(html.unescape(match[1]))
        return match[2] if name is None else f'<a href="#{name}">{match[2]}</a>'

    return _LINK.sub(one, block)


def contents(found: Mapping[str, str]) -> str:
    """Links to all sections; empty where there are few."""
    if len(found) < LEAST:
        return ""
    items = "".join(f'<li><a href="#{name}">{escape(title)}</a></li>' for title, name in found.items())
    return f'<nav class="contents" aria-label="Contents"><ol>{items}</ol></nav>'


def facts_list(facts: Sequence[tuple[str, str]]) -> str:
    """What an assessor asks first, name and value side by side."""
    if not facts:
        return ""
    items = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts)
    return f'<dl class="facts">{items}</dl>'
