"""The page of the workbench: sliders, the table of characteristics, budgets, the live scenes."""

from __future__ import annotations

import json
from importlib import resources

from vcmm.show.report.page import asset, scripts
from vcmm.show.report.palette import css_variables
from vcmm.show.report.text import escape

STYLE = """
.bench{display:grid;grid-template-columns:minmax(15rem,20rem) 1fr;gap:1.4rem;align-items:start}
.knobs{position:sticky;top:1rem;padding:1rem;background:var(--surface);border:1px solid var(--grid);border-radius:10px}
.knobs label{display:block;margin:.2rem 0 .9rem;font-size:.9rem}.knobs input{width:100%}
.knobs output{float:right;font-variant-numeric:tabular-nums}.preview td{color:var(--muted)}
.share{display:inline-block;height:.6rem;background:var(--accent);vertical-align:baseline;margin-right:.5rem}
.live-scene{margin-top:1.4rem}.drop{border:2px dashed var(--rule);border-radius:10px;padding:1rem;color:var(--muted);margin-top:1.4rem}
@media(max-width:50rem){.bench{grid-template-columns:1fr}.knobs{position:static}}
"""


def _own_script() -> str:
    return resources.files("vcmm.face.workbench").joinpath("workbench.js").read_text(encoding="utf-8")


def bench_page(name: str, token: str) -> str:
    """The whole page. The token is for its own questions; no other page can read it."""
    given = json.dumps({"token": token}).replace("<", "\\u003c")
    figures = "".join(
        f'<figure class="figure live-scene"><figcaption>{escape(title)}</figcaption><div class="picture row"><div class="scene" tabindex="0" role="group" aria-label="{escape(title)}" '
        f'style="height:420px"><div class="live"></div></div></div></figure>'
        for title in ("Part in the machine", "Touches and their standard uncertainty")
    )
    style = css_variables() + asset("style.css") + STYLE
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f"<title>{escape(name)}: workbench</title><style>{style}</style></head><body>"
        f'<header><h1>{escape(name)}</h1><p class="subtitle" id="status" role="status">connecting</p></header><main>'
        '<div class="bench"><form class="knobs" aria-label="knobs"></form><div><div class="scroll"><table>'
        "<thead><tr><th>characteristic</th><th>value</th><th>U</th><th>decision</th><th>owners</th></tr></thead>"
        f'<tbody id="rows"></tbody></table></div>{figures}'
        '<p class="drop" id="drop">Drop a recording here (its .toml and tables): it is diagnosed on this machine.</p><div id="found"></div>'
        f'</div></div></main><script type="application/json" id="given">{given}</script>{scripts()}<script>{_own_script()}</script></body></html>'
    )
