"""What the tool does to the part while it works: bending by the stick-out, wear and warmth along a batch."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import UsageError
from vcmm.face.cli import run as command
from vcmm.shop.machining.job import cut, finished_part
from vcmm.shop.machining.preparation import remarks, set_up
from vcmm.shop.machining.states import later_in_batch

STOCK = '[stock]\nbox = ["104 mm", "104 mm", "20 mm"]\nmaterial = "Al7075"\n'  # a side of 2 mm is left for the finishing pass
RIGID = shop.SETUP + "teeth = 3\n"
SLENDER = RIGID + 'stick_out = "60 mm"\n'
WEAR = '[[effects]]\neffect = "tool_wear"\nrate = "5 um/m"\n'
GROWTH = '[[effects]]\neffect = "spindle_growth"\naxis = "Z"\namplitude = "30 um"\ntau = "600 s"\n'


def bent(path):
    """Force across the tool (rows, 2) N at the contacts, and by how much the tool is moved there (rows, 2), mm."""
    _, world, _ = finished_part(set_up(vcmm.load_cut(path)))
    run = world.tool.run
    cut_rows = run.columns["setting"] == 0
    force = np.column_stack([run.column(f"force_{c}_N") for c in "xyz"])
    return force[cut_rows], world.tool_errors[cut_rows] - world.tool.known_error[cut_rows]


def test_a_tool_that_sticks_out_bends_by_its_forces(tmp_path):
    force, moved = bent(shop.write(tmp_path, setup=SLENDER + STOCK))
    assert np.abs(force[:, :2]).max() > 1.0
    # L^3 / 3 E I, L = 60 mm, d = 0.8 x 20 mm, I = pi 16^4 / 64 = 3216.99 mm^4, E = 580 000 N/mm^2:
    # 216 000 / (3 x 580 000 x 3216.99) = 3.8588e-5 mm/N across, nothing along the tool
    assert moved[:, :2] == pytest.approx(3.8588e-5 * force[:, :2], rel=1e-4)
    assert np.abs(moved[:, 2]).max() == 0.0


def test_round_a_circle_the_force_turns_with_the_feed(tmp_path):
    # the boss is cut by one full circle out of a square block: the force turns with the feed and grows towards the corners
    force, _ = bent(shop.write(tmp_path, setup=SLENDER + STOCK))
    _, world, _ = finished_part(set_up(vcmm.load_cut(tmp_path / "boss.toml")))
    rows = world.contacts.row[:, 0]
    normal = world.measuring.task.touches.run.normal
    out = np.einsum("pi,pi->p", force[rows], normal)
    assert out.min() >= 0.0 or out.max() <= 0.0  # pushed away from the boss or pulled to it, but not both
    beside = np.abs(normal[:, 0] * normal[:, 1])  # 0 where a side of the block is near, 1/2 at its corners
    assert np.abs(out)[beside > 0.4].mean() > 2.0 * np.abs(out)[beside < 0.2].mean()


def test_without_a_stick_out_nothing_bends(tmp_path):
    _, moved = bent(shop.write(tmp_path, setup=RIGID + STOCK))
    assert np.abs(moved).max() == 0.0


def test_a_stated_compliance_takes_the_place_of_the_rod_and_has_its_uncertainty(tmp_path):
    said = '[cut.tools.1]\ncompliance = "0.1 um/N"\nu_compliance = "0.02 um/N"\n[part.features]'
    scenario = shop.SCENARIO.replace("[part.features]", said)
    path = shop.write(tmp_path, setup=SLENDER + STOCK, scenario=scenario)
    force, moved = bent(path)
    assert moved[:, 0] == pytest.approx(1e-4 * force[:, 0], abs=1e-12)
    found = cut(vcmm.load_cut(path))
    assert "tool_deflection[1].compliance" in [line.input for line in found.characteristics[0].budget]
    assert found.shares["diameter"]["tool"] > 0.9
    assert found.recut is not None  # forces jump from move to move; the rest is cut again all the same


def test_an_effect_of_the_machine_file_is_not_doubled(tmp_path):
    plain = '[[effects]]\neffect = "tool_deflection"\ncompliance = "0.1 um/N"\n'
    force, moved = bent(shop.write(tmp_path, plain, setup=SLENDER + STOCK))
    assert moved[:, 0] == pytest.approx(1e-4 * force[:, 0], abs=1e-12)


def test_the_twentieth_part_is_cut_with_a_worn_tool(tmp_path):
    first, later = (
        cut(
            vcmm.load_cut(
                shop.write(tmp_path, WEAR, shop.SCENARIO.replace("[cut]", f"[cut]\nbatch_part = {n}"))
            )
        )
        for n in (1, 20)
    )
    # a part is 30 + 20 mm, a circle of 2 pi 60 mm, 20 + 30 mm: 476.991 mm of feed; 19 of them wear the radius by
    # 19 x 0.476991 m x 5 um/m = 45.314 um, the boss grows by twice that
    grown = later.characteristics[0].value - first.characteristics[0].value
    assert grown == pytest.approx(2 * 45.314e-3, rel=1e-3)


def test_a_batch_goes_on_in_time_and_travel_and_warms_the_spindle(tmp_path):
    ready = set_up(vcmm.load_cut(shop.write(tmp_path, GROWTH)))
    run = ready.path.run()
    run = run.with_columns({"nx": np.ones(run.n), "ny": np.zeros(run.n), "nz": np.zeros(run.n)})
    later = later_in_batch(run, ready.path, 3)
    assert later.column("time_s") - run.column("time_s") == pytest.approx(np.full(run.n, 2 * ready.seconds))
    moved = later.column("travel_X_mm") - run.column("travel_X_mm")
    assert moved == pytest.approx(np.full(run.n, 2 * run.column("travel_X_mm")[-1]))
    cold = -ready.machine.indication_error(run)[-1, 2]
    warm = -ready.machine.indication_error(later)[-1, 2]
    on = run.column("spindle_on_s")[-1]
    # the spindle pushes the tip down by 30 um (1 - exp(-t / 600 s))
    assert cold == pytest.approx(-0.03 * (1 - np.exp(-on / 600)), rel=1e-6)
    assert warm == pytest.approx(-0.03 * (1 - np.exp(-(on + 2 * ready.seconds) / 600)), rel=1e-6)
    assert later_in_batch(run, ready.path, 1) is run


RUNOUT = '[[effects]]\neffect = "tool_runout"\namplitude = "3 um"\n'


def test_a_gain_of_radius_takes_from_walls_and_leaves_floors(tmp_path):
    """An edge that runs 3 um further out: the boss loses 6 um of diameter, the floor beside it nothing."""
    floor = 'floor = { type = "plane", point = "60 0 -10 mm", normal = [0, 0, 1], size = "10 10 mm" }\n[[part.characteristics]]\nname = "floor"\ntype = "flatness"\nof = "floor"\nzone = "0.02 mm"\n'
    scenario = shop.SCENARIO.replace('length = "6 mm" }\n', f'length = "6 mm" }}\n{floor}', 1)
    _, world, _ = finished_part(set_up(vcmm.load_cut(shop.write(tmp_path, RUNOUT, scenario))))
    height = world.contacts.surface(world.tool.errors())
    wall = np.abs(world.measuring.task.touches.run.column("nz")) < 0.5
    assert 0 < wall.sum() < len(wall)
    assert height[wall] == pytest.approx(np.full(wall.sum(), -3e-3), abs=1e-7)
    assert height[~wall] == pytest.approx(np.zeros((~wall).sum()), abs=1e-9)


def test_steel_bends_the_tool_more_than_aluminium(tmp_path):
    """At 10 to 60 um per tooth 42CrMo4 needs 5 to 6 times the force of Al7075 (see the coefficients)."""
    soft = bent(shop.write(tmp_path, setup=SLENDER + STOCK))[0]
    hard = bent(shop.write(tmp_path, setup=SLENDER + STOCK.replace("Al7075", "42CrMo4")))[0]
    ratio = np.linalg.norm(hard, axis=1).max() / np.linalg.norm(soft, axis=1).max()
    assert 3.0 < ratio < 8.0


def test_a_wave_of_runout_is_refused_while_milling(tmp_path):
    """The tooth that stands out most passes once per turn: 0.2 % more speed must not change the part."""
    wave = RUNOUT + "harmonic = 1\n"
    with pytest.raises(UsageError, match="write harmonic = 0"):
        set_up(vcmm.load_cut(shop.write(tmp_path, wave)))


def test_check_says_when_the_program_spoils_the_part(tmp_path, capsys):
    path = shop.write(tmp_path, program=shop.PROGRAM.replace("X20. Y60.", "X20. Y50."))
    assert command(["check", str(path)]) == 1
    out = capsys.readouterr().out
    assert "the file is right, the program is not: 1 remark" in out
    assert command(["check", str(shop.write(tmp_path))]) == 0
    assert "no problems found" in capsys.readouterr().out


WALL = "%\nO2\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nG54 S3000 M3\nG43 H1 G0 X75. Y-60. Z20.\nG1 Z-10. F900.\nX-75.\nG0 Z20.\nM30\n%\n"
FRONT = shop.SCENARIO[: shop.SCENARIO.index("[part.features]")] + (
    '[part.features]\nfront = { type = "plane", point = "0 -50 -5 mm", normal = [0, -1, 0], size = "80 8 mm" }\n'
    '[[part.characteristics]]\nname = "flatness"\ntype = "flatness"\nof = "front"\nzone = "0.1 mm"\n[job]\ntrials = 2000\n'
)
BLOCK = '[stock]\nbox = ["120 mm", "104 mm", "20 mm"]\nmaterial = "Al7075"\n'


@pytest.mark.parametrize(("helix", "said"), [('helix = "0 deg"\n', True), ("", False)])
def test_a_wall_is_made_at_the_moment_at_which_an_edge_touches_it(tmp_path, helix, said):
    """Climb milling along -X with straight edges: 2 mm off a wall, 10 mm deep. The chip is nothing at the wall, so that 30.8 N/mm x 10 mm = 308 N push
    the tool away from it (-Y) and 27.7 x 10 = 277 N along the feed (-X). Where no helix is stated the mean of a turn is taken as before."""
    path = shop.write(tmp_path, scenario=FRONT, program=WALL, setup=SLENDER + helix + BLOCK)
    force, moved = bent(path)
    if said:
        assert force[:, 0] == pytest.approx(-277.0, abs=1e-6)
        assert force[:, 1] == pytest.approx(-308.0, abs=1e-6)
        assert moved[:, 1] == pytest.approx(-308.0 * 3.8588e-5, rel=1e-4)  # 11.9 um of material left
    else:
        assert np.abs(force[:, 1] + 308.0).min() > 50.0


def test_a_helix_gives_the_wall_a_shape(tmp_path):
    """30 deg on 20 mm: over 10 mm the edge lags by 10 tan 30 / 10 = 0.577 rad, less than the 0.6435 rad of the cut, so that while the foot of the wall is
    made the whole edge above it is in the cut, and while its top is made none is."""
    path = shop.write(tmp_path, scenario=FRONT, program=WALL, setup=SLENDER + 'helix = "30 deg"\n' + BLOCK)
    _, world, _ = finished_part(set_up(vcmm.load_cut(path)))
    run = world.tool.run
    cut_rows = run.columns["setting"] == 0
    z, across = run.column("part_z_mm")[cut_rows], -run.column("force_y_N")[cut_rows]
    assert across.max() > 2.0 * across.min() >= 0.0
    assert np.corrcoef(z, across)[0, 1] < -0.9


def test_a_mill_that_runs_out_bends_by_what_its_teeth_then_cut(tmp_path):
    """A helix of 30 deg in climb milling: the tooth that stands out makes the wall, and above its foot cuts thicker chips than the others, so that it is pushed
    harder; run out of it the numbers of the force are those of `vcmm.shop.cutting.tooth_force`, whose slices are added up in tests/shop/cutting."""
    pushed = []
    for number, amplitude in enumerate(("0 um", "10 um")):
        (tmp_path / str(number)).mkdir()
        runs_out = f'[[effects]]\neffect = "tool_runout"\ntool = "1"\namplitude = "{amplitude}"\n'
        path = shop.write(
            tmp_path / str(number),
            machine=runs_out,
            scenario=FRONT,
            program=WALL,
            setup=SLENDER + 'helix = "30 deg"\n' + BLOCK,
        )
        job = set_up(vcmm.load_cut(path))
        assert not [text for text in remarks(job) if "runs true" in text]
        _, world, _ = finished_part(job)
        run = world.tool.run
        pushed.append(-run.column("force_y_N")[run.columns["setting"] == 0])
    assert pushed[1].max() > 1.02 * pushed[0].max()
