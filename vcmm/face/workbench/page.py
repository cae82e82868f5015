"""The page of the workbench: the answer first, the knobs beside it (below it on a narrow screen), pictures, sweep, files, live scenes."""

from __future__ import annotations

import json
from importlib import resources

from vcmm.show.report.page import asset, scripts
from vcmm.show.report.palette import css_variables
from vcmm.show.report.text import escape

SCENES = ("Part in the machine", "Touches and their standard uncertainty")
TOOLS = """<div class="tools" role="toolbar" aria-label="what to do with the knobs">
<button type="button" id="undo" title="Ctrl+Z" disabled>Undo</button><button type="button" id="redo" title="Ctrl+Y" disabled>Redo</button>
<button type="button" id="reset" title="all knobs as in the file">Reset</button>
<button type="button" id="pin" title="keep these figures beside those that follow" disabled>Pin as A</button>
<button type="button" id="swap" title="turn the knobs to A, and pin these figures" hidden>Exchange A and B</button>
<button type="button" id="save" title="the scenario with these knobs">Save as TOML</button>
<progress id="progress" max="1" aria-label="progress" hidden></progress><button type="button" id="cancel" hidden>Cancel</button></div>"""
ANSWER = """<section class="answer" aria-label="the answer"><div class="scroll"><table>
<thead><tr><th>characteristic</th><th>value</th><th>U</th><th>decision</th><th>largest contributor</th><th class="pinned">A</th></tr></thead>
<tbody id="rows"></tbody></table></div></section>"""
SWEEP = """<div class="tools" style="margin-top:1.2rem"><label>U against <select id="along" aria-label="knob of the sweep"></select></label>
<button type="button" id="sweep">Sweep</button><button type="button" id="measure">Measure once</button><button type="button" id="place">Place the part</button></div><div id="swept"></div>"""
FILES = """<div class="drop" id="drop"><span id="said" role="status">Drop files or a folder here: one recording is diagnosed, several calibrate the machine file beside them, a scenario with [cut] is cut, points or values (.csv) of this task are evaluated. All of it stays on this machine.</span>
<span class="tools" style="margin:.6rem 0 0"><select id="what" aria-label="what to do with the files"><option value="">as the files say</option><option>diagnose</option><option>calibrate</option><option>evaluate</option><option>cut</option></select><button type="button" id="files">Files…</button><button type="button" id="folder">Folder…</button></span>
<input type="file" id="chosen" multiple hidden><input type="file" id="whole" webkitdirectory hidden></div><div id="found"></div>
<div class="tools"><button type="button" id="keep" hidden>Save the report</button></div><iframe id="report" class="report" title="report" sandbox="allow-scripts" hidden></iframe>"""


def _own(name: str) -> str:
    return resources.files("vcmm.face.workbench").joinpath(name).read_text(encoding="utf-8")


def bench_page(name: str, token: str) -> str:
    """The whole page. The token is for its own questions; no other page can read it."""
    given = json.dumps({"token": token}).replace("<", "\\u003c")
    figures = "".join(
        f'<figure class="figure live-scene"><figcaption>{escape(title)}</figcaption><div class="picture row"><div class="scene" tabindex="0" role="group" aria-label="{escape(title)}" '
        f'style="height:420px"><div class="live"></div></div></div></figure>'
        for title in SCENES
    )
    style = css_variables() + asset("style.css") + _own("workbench.css")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f"<title>{escape(name)}: workbench</title><style>{style}</style></head><body>"
        f'<header><h1>{escape(name)}</h1><p class="subtitle" id="status" role="status">connecting</p></header><main>'
        f'<div class="bench">{ANSWER}<div class="side">{TOOLS}<form class="knobs" aria-label="knobs"></form></div>'
        f'<div class="more"><div class="pictures" id="pictures"></div>{SWEEP}{figures}{FILES}</div></div></main>'
        f'<script type="application/json" id="given">{given}</script>{scripts()}<script>{_own("workbench.js")}</script></body></html>'
    )
