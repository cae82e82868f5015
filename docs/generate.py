"""Pages that come from the code: effects, the reference of functions and commands, the lessons as notebooks.

python docs/generate.py      writes docs/effects.md, docs/reference.md, docs/lesson/*.ipynb

A new effect, function or option is documented by being declared.
"""

from __future__ import annotations

import importlib
import re
from inspect import cleandoc, getdoc, isfunction, ismodule, signature
from pathlib import Path
from typing import Any

from vcmm.core.effect import Effect, key_fields, parameter_fields, place_fields
from vcmm.core.units import EXAMPLES, dimension_of, parse_unit
from vcmm.physics import ALL
from vcmm.physics.structure.component import CalibrationModes

HEAD = """# Effects

An effect is a physical reason why one link of the machine is not where it should be, or why a reading is wrong. In a
machine or scenario file it is one `[[effects]]` table; `vcmm explain NAME` prints the same as this page. Signs are
those of [conventions](conventions.md): machine effects state the tip error (actual - nominal), readings state
indicated - true. How well a parameter is known is said apart, by an `[[inputs]]` table ([files](files.md)).

This page is written from the classes in `vcmm/physics/`; change it there.

| effect | one per | what it states | parameters |
|---|---|---|---|
"""


def page() -> str:
    """The whole page."""
    rows = [f"| [{e.name}](#{e.name}) | {e.per} | {sign(e)} | {', '.join(names(e))} |" for e in ALL]
    return HEAD + "\n".join(rows) + "\n\n" + "\n".join(section(e) for e in ALL)


def write_all(docs: Path) -> None:
    """Every generated page of a folder of documentation."""
    write(docs / "effects.md")
    write(docs / "reference.md", reference())
    (docs / "lesson").mkdir(exist_ok=True)
    for lesson in sorted((docs.parent / "notebooks").glob("[0-9][0-9]_*.py")):
        write(docs / "lesson" / f"{lesson.stem}.ipynb", notebook(lesson))


def write(path: Path, text: str | None = None) -> None:
    """Write a page, that of effects unless given; an unchanged file keeps its time stamp."""
    text = page() if text is None else text
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def section(effect: type[Effect]) -> str:
    """Heading, text, keys, needs, source and example of one effect."""
    needs = ", ".join(f"`{n}`" for n in effect.needs) or "positions only"
    parts = [
        f"({effect.name})=",
        f"## {effect.name}",
        "",
        cleandoc(effect.__doc__ or "").replace("*", "\\*"),
        "",
        *table(effect),
        "",
    ]
    parts += [f"States the {sign(effect)}. Needs: {needs}. Source: {effect.about.cites}.", ""]
    parts += (
        [f"No `[[effects]]` table states it; it is made by `{CalibrationModes.made_by}`.", ""]
        if issubclass(effect, CalibrationModes)
        else []
    )
    return "\n".join(parts + example(effect))


def sign(effect: type[Effect]) -> str:
    return "reading, indicated - true" if effect().link == "reading" else "tip error, actual - nominal"


def names(effect: type[Effect]) -> list[str]:
    """Parameters as files write them."""
    written = {inner: outer for outer, inner in effect.about.aliases.items()}
    return [f"`{written.get(f.name, f.name)}`" for f in parameter_fields(effect)]


def table(effect: type[Effect]) -> list[str]:
    """Keys of the [[effects]] table: places, parameters, others."""
    rows = ["| key | unit | meaning |", "|---|---|---|"]
    rows += [f"| `{f.name}` | | {f.metadata['doc']} |" for f in place_fields(effect)]
    for name, f in zip(names(effect), parameter_fields(effect)):
        shape = f", {f.metadata['shape']}" if f.metadata["shape"] else ""
        scanned = "; acts non-linearly" if f.metadata["scan"] else ""
        rows.append(f"| {name} | {f.metadata['unit']}{shape} | {f.metadata['doc']}{scanned} |")
    return rows + [f"| `{f.name}` | | further key |" for f in key_fields(effect)]


def example(effect: type[Effect]) -> list[str]:
    """A [[effects]] table with plausible numbers; none where arrays come from a file of their own."""
    lines = tables(effect)
    return ["```toml", *lines, "```", ""] if lines else []


def tables(effect: type[Effect]) -> list[str]:
    """Lines of the example, or nothing for effects that hold tables of nodes."""
    if issubclass(effect, CalibrationModes):
        return []
    shapes = " ".join(f.metadata["shape"] for f in parameter_fields(effect))
    if "nodes" in shapes or "powers" in shapes:
        return []
    lines = ["[[effects]]", f'effect = "{effect.name}"']
    places = [f for f in place_fields(effect) if f.default and not f.metadata["quiet"]]
    lines += [f'{f.name} = "{f.default}"' for f in places]
    letter = str(getattr(effect(), "component", ""))[:1]  # a shift has no tilt
    for name, f in zip(names(effect), parameter_fields(effect)):
        if not f.metadata["only"] or letter in f.metadata["only"]:
            key = name.strip("`")
            lines.append(
                f'{key if re.fullmatch("[A-Za-z0-9_-]+", key) else chr(34) + key + chr(34)} = "{number(**f.metadata)}"'
            )
    return lines


def number(unit: str, shape: str, scan: tuple[float, ...], **_: object) -> str:
    """A plausible value with its unit: "0.8 um", "1 0 0 um"; for scanned parameters one of the trial values."""
    if scan:
        return f"{scan[len(scan) // 2] / parse_unit(unit).factor:g} {unit}".removesuffix(
            " 1"
        )  # of a pure number
    one = EXAMPLES[dimension_of(unit)].split(" ", 1)[0]
    count = int(shape.strip("(),")) if shape else 1
    return " ".join([one] + ["0"] * (count - 1)) + f" {unit}"


REFERENCE = """# Reference

What `import vcmm` offers and what the command `vcmm` understands, written from the code; {doc}`python` and {doc}`cli` explain them with examples.
Inside: mm, rad, s, degC, N.
"""


def reference() -> str:
    """Functions and classes of `vcmm`, then every verb with its options."""
    import vcmm
    from vcmm.face.cli import VERBS

    parts = [REFERENCE, "## In Python", ""]
    for name in vcmm.__all__[1:]:
        parts += [f"### vcmm.{name}", "", *described(f"vcmm.{name}", getattr(vcmm, name))]
    parts += ["## On the command line", ""]
    for verb, line in VERBS.items():
        command = getattr(importlib.import_module(f"vcmm.face.cli.{verb}"), f"{verb}_command")
        parts += [f"### vcmm {verb}", "", line, "", *fenced(options(command))]
    return "\n".join(parts)


def described(name: str, item: Any) -> list[str]:
    """How it is called, and its docstring as it stands in the code."""
    if ismodule(item):
        offered = sorted(getattr(item, "__all__", None) or (n for n in vars(item) if n[0].isupper()))
        return [
            *fenced(f"module {name}"),
            *fenced(getdoc(item) or ""),
            ", ".join(f"`{n}`" for n in offered),
            "",
        ]
    if not item.__module__.startswith("vcmm."):  # a type of numpy under a name of ours
        return fenced(f"{name} = {item}")
    called = f"{name}{signature(item)}" if isfunction(item) else f"class {name}"
    return [*fenced(called), *fenced(getdoc(item) or "")]


def options(command: Any) -> str:
    """The docstring of a verb, which its --help shows too."""
    return cleandoc(command.__doc__ or "")


def fenced(text: str) -> list[str]:
    return ["```text", text.strip(), "```", ""] if text.strip() else []


def notebook(lesson: Path) -> str:
    """A lesson as a notebook of Jupyter without outputs; ids of cells are their numbers, so that it repeats."""
    import jupytext

    made = jupytext.read(lesson, fmt="py:percent")
    for number, cell in enumerate(made.cells):
        cell["id"] = f"cell-{number}"
        if cell.cell_type == "code" and re.search(r"\.plot\([^\n]*\)$", cell.source):
            cell.source += ";"  # the picture alone, without the name of its axes
    made.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3"}
    made.metadata["language_info"] = {"name": "python", "pygments_lexer": "ipython3"}
    return str(jupytext.writes(made, fmt="ipynb"))


if __name__ == "__main__":
    write_all(Path(__file__).parent)
