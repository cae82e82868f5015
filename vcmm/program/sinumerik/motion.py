"""Effects of the words of a Sinumerik block. Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Fundamentals."""

from __future__ import annotations

import math

from vcmm.core.errors import did_you_mean
from vcmm.program.faults import BlockFault
from vcmm.program.levels import NOT_MOVED, pass_over, unknown_tool
from vcmm.program.setup import Tool, has_driven
from vcmm.program.sinumerik import cycles
from vcmm.program.sinumerik.blocks import ADDRESSES, AXIAL, Item, SinumerikBlock
from vcmm.program.sinumerik.codes import CODES, IDLE, IDLE_G, LATER, SWITCHES
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.specials import FRAMES, SinumerikSpecials
from vcmm.program.sinumerik.state import AXES, CENTRES, ROTARY, SinumerikWords, written_word
from vcmm.program.sinumerik.text import FUNCTIONS
from vcmm.program.sinumerik.traces import words_of
from vcmm.program.state import Modal
from vcmm.program.trace import BlockPlace

SPECIAL = ("G4", "G53", "G153", "G74", "G75", "G110", "G111", "G112", "G58", "G59")
CALLS = ("CALL", "PCALL", "EXTCALL", "ISOCALL", "MCALL")
HOMES = ("X1", "Y1", "Z1", "A1", "B1", "C1")  # machine axes of G74 and G75
CHANNELS = {  # what belongs to other channels
    "INIT": "chooses a program for another channel, which is not read here: read it on its own",
    "START": "starts another channel, which is not read here: read its program on its own",
    "WAITM": "waits for another channel; how long is not known, and no time is counted",
}
WITHOUT_PATH = (  # they change speeds and spindles, not the path
    "FRC", "FRCM", "SPOS", "SPOSA", "FB", "FD", "FA", "SD", "PW", "PL", "SF", "ACC", "OVR", "OVRRAP", "SVC", "SCC", "DISC", "DISR",
    "DISCL", "DISRP", "FAD", "POLF", "PM", "POSP", "SPINU",
)  # fmt: skip
DIRECTIONS = (*(f"{a}{n}" for a in ROTARY for n in (2, 3, 4, 5)), "LEAD", "TILT", "THETA")


class SinumerikInterpreter(SinumerikSpecials):
    """Executes blocks on a recorder."""

    def work(self, runner: SinumerikRunner, block: SinumerikBlock) -> bool:
        """Execute one block. True where the program or subprogram ends with it."""
        made, before = len(self.r.moves), self.r.modal() if self.r.tracer else None
        words = self.collect(runner, block)
        if not (words.items or words.commands or words.g or words.m):
            return False  # assignments alone
        self.codes(words)
        if words.items:
            self.technology(words)
        ended = self.functions(words, before=True)
        if not self.special(words):
            self.motion(words)
        times = round(words.take("P") or 1.0) if words.commands else 1
        for item in words.items.values():
            pass_over(self.r, written_word(words, item), item.first, name=item.name)
        self.functions(words, before=False)
        self.note(made, before, runner, block)
        for command in words.commands:
            self.command(runner, command, times)
        self.note(made, before, runner, block)
        self.r.exact_once = False
        return ended

    def short(self, block: SinumerikBlock) -> bool:
        """Execute a plain block where nothing special is in force: as `work`, but faster. False: nothing is done."""
        r, modes, line = self.r, self.modes, block.read()
        if (
            line is None
            or r.tracer
            or r.compensation
            or modes.cycle
            or modes.rnd
            or r.exact_once
            or r.unmoved_axes
            or r.diameter
            or not r.absolute
        ):
            return False
        motion = line.motion or r.motion
        if motion not in ("G0", "G1") or r.feed_mode == "G93":
            return False
        r.motion = motion
        if line.feed is not None:
            r.feed = line.feed * modes.feed_unit
        point = list(r.p)
        for k, value in line.axes:
            point[k] = value * r.unit
        r.straight((point[0], point[1], point[2]), motion == "G0")
        return True

    def note(self, made: int, before: Modal | None, runner: SinumerikRunner, block: SinumerikBlock) -> None:
        """Note the origin of the moves since `made`, where traces are kept."""
        tracer = self.r.tracer
        if tracer is not None and before is not None and len(self.r.moves) > made:
            words = words_of(block, tracer.lines[block.line - 1])
            place = BlockPlace(self.r.file, block.line, len(runner.scopes) - 1)
            tracer.note(self.r, made, before, words, place)

    # -- sorting --
    def collect(self, runner: SinumerikRunner, block: SinumerikBlock) -> SinumerikWords:
        words = SinumerikWords(runner, block)
        for item in block.items:
            if (
                item.name == "R"
                or item.name[0] == "$"
                or (item.value is not None and runner.is_defined(item.name))
            ):
                runner.assign(item)
            elif item.indices:
                self.execute_indexed(words, item)
            elif item.name == "G" and item.number is None:
                words.g[f"G{self.whole(words, item)}"] = item.first
            elif item.name == "M":
                words.m.append(self.whole(words, item))
            elif item.name == "L" and item.number is None:
                words.commands.append(item._replace(name=f"L{item.text}"))
            elif self.is_command(item):
                self.execute_name(words, item)
            else:
                self.add(words, item)
        return words

    def execute_name(self, words: SinumerikWords, item: Item) -> None:
        """Execute a command, or a variable that the program does not define."""
        has_value = item.value is not None or item.text
        if has_value and item.name not in CALLS and item.name not in SWITCHES:
            words.runner.assign(item)
        else:
            words.commands.append(item)

    def execute_indexed(self, words: SinumerikWords, item: Item) -> None:
        """Execute AX[_Z]=5, POS[X]=10: an axis named by a variable; an element of an array; ACC[X]=50 and its like move nothing."""
        if item.name not in AXIAL:
            words.runner.assign(item)
            return
        axis = item.indices[0](words.runner) if callable(item.indices[0]) else item.indices[0]
        if item.name in ("SPOS", "SPOSA") and axis == 1:
            words.items["SPOS1"] = item._replace(name="SPOS1", indices=())
            return
        if item.name in ("AX", "POS", "POSA", "POSP", "PO") and isinstance(axis, str) and axis:
            words.by_itself |= item.name.startswith("POS")
            self.add(words, item._replace(name=axis.upper(), indices=()))
        elif item.name in ("AX", "POS", "POSA", "POSP"):
            self.r.assume(
                "an axis whose name only the machine knows",
                "its motion is passed over",
                f"{item.name}[...] names no axis of this program",
            )
        elif item.name == "FXS":
            self.r.assume(
                "FXS (travel to a fixed stop)", "passed over: no stop, to the end point", f"FXS (travel to a fixed stop){LATER}"
            )  # fmt: skip

    def is_command(self, item: Item) -> bool:
        return len(item.name) > 1 and item.name not in ADDRESSES

    def add(self, words: SinumerikWords, item: Item) -> None:
        name = item.name if item.number is None else f"{item.name}{item.number(words.runner)}"
        if name[0] in "SM" and name[1:].isdigit() and item.number is not None and has_driven(self.r.setup):
            self.spindle_of(int(name[1:]), name[0], words.number(item))
            return
        if name in ("M1", "S1", "T1") and item.number is not None:
            name = item.name
        if name[0] == "H":
            self.r.remark(
                f"{name} is an auxiliary function of the machine builder; it is taken to move nothing",
                item.first,
                "H",
            )
            return
        names = (*AXES, *ROTARY, *CENTRES, "I1", "J1", "K1", "F", "S", "T", "D", "P", *ADDRESSES)
        if name not in names and name not in HOMES:
            self.r.assume(
                f"the axis or spindle {name}", "passed over",
                f"the address {name} is not understood.{did_you_mean(name, names)} Axes are X Y Z A B C", column=item.first,
            )  # fmt: skip
            return
        if name in words.items:
            raise BlockFault(item.first, f"{name} appears twice in this block; remove one")
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
            elif code in IDLE_G or code in SPECIAL:
                continue
            elif code == "G500" or 54 <= number <= 57 or 505 <= number <= 599:
                self.r.set_offset(code)
            else:
                raise BlockFault(self.column, f"{code}{LATER}")
        names = {c.name for c in words.commands}
        for command in list(words.commands):
            if command.name == "SETMS" and has_driven(self.r.setup):
                arguments = cycles.arguments_of(words.runner, command)
                self.master(round(arguments[0]) if arguments and arguments[0] else 1)
                words.commands.remove(command)
            elif command.name in IDLE:
                if command.name in CHANNELS:
                    self.r.remark(f"{command.name} {CHANNELS[command.name]}", command.first, command.name)
                words.commands.remove(command)
            elif command.name in SWITCHES:
                self.column = command.first
                is_end = command.value is not None and words.number(command) == 0.0  # TCARR=0
                if not is_end:
                    SWITCHES[command.name](self)
                words.commands.remove(command)
        if names & {"COMPON", "COMPCURV", "COMPCAD", "COMPSURF"}:
            self.r.remark("a compressor (COMPON ...) is on; the programmed lines are kept as they are")
            words.commands[:] = [c for c in words.commands if not c.name.startswith("COMP")]

    def technology(self, words: SinumerikWords) -> None:
        """Execute F S T D, ADIS and other values that are kept."""
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
        self.position_spindle(words)
        if words.has("CTOL"):
            r.tolerance = (words.take("CTOL") or 0.0) * self.r.unit
        if words.has("RNDM"):
            self.modes.rnd = (words.take("RNDM") or 0.0) * self.r.unit
        if words.take("DL"):
            r.assume("DL= (sum offset of the tool)", "none", f"DL= (sum offset of the tool){LATER}")
        for name in WITHOUT_PATH:
            if words.items.pop(name, None) is not None:
                r.remark(
                    f"{name}= changes speeds and spindles, not the path; it is passed over", kind=f"{name}="
                )
        if words.has("A3", "B3", "C3"):
            x, y, z = (words.take(name) or 0.0 for name in ("A3", "B3", "C3"))
            r.point_to((x, y, z))
        if words.take("OFFN"):
            r.assume("OFFN= (oversize of the contour)", "none", f"OFFN= (oversize of the contour){LATER}")
        if words.has("STAT", "TU"):
            words.take("STAT"), words.take("TU")
            r.assume("which position of the axes STAT= and TU= mean", "the nearest", matters=False)
        if words.has(*DIRECTIONS):
            words.items = {k: v for k, v in words.items.items() if k not in DIRECTIONS}
            what = "tool directions (LEAD, TILT, A4= B4= C4=)"
            r.assume(what, "the rotary axes stay as they are", f"tool directions (LEAD, TILT, A4=){LATER}")

    def position_spindle(self, words: SinumerikWords) -> None:
        """Position the spindle, SPOS=30, SPOS[1]=30: where tools are driven the first spindle holds the part, and is axis C."""
        r = self.r
        names = ("SPOS1", "SPOS", "SPOSA") if self.modes.master == 1 else ("SPOS1",)
        for name in names if has_driven(r.setup) else ():
            angle = words.take(name)
            if angle is not None and math.radians(angle) != r.rotary[2]:
                r.straight(r.p, True, (r.rotary[0], r.rotary[1], math.radians(angle)))
        words.items.pop("SPOS1", None)

    def spindle_of(self, number: int, letter: str, value: float) -> None:
        """Set the spindle of S2=2000 M2=3: another spindle than the master, that of a driven tool."""
        if number == self.modes.master:
            if letter == "S":
                self.r.speed = value
            else:
                self.r.sense = {3: 1, 4: -1, 5: 0}.get(round(value), self.r.sense)
            return
        sense, speed = self.modes.turning.get(number, (0, 0.0))
        if letter == "S":
            speed = value
        else:
            sense = {3: 1, 4: -1, 5: 0}.get(round(value), sense)
        self.modes.turning[number] = (sense, speed)

    def master(self, number: int) -> None:
        """Set the master spindle by SETMS(2): S, M3 and feeds per turn are those of this spindle from here on; SETMS: of the first."""
        modes, r = self.modes, self.r
        if number != modes.master:
            modes.turning[modes.master] = (r.sense, r.speed)
            r.sense, r.speed = modes.turning.get(number, (0, 0.0))
            modes.master = number

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
                unknown_tool(self.r, number, f"T{number}")
            return tools.get(number, Tool(number))
        for tool in tools.values():
            if tool.name.upper() == name.upper():
                return tool
        numbers = {n: k for k, n in self.r.tool_names.items()}
        free = (
            max([*tools, *self.r.tool_names, self.modes.next_tool.number if self.modes.next_tool else 0, 0])
            + 1
        )
        free = numbers.get(name, free)
        unknown_tool(self.r, 0, name, free=free)
        return Tool(free, name=name)

    def edge(self, words: SinumerikWords) -> None:
        item = words.items["D"]
        number = words.take("D")
        if number == 0:
            self.r.free("D0 takes the tool offset off")
            self.r.set_length((0.0, 0.0, 0.0))
        elif number == 1:
            self.r.set_length(self.r.tool_data.offset)
        else:
            self.r.assume(
                f"the cutting edge D{number:g} of tool {self.r.tool}", "that of D1",
                f"D{number:g}: the set-up knows one cutting edge per tool, D1; enter the other edge as a tool of its own", column=item.first,
            )  # fmt: skip
            self.r.set_length(self.r.tool_data.offset)

    def functions(self, words: SinumerikWords, before: bool) -> bool:
        """Execute M functions: M3 M4 M6 act before the motion, M5 after it. True at the end of the program."""
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
            words.runner.has_ended = False
        return any(m in (2, 17, 30) for m in words.m)

    def command(self, runner: SinumerikRunner, item: Item, times: int = 1) -> None:
        """Execute a named command left over: a cycle, MCALL, or a subprogram of this file or beside it."""
        if item.name in CALLS[:-1]:
            called = item.text.replace("\\", "/").split("/")[-1].upper()
            item = item._replace(
                name=called.removesuffix(".SPF").removesuffix(".MPF") or "a called program", arguments=()
            )
        if item.name == "MCALL":
            self.modes.cycle = None
        elif (
            item.name in runner.sections and item.name in cycles.CYCLES and runner.sections[item.name].blocks
        ):
            self.subprogram(runner, item, times)  # the program brings a cycle of its own
        elif item.name in cycles.CYCLES:
            cycles.run(self, runner, item, self.modes.cycle_line if item is self.modes.cycle else 0)
        elif item.name == "SETAL":
            self.r.assume(
                "an alarm that the program raises itself (SETAL)", "passed over",
                "the program raises its own alarm here (SETAL); see what it checks before this block", column=item.first,
            )  # fmt: skip
        elif runner.find(item.name) is not None:
            self.subprogram(runner, item, times)
        else:
            names = [*runner.sections, *SWITCHES, *FRAMES, *FUNCTIONS, *cycles.CYCLES]
            what = (
                "the cycle"
                if item.name.startswith(("CYCLE", "POCKET", "SLOT", "LONGHOLE"))
                else "the subprogram"
            )
            self.r.assume(
                f"{what} {item.name}", NOT_MOVED,
                f"{item.name} is neither a subprogram of this file nor a command that is understood.{did_you_mean(item.name, names)} "
                "Add the subprogram to this file (PROC ... RET) or rewrite it with G0 to G3", column=item.first,
            )  # fmt: skip
            runner.memory.sure = False  # it may have changed what the program goes on with

    def subprogram(self, runner: SinumerikRunner, item: Item, times: int) -> None:
        """Call a subprogram; with SAVE, modal functions and frames are the caller's again behind it."""
        before = self.modal_state() if runner.sections[item.name].saves else None
        runner.call(item, times)
        if before is not None:
            self.restore(before)
