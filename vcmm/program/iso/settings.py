"""Settings of the control on which the path of a cycle depends and which no program states: what is taken for each, told with its number.

Source: FANUC B-64304EN-1, parameters that stand with each cycle ("multiple repetitive cycle", "canned cycle for drilling"); Haas lathe
operator's manual, settings 22, 72, 73, 95 and 96. A word of the program that gives such a setting stays in force for the next cycle of its kind.
"""

from __future__ import annotations

from vcmm.program.iso.control import IsoControl

KIND_OF = {"G71": "rough", "G72": "rough", "G73": "pattern", "G74": "peck", "G75": "peck", "G76": "thread"}


def keep_setting(c: IsoControl, code: str, words: dict[str, float]) -> None:
    """Keep what the first of two blocks states; it stays in force, for G71 and G72 and for G74 and G75 together, until another one changes it."""
    c.turning_words[KIND_OF[code]] = c.turning_words.get(KIND_OF[code], {}) | words


def setting_kept(c: IsoControl, code: str) -> dict[str, float]:
    """Return what a first block has stated for this cycle; empty where none did."""
    return c.turning_words.get(KIND_OF[code], {})


def _name(c: IsoControl, fanuc: str, haas: str) -> str:
    """Return what the setting is called on this control."""
    if c.language.name == "okuma":
        return "a parameter of the control"
    return f"Haas setting {haas}" if c.language.haas else f"FANUC parameter {fanuc}"


def tell_escape(c: IsoControl, code: str) -> None:
    """Note, for G71 and G72 without R, how far the tool comes off before it goes back."""
    what = f"how far the tool comes off after a pass of {code} ({_name(c, '5133', '73')})"
    c.assume(what, "0 mm: back at the height of the pass", column=c.column, matters=False)


def tell_return(c: IsoControl, code: str) -> None:
    """Note, for G74 and G75 without R, how far the tool comes back after a peck."""
    what = f"how far the tool comes back after a peck of {code} ({_name(c, '5139', '22')})"
    c.assume(what, "0 mm: the pecks follow one another", column=c.column, matters=False)


def tell_pull_out(c: IsoControl, code: str, leads: float | None) -> None:
    """Note the chamfer at the end of a thread, in leads; None where the control alone knows it, 0 where there is none."""
    if leads == 0.0:
        return
    source = _name(c, "5130", "95 and 96") if leads is None else f"P: {leads:g} times the lead, at 45 degrees"
    c.assume(
        f"the pull-out at the end of a thread of {code} ({source})", "none: along to the end, and square out", column=c.column, matters=False
    )  # fmt: skip


def tell_clearance(c: IsoControl, code: str) -> None:
    """Note, for G73 and G83 with pecks, how far before the depth reached the tool goes on at feed, or how far it comes back."""
    if c.language.words != "macro":
        return  # LinuxCNC: fixed in the interpreter
    number = _name(c, "5114", "22") if code == "G73" else _name(c, "5115", "22")
    way = "comes back after a peck of G73" if code == "G73" else "stays before the depth reached with G83"
    c.assume(f"how far the tool {way} ({number})", f"{c.language.peck_clearance:g} mm", column=c.column, matters=False)  # fmt: skip
