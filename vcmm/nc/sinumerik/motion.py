"""What the words of a Sinumerik block do. Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Fundamentals."""

from __future__ import annotations

import math

from vcmm.core.errors import did_you_mean
from vcmm.nc.faults import BlockFault
from vcmm.nc.frames import AffineMap, rotation, stretched, translation
from vcmm.nc.moves import PLANES
from vcmm.nc.setup import Tool
from vcmm.nc.sinumerik import cycles
from vcmm.nc.sinumerik.blocks import ADDRESSES, Item, SinumerikBlock
from vcmm.nc.sinumerik.codes import CODES, IDLE, IDLE_G, LATER, SWITCHES
from vcmm.nc.sinumerik.flow import SinumerikRunner
from vcmm.nc.sinumerik.paths import SinumerikPaths
from vcmm.nc.sinumerik.state import AXES, CENTRES, ROTARY, SinumerikWords, point_of
from vcmm.nc.sinumerik.text import FUNCTIONS
from vcmm.nc.sinumerik.traces import words_of
from vcmm.nc.state import Modal
from vcmm.nc.trace import BlockPlace

FRAMES = ("TRANS", "ATRANS", "ROT", "AROT", "SCALE", "ASCALE", "MIRROR", "AMIRROR")


class SinumerikInterpreter(SinumerikPaths):
    """Executes blocks on a recorder."""

    def work(self, runner: SinumerikRunner, block: SinumerikBlock) -> bool:
        """One block. True where the program or subprogram ends with it."""
        made, before = len(self.r.moves), self.r.modal() if self.r.tracer else None
        words = self.collect(runner, block)
        self.codes(words)
        self.technology(words)
        ended = self.functions(words, before=True)
        if not self.special(words):
            self.motion(words)
        if words.items:
            item = next(iter(words.items.values()))
            raise BlockFault(
                item.first,
                f"{item.name} has no use in this block; remove it or add the function that it belongs to",
            )
        self.functions(words, before=False)
        self.note(made, before, runner, block)
        for command in words.commands:
            self.command(runner, command)
        self.note(made, before, runner, block)
        self.r.exact_once = False
        return ended

    def note(self, made: int, before: Modal | None, runner: SinumerikRunner, block: SinumerikBlock) -> None:
        """What the moves since `made` came from, where traces are kept."""
        tracer = self.r.tracer
        if tracer is not None and before is not None and len(self.r.moves) > made:
            words = words_of(block, tracer.lines[block.line - 1])
            place = BlockPlace(self.r.file, block.line, len(runner.scopes) - 1)
            tracer.note(self.r, made, before, words, place)

    # -- sorting --
    def collect(self, runner: SinumerikRunner, block: SinumerikBlock) -> SinumerikWords:
        words = SinumerikWords(runner, block)
        for item in block.items:
            if item.name == "R" or (item.value is not None and runner.defined(item.name)):
                runner.assign(item)
            elif item.name == "G" and item.number is None:
                words.g[f"G{self.whole(words, item)}"] = item.first
            elif item.name == "M":
                words.m.append(self.whole(words, item))
            elif item.name == "L" and item.number is None:
                words.commands.append(item._replace(name=f"L{item.text}"))
            elif self.is_command(item):
                words.commands.append(item)
            else:
                self.add(words, item)
        return words

    def is_command(self, item: Item) -> bool:
        return len(item.name) > 1 and item.name not in ADDRESSES

    def add(self, words: SinumerikWords, item: Item) -> None:
        name = item.name if item.number is None else f"{item.name}{item.number(words.runner)}"
        if name in ("M1", "S1", "T1") and item.number is not None:
            name = item.name
        known = (*AXES, *ROTARY, *CENTRES, "I1", "J1", "K1", "F", "S", "T", "D", "H", "P", *ADDRESSES)
        if name not in known:
            raise BlockFault(
                item.first,
                f"the address {name} is not understood.{did_you_mean(name, known)} Axes are X Y Z A B C",
            )
        if name in words.items:
            raise BlockFault(item.first, f"{name} stands twice in this block; remove one")
        words.items[name] = item._replace(name=name)

    def whole(self, words: SinumerikWords, item: Item) -> int:
        value = words.number(item)
        if abs(value - round(value)) > 1e-6 or value < 0:
            raise BlockFault(
                item.first, f"{item.name}{value:g} is no function; numbers of functions are whole"
            )
        return round(value)

    # -- modal functions --
    def codes(self, words: SinumerikWords) -> None:
        for code in sorted(words.g, key=lambda c: int(c[1:])):
            handler, self.column = CODES.get(code), words.g[code]
            number = int(code[1:])
            if handler is not None:
                handler(self)
            elif code in IDLE_G or code in ("G4", "G53", "G153", "G74"):
                continue
            elif code == "G500" or 54 <= number <= 57 or 505 <= number <= 599:
                self.r.set_offset(code)
            else:
                raise BlockFault(self.column, f"{code}{LATER}")
        names = {c.name for c in words.commands}
        for command in list(words.commands):
            if command.name in IDLE:
                words.commands.remove(command)
            elif command.name in SWITCHES:
                self.column = command.first
                SWITCHES[command.name](self)
                words.commands.remove(command)
        if names & {"COMPON", "COMPCURV", "COMPCAD", "COMPSURF"}:
            self.r.remark("a compressor (COMPON ...) is on; the programmed lines are kept as they are")
            words.commands[:] = [c for c in words.commands if not c.name.startswith("COMP")]

    def technology(self, words: SinumerikWords) -> None:
        """F S T D, ADIS and other values that are kept."""
        r, dwell = self.r, "G4" in words.g
        if words.has("LIMS"):
            r.speed_limit = words.take("LIMS") or math.inf
        if words.has("F") and not dwell:
            feed = words.take("F") or 0.0
            r.feed = feed * (self.modes.feed_unit if r.feed_mode != "G93" else 1.0)
        if words.has("S") and not dwell:
            r.speed = words.take("S") or 0.0
        if words.has("T"):
            self.tool(words.items.pop("T"), words)
        if words.has("D"):
            self.edge(words)
        if words.has("ADIS", "ADISPOS"):
            words.take("ADIS"), words.take("ADISPOS")
            r.remark(
                "ADIS is a distance along the path, no tolerance across it: corners are rounded by the control's own tolerance (CTOL= states one)"
            )
        if words.has("CTOL"):
            r.tolerance = (words.take("CTOL") or 0.0) * self.r.unit
        if words.has("RNDM"):
            self.modes.rnd = (words.take("RNDM") or 0.0) * self.r.unit
        for name in ("H", "FRC", "FRCM", "SPOS"):
            words.take(name)

    def tool(self, item: Item, words: SinumerikWords) -> None:
        number = None if item.text and item.value is None else self.whole(words, item)
        name = item.text if number is None else f"T{number}"
        tool = self.find_tool(number, name)
        if self.modes.by_m6:
            self.modes.next_tool, self.modes.next_name = tool, name
        else:
            self.r.change_tool(tool, name)

    def find_tool(self, number: int | None, name: str) -> Tool:
        tools = self.r.setup.tools
        if number is not None:
            if number and number not in tools:
                self.r.remark(f"tool {number} is not in the set-up; its length is taken as zero")
            return tools.get(number, Tool(number))
        for tool in tools.values():
            if tool.name.upper() == name.upper():
                return tool
        known = {n: k for k, n in self.r.called.items()}
        self.r.remark(f'no tool of the set-up has the name "{name}"; its length is taken as zero')
        free = (
            max([*tools, *self.r.called, self.modes.next_tool.number if self.modes.next_tool else 0, 0]) + 1
        )
        return Tool(known.get(name, free), name=name)

    def edge(self, words: SinumerikWords) -> None:
        item = words.items["D"]
        number = words.take("D")
        if number == 0:
            self.r.free("D0 takes the tool offset off")
            self.r.set_length((0.0, 0.0, 0.0))
        elif number == 1:
            self.r.set_length(self.r.tool_data.offset)
        else:
            raise BlockFault(
                item.first,
                f"D{number:g}: the set-up knows one cutting edge per tool, D1; enter the other edge as a tool of its own",
            )

    def functions(self, words: SinumerikWords, before: bool) -> bool:
        """M functions: M3 M4 M6 act before the motion, M5 after it. True at the end of the program."""
        for m in words.m:
            if before and m in (3, 4):
                self.r.sense = 1 if m == 3 else -1
            elif not before and m == 5:
                self.r.sense = 0
            elif before and m == 6 and self.modes.next_tool is not None:
                self.r.change_tool(self.modes.next_tool, self.modes.next_name)
            elif before and m not in (0, 1, 2, 5, 6, 7, 8, 9, 17, 30, *range(40, 46), 19, 70):
                self.r.remark(
                    f"M{m} belongs to the machine builder; it is taken to move nothing", words.block.first
                )
        if words.m and 30 in words.m and len(words.runner.scopes) == 1:
            words.runner.ended = False
        return any(m in (2, 17, 30) for m in words.m)

    # -- blocks that are no motion --
    def special(self, words: SinumerikWords) -> bool:
        if "G4" in words.g:
            self.dwell(words)
            return True
        frames = [c for c in words.commands if c.name in FRAMES]
        if frames:
            words.commands.remove(frames[0])
            self.frame(words, frames[0].name)
            return True
        if "G74" in words.g:
            self.reference(words)
            return True
        return False

    def dwell(self, words: SinumerikWords) -> None:
        if words.has("F"):
            self.r.dwell(words.take("F") or 0.0)
        elif words.has("S"):
            turns = words.take("S") or 0.0
            if not self.r.speed:
                self.r.fault("G4 S counts turns of the spindle, which has no speed; give G4 F in seconds")
            self.r.dwell(turns * 60.0 / self.r.speed)
        else:
            self.r.fault("G4 takes F (seconds) or S (turns of the spindle), as in G4 F1.5")

    def reference(self, words: SinumerikWords) -> None:
        """G74 X1=0: the named axes go to their reference point."""
        axes = [
            k for k in range(3) if words.take(AXES[k]) is not None or words.take(f"{AXES[k]}1") is not None
        ]
        o, home, tip = self.r.tool_offset, self.r.setup.reference, self.r.tip()
        target = [home[k] - o[k] if k in axes else tip[k] for k in range(3)]
        self.r.to_machine((target[0], target[1], target[2]), rapid=True)

    def frame(self, words: SinumerikWords, name: str) -> None:
        base = self.r.frame if name.startswith("A") else AffineMap()
        kind = name.removeprefix("A") if name.startswith("A") else name
        values = [words.take(a) for a in AXES]
        if kind == "TRANS":
            made = translation(point_of([(v or 0.0) * self.r.unit for v in values]))
        elif kind == "ROT":
            made = self.turned(words, values)
        elif kind == "SCALE":
            if any(v is not None and v <= 0 for v in values):
                self.r.fault(f"{name} takes factors above zero; MIRROR mirrors")
            made = stretched(point_of([1.0 if v is None else v for v in values]))
        else:
            made = stretched(point_of([1.0 if v is None else -1.0 for v in values]))
        self.r.set_frame(base.then(made))

    def turned(self, words: SinumerikWords, values: list[float | None]) -> AffineMap:
        """RPL= in the plane, or X Y Z in the order of RPY angles: about Z, the new Y, the new X."""
        angle = words.take("RPL")
        if angle is not None:
            return rotation(PLANES[self.r.plane][2], math.radians(angle))
        made = AffineMap()
        for axis in (2, 1, 0):
            made = made.then(rotation(axis, math.radians(values[axis] or 0.0)))
        return made

    def command(self, runner: SinumerikRunner, item: Item) -> None:
        """A named command left over: a cycle, MCALL, or a subprogram of this file."""
        if item.name == "MCALL":
            self.modes.cycle = None
        elif item.name in cycles.CYCLES:
            cycles.run(self, runner, item)
        elif item.name in runner.sections:
            runner.call(item)
        elif item.name == "SETAL":
            raise BlockFault(
                item.first,
                "the program raises its own alarm here (SETAL); see what it checks before this block",
            )
        else:
            known = [*runner.sections, *SWITCHES, *FRAMES, *FUNCTIONS, *cycles.CYCLES]
            raise BlockFault(
                item.first,
                f"{item.name} is neither a subprogram of this file nor a command that is understood.{did_you_mean(item.name, known)} "
                "Add the subprogram to this file (PROC ... RET) or rewrite it with G0 to G3",
            )
