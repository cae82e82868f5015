"""One self-contained HTML page from blocks of HTML. Works offline, prints, follows the reader's light or dark setting.

    html = page("Plate 0815", [heading("Results"), table(...), columns(bars(...), zones(...))])
    write("report.html", html)

Every block is a string and every function is pure; nothing outside the file is ever requested, and the page says
so to the browser (content security policy).

plotly.js as text for a page: the bundle for three dimensions, which comes with vcmm, so that a page works offline.

`plotly-gl3d.min.js.xz` is `plotly-gl3d.min.js` of plotly.js 4.1.1, unchanged, packed by xz (npm package plotly.js-gl3d-dist-min; MIT
licence, beside it). It draws meshes, lines, points and cones, which is all that scenes hold, at a third of the whole library.
To renew it: npm pack plotly.js-gl3d-dist-min, xz -9e, then VERSION and SHA256 here.

The list of contents of a page, the anchors it leads to, and the facts below the answers (part, machine, date ...).
"""

from __future__ import annotations

import base64
import gzip
import html
import lzma
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal

from vcmm.core.errors import Environment
from vcmm.show.report.answers import AnswerLine, answers_block
from vcmm.show.report.notices import Severity, notice
from vcmm.show.report.palette import css_variables
from vcmm.show.report.text import escape, micro

_HEADING = re.compile(r"<h2>(.*?)</h2>", re.S)
_LINK = re.compile(r'<a data-to="([^"]*)">(.*?)</a>', re.S)
LEAST_SECTIONS = 3  # sections from which on a page has a list of contents


def with_anchors(body: str) -> tuple[str, dict[str, str]]:
    """Return the page with an id at every section, and heading -> id in their order."""
    anchors: dict[str, str] = {}
    taken: set[str] = set()

    def heading_with_anchor(match: re.Match[str]) -> str:
        title = html.unescape(re.sub(r"<[^>]+>", "", match[1]))
        plain = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "section"
        name = next(n for n in _number_headings(plain) if n not in taken)
        taken.add(name)
        anchors.setdefault(title, name)
        return f'<h2 id="{name}">{match[1]}</h2>'

    return _HEADING.sub(heading_with_anchor, body), anchors


def _number_headings(plain: str) -> list[str]:
    return [plain, *(f"{plain}-{k}" for k in range(2, 1000))]


def link_headings(block: str, anchors: Mapping[str, str]) -> str:
    """Return the links to headings by their words; where the page has no such section the words stand alone."""

    def one(match: re.Match[str]) -> str:
        name = anchors.get(html.unescape(match[1]))
        return match[2] if name is None else f'<a href="#{name}">{match[2]}</a>'

    return _LINK.sub(one, block)


def contents(anchors: Mapping[str, str]) -> str:
    """Return the contents, links to all sections; empty where there are few."""
    if len(anchors) < LEAST_SECTIONS:
        return ""
    items = "".join(f'<li><a href="#{name}">{escape(title)}</a></li>' for title, name in anchors.items())
    return f'<nav class="contents" aria-label="Contents"><ol>{items}</ol></nav>'


def facts_list(facts: Sequence[tuple[str, str]]) -> str:
    """Return the facts that an assessor checks first, name and value side by side."""
    if not facts:
        return ""
    items = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts)
    return f'<dl class="facts">{items}</dl>'


VERSION = "4.1.1"
SHA256 = "aab04dcd9c103a92b18723f8c837712fe820f325d0bcd2421e415e8124a75b9f"  # of the script, unpacked
FILE = "plotly-gl3d.min.js.xz"


@cache
def packed_plotly() -> str:
    """Return the script, packed by gzip, which browsers unpack, and in base64: 0.74 MB."""
    script = lzma.decompress(resources.files("vcmm.show.report").joinpath(FILE).read_bytes())
    return base64.b64encode(gzip.compress(script, 9, mtime=0)).decode("ascii")


_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; connect-src 'self'"


def asset(name: str) -> str:
    return resources.files("vcmm.show.report").joinpath(name).read_text(encoding="utf-8")


def scene_script() -> str:
    """Return the script that draws 3-D scenes, without indentation and comments."""
    lines = (line.strip() for line in asset("scene.js").splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("//")) + "\n"


def scripts() -> str:
    """Return the scripts that a page with scenes needs once: plotly, packed, and the script that unpacks and uses it."""
    library = f'<script type="application/octet-stream" id="plotly-gz">{packed_plotly()}</script>\n'
    return f"{library}<script>\n{scene_script()}</script>\n"


def page(
    title: str,
    blocks: Sequence[str],
    *,
    subtitle: str = "",
    footer: str = "",
    answers: Sequence[AnswerLine] = (),
    facts: Sequence[tuple[str, str]] = (),
) -> str:
    """Return the whole document: title, the answers, the facts (part, machine, date ...), a list of contents, then the blocks.

    `blocks` are HTML strings made by this package; texts are escaped here.
    """
    body, anchors = with_anchors("\n".join(blocks))
    first = link_headings(answers_block(answers), anchors) + facts_list(facts) + contents(anchors)
    script = scripts() if "data-scene" in body else ""
    style = css_variables() + "\n" + asset("style.css")
    below = f'<p class="subtitle">{escape(subtitle)}</p>' if subtitle else ""
    foot = f"<footer>{escape(footer)}</footer>\n" if footer else ""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f"<header><h1>{escape(title)}</h1>{below}</header>\n<main>\n{first}{body}\n</main>\n{foot}{script}</body>\n</html>\n"
    )


def write(path: str | Path, html: str) -> Path:
    """Write the page so that a reader sees the old file or the new one, never half of it. Returns the path.

    Environment: the folder or the file cannot be written; nothing is left behind.
    """
    target = Path(path)
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        draft.write_text(html, encoding="utf-8")
        os.replace(draft, target)
    except OSError as problem:
        _remove(draft)
        why = problem.strerror or problem
        raise Environment(
            f"The report cannot be written to {target}: {why}. Name a file in an existing folder you may write to."
        ) from problem
    return target


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:  # its folder is not a folder: there was never a file
        return


def heading(text: str, level: int = 2) -> str:
    """Return a heading, level 2 (section) to 4; level 1 is the page's own title."""
    level = min(max(level, 2), 4)
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str) -> str:
    """Return running text."""
    return f"<p>{escape(micro(text))}</p>"


def note(text: str, kind: Literal["info", "warning", "error"] = "info") -> str:
    """Return a remark set apart; a warning or an error is announced as such in words, not by colour alone."""
    word = {"warning": "<strong>Warning.</strong> ", "error": "<strong>Error.</strong> "}.get(kind, "")
    return f'<p class="note {kind}" role="note">{word}{escape(micro(text))}</p>'


def notices(texts: Iterable[str]) -> list[str]:
    """Return the notices beside a result: errors and warnings each by itself, all notes in one list."""
    by_severity: dict[Severity, list[str]] = {"error": [], "warning": [], "note": []}
    for text in dict.fromkeys(texts):
        by_severity[notice(text).severity].append(text)
    out = [note(text, "error") for text in by_severity["error"]]
    out += [note(text, "warning") for text in by_severity["warning"]]
    if notes := by_severity["note"]:
        items = "".join(f"<li>{escape(micro(text))}</li>" for text in notes)
        word = "Note." if len(notes) == 1 else "Notes."
        out.append(f'<div class="note info" role="note"><strong>{word}</strong><ul>{items}</ul></div>')
    return out


def columns(*blocks: str) -> str:
    """Return blocks side by side where the screen is wide enough, below each other where not."""
    cells = "".join(f"<div>{block}</div>" for block in blocks)
    return f'<div class="columns">{cells}</div>'


def details(summary: str, *blocks: str) -> str:
    """Return blocks that the reader opens by a click; printed open."""
    return f"<details><summary>{escape(summary)}</summary>\n{''.join(blocks)}\n</details>"


def leaf(*blocks: str) -> str:
    """Return blocks that are printed on a separate sheet of paper; on the screen they follow each other."""
    return f'<section class="leaf">\n{"".join(blocks)}\n</section>'
