"""vcmm explain: an effect, a geometric error or a figure of a standard in words, with formula, sign, source."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from vcmm.core.figures import StandardFigure


def explain_command(word: str, *, json: Annotated[bool, Parameter(name="--json")] = False) -> int:
    """Explain an effect (backlash), a geometric error (EXX, xty, C0Y) or a figure (E0_MPE, A): sign, unit, source, how to write it.

    Parameters
    ----------
    word
        Name of an effect (see `vcmm list effects`), of an error in any literature (`vcmm list aliases`), of a figure.
    json
        Print one JSON document.
    """
    from vcmm.core.error_names import is_known
    from vcmm.core.errors import UsageError
    from vcmm.core.figures import standard_figures
    from vcmm.physics import BY_NAME, find

    figures = standard_figures(word)
    if word in BY_NAME:
        return _effect(word, json)
    if figures:
        return _figures(word, figures, json)
    if is_known(word):
        return _error(word, json)
    try:
        find(word)
    except UsageError as error:
        raise UsageError(
            f"{error} Errors such as EYX or C0Y and figures such as E0_MPE are explained too"
        ) from None
    return 2


def _figures(word: str, figures: tuple[StandardFigure, ...], json: bool) -> int:
    from vcmm.show.console.documents import document, print_json

    if json:
        print_json(document("vcmm.explain/1", {"figure": word, "meanings": [f._asdict() for f in figures]}))
        return 0
    for one in figures:
        former = ", ".join(one.former)
        print(
            f"{one.symbol}\n\n{one.words}\n\nsource    {one.source}"
            + (f"\nalso      {former}" if former else "")
            + "\n"
        )
    return 0


def _error(word: str, json: bool) -> int:
    from vcmm.core.axes import is_location
    from vcmm.core.effect import place_fields
    from vcmm.core.error_names import canonical, describe_error
    from vcmm.physics.structure.component import ComponentTable
    from vcmm.physics.structure.squareness import RotaryLocation, Squareness
    from vcmm.show.console.documents import document, print_json

    row = describe_error(canonical(word))
    of_axis = RotaryLocation if is_location(row.name) else Squareness
    kind = ComponentTable if row.name.startswith("E") else of_axis
    key = next(f.name for f in place_fields(kind))
    if json:
        body = {
            "error": row.name,
            "text": row.words,
            "also": row.also,
            "sign": row.sign,
            "unit": row.unit,
            "effect": kind.name,
            "key": key,
        }
        print_json(document("vcmm.explain/1", body))  # fmt: skip
        return 0
    print(f"{row.name}\n\n{row.words}\n")
    print(
        f"sign      {row.sign} (machine axes; the tip error that follows: vcmm field)\nunit      {row.unit}\nsource    ISO 230-1\nalso      {row.also}\n"
    )
    print(
        f'in a machine file: effect = "{kind.name}" with {key} = "{row.name}"; see vcmm explain {kind.name}'
    )
    return 0


def _effect(effect: str, json: bool) -> int:
    from inspect import cleandoc

    from vcmm.core.effect import key_fields, parameter_fields, place_fields, unit_at
    from vcmm.physics import find
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.terminal import show_table
    from vcmm.show.tables.table import listing

    kind = find(effect)
    back = {v: k for k, v in kind.about.aliases.items()}
    parameters = [
        [
            back.get(f.name, f.name),
            f.metadata["unit"],
            f.metadata["doc"]
            + (f", {f.metadata['shape']}" if f.metadata["shape"] else "")
            + (" (scanned)" if f.metadata["scan"] else ""),
        ]
        for f in parameter_fields(kind)
    ]
    places = [[f.name, str(f.metadata["doc"])] for f in place_fields(kind)]
    keys = [[f.name, str(f.metadata.get("doc", "further key of the table"))] for f in key_fields(kind)]
    text = cleandoc(kind.__doc__ or "")
    link = "reading: indicated - true" if kind().link == "reading" else "tip error: actual - nominal"
    if json:
        body = {"effect": kind.name, "text": text, "sign": link, "per": kind.per, "needs": list(kind.needs), "cites": kind.about.cites,
                "parameters": [dict(zip(("name", "unit", "doc"), p)) for p in parameters], "places": [dict(zip(("key", "doc"), p)) for p in places],
                "keys": [dict(zip(("key", "doc"), k)) for k in keys]}  # fmt: skip
        print_json(document("vcmm.explain/1", body))
        return 0
    print(f"{kind.name}\n\n{text}\n")
    print(
        f"sign      {link}\nsource    {kind.about.cites}\nper       {kind.per}\nneeds     {', '.join(kind.needs) or 'positions only'}\n"
    )
    turned = {u: unit_at(kind, u, axis="C") for _, u, _ in parameters}
    units = {u: u if other == u else f"{u} ({other} of a rotary axis)" for u, other in turned.items()}
    rows = [["place", n, d] for n, d in places] + [
        ["parameter", n, f"{units[u]}: {d}"] for n, u, d in parameters
    ]
    rows += [["key", n, d] for n, d in keys]
    show_table(listing("keys of the [[effects]] table", ["", "key", "meaning"], rows, words=(0, 1, 2)))
    return 0
