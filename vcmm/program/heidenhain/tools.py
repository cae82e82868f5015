"""TOOL CALL and TOOL DEF of Klartext."""

from __future__ import annotations

from dataclasses import replace

from vcmm.program.heidenhain.paths import KlartextPaths
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.words import read_words
from vcmm.program.levels import unknown_tool
from vcmm.program.setup import Tool

PLANE_OF_AXIS = {"Z": "XY", "Y": "ZX", "X": "YZ"}


def call_tool(p: KlartextPaths, reader: KlartextReader) -> None:
    """Call a tool: TOOL CALL number or name, axis, S, F, DL, DR; without a tool: new speed or oversize only."""
    token, tool, called = reader.peek(), p.r.tool_data, p.r.tool_names.get(p.r.tool, "")
    new = token is not None and (token.kind in ("number", "string") or reader.is_parameter())
    if new:
        tool, called = _find(p, reader)
    if reader.upper() in PLANE_OF_AXIS:
        p.r.free("the tool axis is chosen")
        p.r.plane, p.r.tool_axis = PLANE_OF_AXIS[reader.upper()], "XYZ".index(reader.upper())
        reader.at += 1
    words = read_words(reader, ("S", "DL", "DR", "DR2"))
    speed, dl, dr = words.take("S"), words.take("DL"), words.take("DR")
    words.take("DR2")
    if speed is not None:
        p.r.speed = speed
    if words.feed is not None:
        p.auto_feed = p.r.feed = p.feed_of(words.feed, words.feed_kind)
        p.r.feed_mode = "G94"
    if new or dl is not None or dr is not None:
        p.extra_radius = (dr or 0.0) * p.r.unit
        p.r.change_tool(replace(tool, length=tool.length + (dl or 0.0) * p.r.unit), called)


def _find(p: KlartextPaths, reader: KlartextReader) -> tuple[Tool, str]:
    token = reader.peek()
    assert token is not None
    tools = p.r.setup.tools
    if token.kind != "string":
        value = reader.value("TOOL CALL")
        number = int(value)
        if value != number:
            p.r.assume(
                f"tool {value:g}, an index of tool {number}", f"the numbers of tool {number}",
                f"TOOL CALL {value:g} takes length and radius of an index of tool {number}, which a set-up does not know; call a tool with a number of its own",
            )  # fmt: skip
        tool = p.definitions.get(number) or tools.get(number)
        if tool is None and number:
            unknown_tool(p.r, number, f"TOOL CALL {number}")
        return tool or Tool(number), f"TOOL CALL {number}"
    reader.at += 1
    name = token.text[1:-1]
    named = next((t for t in tools.values() if t.name.upper() == name.upper()), None)
    if named is not None:
        return named, name
    again = {n: k for k, n in p.r.tool_names.items()}
    number = again.get(name, max([*tools, *p.r.tool_names, 0]) + 1)
    unknown_tool(p.r, 0, name, free=number)
    return Tool(number, name=name), name


def define_tool(p: KlartextPaths, reader: KlartextReader) -> None:
    """Define a tool: TOOL DEF number L R."""
    number = round(reader.value("TOOL DEF"))
    words = read_words(reader, ("L", "R"))
    length, radius = words.take("L"), words.take("R")
    if words.has_side and radius is None:  # R0 reads as "no compensation"
        radius = 0.0
    if length is None and radius is None:
        return  # preparation of a tool from the table
    base = p.r.setup.tools.get(number, Tool(number))
    for what, value, entry in (
        ("length", length, base.length if number in p.r.setup.tools and base.length_stated else None),
        ("radius", radius, base.radius),
    ):
        if value is not None and entry is not None and abs(value * p.r.unit - entry) > 1e-9:
            p.r.remark(
                f"TOOL DEF {number}: the {what} {value * p.r.unit:g} mm of the program counts, not the {entry:g} mm of the set-up"
            )
    p.definitions[number] = replace(
        base, length=base.length if length is None else length * p.r.unit,
        diameter=base.diameter if radius is None else 2 * radius * p.r.unit,
    )  # fmt: skip
