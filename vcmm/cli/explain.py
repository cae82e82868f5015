"""vcmm explain: one effect in words, formula, parameters, source."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter


def explain_command(effect: str, *, json: Annotated[bool, Parameter(name="--json")] = False) -> int:
    """Explain an effect: formula, sign, parameters with units, needed columns, source, how to write it in a file.

    Parameters
    ----------
    effect
        Name of an effect; see `vcmm list effects`.
    json
        Print one JSON document.
    """
    from inspect import cleandoc

    from vcmm.console.documents import document, print_json
    from vcmm.console.terminal import show_table
    from vcmm.core.effect import key_fields, parameter_fields, place_fields
    from vcmm.effects import find
    from vcmm.tables.table import listing

    kind = find(effect)
    back = {v: k for k, v in kind.aliases.items()}
    parameters = [
        [
            back.get(f.name, f.name),
            f.metadata["unit"],
            f.metadata["doc"] + (" (scanned)" if f.metadata["scan"] else ""),
        ]
        for f in parameter_fields(kind)
    ]
    places = [[f.name, str(f.metadata["doc"])] for f in place_fields(kind)]
    text = cleandoc(kind.__doc__ or "")
    link = "reading: indicated - true" if kind().link == "reading" else "tip error: actual - nominal"
    if json:
        body = {"effect": kind.name, "text": text, "sign": link, "per": kind.per, "needs": list(kind.needs), "cites": kind.cites,
                "parameters": [dict(zip(("name", "unit", "doc"), p)) for p in parameters], "places": [dict(zip(("key", "doc"), p)) for p in places]}  # fmt: skip
        print_json(document("vcmm.explain/1", body))
        return 0
    print(f"{kind.name}\n\n{text}\n")
    print(
        f"sign      {link}\nsource    {kind.cites}\nper       {kind.per}\nneeds     {', '.join(kind.needs) or 'positions only'}\n"
    )
    rows = [["place", n, d] for n, d in places] + [["parameter", n, f"{u}: {d}"] for n, u, d in parameters]
    rows += [["key", f.name, "further key of the table"] for f in key_fields(kind)]
    show_table(listing("keys of the [[effects]] table", ["", "key", "meaning"], rows, words=(0, 1, 2)))
    return 0
