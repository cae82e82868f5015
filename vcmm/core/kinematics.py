"""Kinematic chains: nominal transforms, and the propagation of small error motions to the tip.

Rules (all frames coincide with the machine frame when every axis is at zero):

    structure "w C' Y' b X Z t" is read from workpiece to tool through the bed b; a prime marks an axis that carries
    the workpiece and is commanded in tool-relative coordinates (its nominal motion is by -q).
    T(axis) = L · T_nominal(q) · E   (error_frame "fixed": L · E · T_nominal(q)), E about the point `measured_at`,
    L (location of a rotary axis) about `centre`; squareness turns the direction of travel only.
    A rotary axis about a `direction` d that is not that of its letter e (a head tilted by 45 deg; the other sense): C · L · T_nominal(q) · E · C^-1,
    C: p -> c + R (p - c) about `centre`, R the shortest turn of e into d (`alignment`); its errors are those of this turned frame.
    tip = T_work^-1 · T_tool · offset, in workpiece axes; tip error = actual - nominal.

`tip_motion` is first order: each error motion is carried to the tip by its lever arm and all are added.
`exact_tip_error` multiplies the transforms, one rotation vector per axis. Small and slow beside fast: a test bounds
the difference.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from vcmm.core.axes import AXIS_NAMES, LINEAR, is_axis, is_rotary, unit_vector
from vcmm.core.errors import UsageError
from vcmm.core.rigid import Frame, rotation_from_vector, shortest_turn
from vcmm.core.run import Array, Run

CHUNK = 1 << 15  # rows at a time: the working arrays stay in the cache
FULL_TURN = float(np.radians(345.0))  # rad: from here an axis is taken to have come back to where it was


@dataclass(frozen=True)
class Axis:
    """One axis. travel in mm or rad (endless: one turn to look at); centre, measured_at in mm (machine frame, all axes at zero).

    direction: of a rotary axis that turns about another line than that of its letter, a unit vector in the machine frame; None: the letter's.
    """

    letter: str
    travel: tuple[float, float]
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    measured_at: tuple[float, float, float] | None = None
    error_frame: str = "moving"
    dynamics: Mapping[str, float] = field(default_factory=dict)
    is_endless: bool = False
    direction: tuple[float, float, float] | None = None

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest position that the axis reaches, mm or rad; infinite where it turns endlessly."""
        return (-np.inf, np.inf) if self.is_endless else self.travel

    @property
    def rotary(self) -> bool:
        return is_rotary(self.letter)

    @property
    def pivot(self) -> Array:
        """The point whose displacement the translation errors describe (ISO 230-1: where they were measured)."""
        if self.measured_at is not None:
            return np.array(self.measured_at)
        return np.array(self.centre) if self.rotary else np.zeros(3)

    @property
    def own_pivot(self) -> Array:
        """The same point in the frame of the axis, which `direction` turns about `centre`."""
        turn = self.alignment
        centre = np.array(self.centre)
        return self.pivot if turn is None else np.asarray(centre + turn.T @ (self.pivot - centre))

    @property
    def alignment(self) -> Array | None:
        """R (3, 3): from the directions of the axis frame, in which its letter is the axis of rotation, to those of the machine."""
        return None if self.direction is None else shortest_turn(self.letter, np.array(self.direction))


@dataclass(frozen=True)
class Chain:
    """tool, work: axis letters from the bed outwards."""

    structure: str
    tool: tuple[str, ...]
    work: tuple[str, ...]

    @property
    def letters(self) -> tuple[str, ...]:
        return self.tool + self.work


def parse_structure(text: str) -> Chain:
    """Parse the structure of a machine: 'w b Y X Z t' -> Chain. Raises UsageError: no w/b/t, a repeated or unknown axis, a prime on the
    wrong side."""
    words = text.split()
    example = "write for example structure = \"w X' Y' b Z t\" (workpiece to tool through the bed b)"
    if len(words) < 3 or words[0] != "w" or words[-1] != "t" or words.count("b") != 1:
        raise UsageError(f'structure = "{text}" must start with w, end with t and hold one b; {example}')
    bed = words.index("b")
    work, tool = words[1:bed], words[bed + 1 : -1]
    for word in work + tool:
        if not is_axis(word.removesuffix("'")):
            raise UsageError(
                f'structure = "{text}": unknown axis "{word}"; allowed are {AXIS_NAMES}, primed before b; {example}'
            )
    if any(not word.endswith("'") for word in work) or any(word.endswith("'") for word in tool):
        raise UsageError(
            f'structure = "{text}": axes before b carry the workpiece and take a prime, axes after b take none; {example}'
        )
    letters = [word.removesuffix("'") for word in work + tool]
    for letter in letters:
        if letters.count(letter) > 1:
            cure = f": number them, {letter}1 and {letter}2" if is_axis(f"{letter}1") else ""
            raise UsageError(
                f'structure = "{text}" names axis {letter} {letters.count(letter)} times; each axis once{cure}'
            )
    return Chain(text, tuple(tool), tuple(word.removesuffix("'") for word in reversed(work)))


@dataclass(frozen=True)
class Motion:
    """One effect's six numbers (n, 6), already with the sign of the link's own motion (see `signed`)."""

    link: str
    place: str
    six: Array


LinkSums = dict[tuple[str, str], Array]  # (link, place) -> six numbers (n, 6)


def nominal_motion(axis: Axis, q: Array, carries_work: bool) -> Frame:
    """Transform of one axis in its own frame: by q, or by -q for an axis that carries the workpiece."""
    amount = -q if carries_work else q
    if not axis.rotary:
        return Frame(None, amount[:, None] * unit_vector(axis.letter))
    rotation = rotation_from_vector(amount[:, None] * unit_vector(axis.letter))
    centre = np.array(axis.centre)
    return Frame(rotation, centre - rotation @ centre)


@dataclass(frozen=True)
class Pose6:
    """Pose of the own frame of a link, seen from the bed: `before` its nominal motion and `after` it."""

    before: Frame
    after: Frame


def _frame_of_direction(axis: Axis, n: int) -> Frame | None:
    """Return the frame C, from an axis with a direction of its own to the link which carries it; None for all others."""
    turn = axis.alignment
    if turn is None:
        return None
    centre = np.array(axis.centre)
    return Frame(np.broadcast_to(turn, (n, 3, 3)), np.broadcast_to(centre - turn @ centre, (n, 3)))


LinkFrames = tuple[dict[str, Pose6], Frame, Frame]  # of every link; the ends of the tool and workpiece chains


def link_frames(chain: Chain, axes: Mapping[str, Axis], run: Run) -> LinkFrames:
    """Return the frames of every link, and the ends of the tool and workpiece chains."""
    still = Frame(None, np.zeros((run.n, 3)))
    frames: dict[str, Pose6] = {}
    ends = []
    for side, carries_work in ((chain.tool, False), (chain.work, True)):
        here = still
        for letter in side:
            turn = _frame_of_direction(axes[letter], run.n)
            before = here if turn is None else here.then(turn)
            after = before.then(nominal_motion(axes[letter], run.q(letter), carries_work))
            frames[letter] = Pose6(before, after)
            here = after if turn is None else after.then(turn.inverse())
        ends.append(here)
    return frames, ends[0], ends[1]


def nominal_tip(chain: Chain, axes: Mapping[str, Axis], run: Run) -> Array:
    """Return the nominal tip position (n, 3) mm in workpiece axes."""
    out = np.empty((run.n, 3))
    for i in range(0, run.n, CHUNK):
        rows = slice(i, i + CHUNK)
        part = Run({a: run.q(a)[rows] for a in chain.letters}, run.offset[rows])
        _, tool, work = link_frames(chain, axes, part)
        out[rows] = work.undo(tool.apply(part.offset))
    return out


def tip_motion(chain: Chain, axes: Mapping[str, Axis], run: Run, motions: Sequence[Motion]) -> Array:
    """Return the first-order motion of the tip (n, 6) in workpiece axes, actual - nominal: x y z mm, a b c rad.

    `motions` are in tip sense. A motion (t, r) of a link about its pivot m moves the tip by t + r x (p - m).
    """
    frames_of = link_frames(chain, axes, run)
    _, tool, work = frames_of
    tip = tool.apply(run.offset)
    total = np.zeros((run.n, 6))
    for motion in motions:
        frame, shift, turn = _carry_motion(motion, frames_of, axes, tip, run)
        total[:, :3] += work.turn_back(frame.turn(shift))
        total[:, 3:] += work.turn_back(frame.turn(turn))
    return total


def commanded_directions(ends: LinkFrames, n: int) -> Array:
    """Return the way of the tip in workpiece axes per mm of commanded X, Y and Z, as columns (n, 3, 3).

    ends: `link_frames` of a run of n rows. The identity while all rotary axes are at zero; a direction in which no axis
    moves is that of the machine frame.
    """
    frames, _, work = ends
    columns = []
    for letter in LINEAR:
        way = np.tile(unit_vector(letter), (n, 1))
        columns.append(work.turn_back(frames[letter].before.turn(way) if letter in frames else way))
    return np.stack(columns, axis=2)


def _carry_motion(
    motion: Motion, frames_of: LinkFrames, axes: Mapping[str, Axis], tip: Array, run: Run
) -> tuple[Frame, Array, Array]:
    """Return (frame in which the motion is expressed, tip shift, turn), both (n, 3) in that frame."""
    frames, tool, work = frames_of
    shift, turn = motion.six[:, :3], motion.six[:, 3:]
    if motion.link == "tip":
        return work, shift, turn
    if motion.link == "tool":
        return tool, shift, turn
    if motion.link == "command":
        ways = commanded_directions(frames_of, run.n)
        return work, np.einsum("nij,nj->ni", ways, shift), np.zeros_like(turn)
    axis, pose = axes[motion.link], frames[motion.link]
    if motion.place == "travel":
        # the travel q e turns to q (e + w x e); nothing else changes
        return (
            pose.before,
            run.q(motion.link)[:, None] * np.cross(turn, unit_vector(motion.link)),
            np.zeros_like(turn),
        )
    frame, pivot = _frame_and_pivot(axis, pose, motion.place)
    if turn.any():
        shift = shift + np.cross(turn, frame.undo(tip) - pivot)
    return frame, shift, turn


def sensitivity(
    frames_of: LinkFrames, axes: Mapping[str, Axis], run: Run, link: tuple[str, str], direction: Array
) -> Array:
    """Return how far the tip moves along `direction` (n, 3; workpiece axes) per unit of the six numbers of a link: (n, 6).

    The transpose of `tip_motion`: n . (t + r x d) = n . t + r . (d x n), with d from the pivot to the tip.
    frames_of: `link_frames` of the run, made once for all links. link: its letter or word, and the place of the motion.
    """
    (name, place), (frames, tool, work) = link, frames_of
    out = np.zeros((run.n, 6))
    if name == "tip":
        out[:, :3] = direction
    elif name == "tool":
        out[:, :3] = tool.turn_back(work.turn(direction))
    elif name == "command":
        out[:, :3] = np.einsum("nij,ni->nj", commanded_directions(frames_of, run.n), direction)
    elif place == "travel":
        local = frames[name].before.turn_back(work.turn(direction))
        out[:, 3:] = run.q(name)[:, None] * np.cross(unit_vector(name), local)
    else:
        frame, pivot = _frame_and_pivot(axes[name], frames[name], place)
        out[:, :3] = local = frame.turn_back(work.turn(direction))
        out[:, 3:] = np.cross(frame.undo(tool.apply(run.offset)) - pivot, local)
    return out


def turn_sensitivity(
    frames_of: LinkFrames, axes: Mapping[str, Axis], run: Run, link: tuple[str, str], direction: Array
) -> Array:
    """Return how far the tip turns about `direction` (n, 3; workpiece axes) per unit of the six numbers of a link: (n, 6).

    Arguments as in `sensitivity`. A direction of travel that turns, and a moved command, do not turn the tip.
    """
    (name, place), (frames, tool, work) = link, frames_of
    out = np.zeros((run.n, 6))
    if name == "tip":
        out[:, 3:] = direction
    elif name == "tool":
        out[:, 3:] = tool.turn_back(work.turn(direction))
    elif name != "command" and place != "travel":
        frame, _ = _frame_and_pivot(axes[name], frames[name], place)
        out[:, 3:] = frame.turn_back(work.turn(direction))
    return out


def _frame_and_pivot(axis: Axis, pose: Pose6, place: str) -> tuple[Frame, Array]:
    """Return the frame in which a motion of an axis is expressed, and the point (3,) about which it turns."""
    if place == "location":
        return pose.before, np.array(axis.centre)
    return (pose.before if axis.error_frame == "fixed" else pose.after), axis.own_pivot


def exact_tip_error(chain: Chain, axes: Mapping[str, Axis], run: Run, motions: Sequence[Motion]) -> Array:
    """Return the tip error (n, 3) mm by multiplying the transforms; motions of one link and place are added first."""
    return exact_tip(chain, axes, run, motions) - nominal_tip(chain, axes, run)


def exact_tip(chain: Chain, axes: Mapping[str, Axis], run: Run, motions: Sequence[Motion]) -> Array:
    """Return the tip (n, 3) mm, workpiece axes: position and offset of the run and the motions, transforms multiplied."""
    summed = _by_link(motions, run.n)
    tool, work = _actual_ends(chain, axes, run, summed)
    at_tip, at_tool = summed.get(("tip", "motion")), summed.get(("tool", "motion"))
    command = summed.get(("command", "motion"))
    offset = run.offset if at_tool is None else run.offset + at_tool[:, :3]
    actual = work.undo(tool.apply(offset))
    if at_tip is not None:
        actual = actual + at_tip[:, :3]
    if command is not None:
        ways = commanded_directions(link_frames(chain, axes, run), run.n)
        actual = actual + np.einsum("nij,nj->ni", ways, command[:, :3])
    return np.asarray(actual)


def exact_tip_motion(chain: Chain, axes: Mapping[str, Axis], run: Run, motions: Sequence[Motion]) -> Array:
    """Return the motion of the tip (n, 6), actual - nominal, workpiece axes, mm and rad, by multiplying the transforms.

    Columns 3 to 5 are the rotation vector of R_actual R_nominal^T, R the orientation of the tool seen from the workpiece.
    """
    from scipy.spatial.transform import Rotation

    summed = _by_link(motions, run.n)
    actual = _orientation(*_actual_ends(chain, axes, run, summed), run.n)
    for link, order in (("tool", 1), ("tip", -1)):
        six = summed.get((link, "motion"))
        if six is not None:
            turn = rotation_from_vector(six[:, 3:])
            actual = actual @ turn if order > 0 else turn @ actual
    _, tool, work = link_frames(chain, axes, run)
    nominal = _orientation(tool, work, run.n)
    turned = Rotation.from_matrix(actual @ nominal.transpose(0, 2, 1)).as_rotvec()
    return np.concatenate([exact_tip_error(chain, axes, run, motions), turned], axis=1)


def _orientation(tool: Frame, work: Frame, n: int) -> Array:
    """Return the orientation of the tool seen from the workpiece (n, 3, 3)."""
    upright = np.broadcast_to(np.eye(3), (n, 3, 3))
    orientation = upright if work.rotation is None else work.rotation.transpose(0, 2, 1)
    return orientation if tool.rotation is None else orientation @ tool.rotation


def _actual_ends(chain: Chain, axes: Mapping[str, Axis], run: Run, summed: LinkSums) -> tuple[Frame, Frame]:
    """Return the tool side and the workpiece side: products of their axes from the bed outwards, errors included."""
    ends = []
    for side, carries_work in ((chain.tool, False), (chain.work, True)):
        here = Frame(None, np.zeros((run.n, 3)))
        for letter in side:
            turn = _frame_of_direction(axes[letter], run.n)
            moved = _actual_motion(axes[letter], run.q(letter), carries_work, summed)
            here = here.then(moved if turn is None else turn.then(moved).then(turn.inverse()))
        ends.append(here)
    return ends[0], ends[1]


def _by_link(motions: Sequence[Motion], n: int) -> LinkSums:
    summed: LinkSums = {}
    for motion in motions:
        key = (motion.link, motion.place)
        summed[key] = summed[key] + motion.six if key in summed else motion.six
    return summed


def _actual_motion(axis: Axis, q: Array, carries_work: bool, summed: LinkSums) -> Frame:
    """Return L · T_nominal · E of one axis (or L · E · T_nominal), errors included."""
    sign = -1.0 if carries_work else 1.0  # motions are in tip sense; the table's own motion is opposite
    nominal = nominal_motion(axis, q, carries_work)
    travel = summed.get((axis.letter, "travel"))
    if travel is not None:
        travelled = rotation_from_vector(travel[:, 3:]) @ unit_vector(axis.letter)
        nominal = Frame(None, (sign * q)[:, None] * travelled)
    motion = summed.get((axis.letter, "motion"))
    if motion is not None:
        error = _small(sign * motion, axis.own_pivot)
        nominal = error.then(nominal) if axis.error_frame == "fixed" else nominal.then(error)
    location = summed.get((axis.letter, "location"))
    return nominal if location is None else _small(sign * location, np.array(axis.centre)).then(nominal)


def _small(six: Array, pivot: Array) -> Frame:
    """Return the small transform p -> pivot + exp([r]x)(p - pivot) + t."""
    if not six[:, 3:].any():
        return Frame(None, six[:, :3])
    rotation = rotation_from_vector(six[:, 3:])
    return Frame(rotation, pivot - rotation @ pivot + six[:, :3])
