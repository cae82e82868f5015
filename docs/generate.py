"""The page of effects, written from the effect classes: a new effect is documented by being declared.

python docs/generate.py      writes docs/effects.md
"""

from __future__ import annotations

import re
from inspect import cleandoc
from pathlib import Path

from vcmm.core.effect import Effect, key_fields, parameter_fields, place_fields
from vcmm.core.units import EXAMPLES, dimension_of, parse_unit
from vcmm.effects import ALL

HEAD = """# Effects

An effect is a physical reason why one link of the machine is not where it should be, or why a reading is wrong. In a
machine or scenario file it is one `[[effects]]` table; `vcmm explain NAME` prints the same as this page. Signs are
those of [conventions](conventions.md): machine effects state the tip error (actual - nominal), readings state
indicated - true. How well a parameter is known is said apart, by an `[[inputs]]` table ([files](files.md)).

This page is written from the classes in `vcmm/effects/`; change it there.

| effect | one per | what it states | parameters |
|---|---|---|---|
"""


def page() -> str:
    """The whole page."""
    rows = [f"| [{e.name}](#{e.name}) | {e.per} | {sign(e)} | {', '.join(names(e))} |" for e in ALL]
    return HEAD + "\n".join(rows) + "\n\n" + "\n".join(section(e) for e in ALL)


def write(path: Path) -> None:
    """Write the page; an unchanged file keeps its time stamp."""
    text = page()
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
    parts += [f"States the {sign(effect)}. Needs: {needs}. Source: {effect.cites}.", ""]
    parts += (
        [f"No `[[effects]]` table states it; it is made by `{effect.made_by}`.", ""] if effect.made_by else []
    )
    return "\n".join(parts + example(effect))


def sign(effect: type[Effect]) -> str:
    return "reading, indicated - true" if effect().link == "reading" else "tip error, actual - nominal"


def names(effect: type[Effect]) -> list[str]:
    """Parameters as files write them."""
    written = {inner: outer for outer, inner in effect.aliases.items()}
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
    if effect.made_by:
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
        return f"{scan[len(scan) // 2] / parse_unit(unit).factor:g} {unit}"
    one = EXAMPLES[dimension_of(unit)].split(" ", 1)[0]
    count = int(shape.strip("(),")) if shape else 1
    return " ".join([one] + ["0"] * (count - 1)) + f" {unit}"


if __name__ == "__main__":
    write(Path(__file__).with_name("effects.md"))
