"""A machine file whose errors go with temperatures, and a set-up that states none: 20 degC, and it is said."""

from vcmm.compensation.loading import with_temperatures
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.face.cli import run
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.program.setup import Setup

MACHINE = """vcmm = "machine/1"
name = "mill"
kind = "machine-tool"
structure = "w b X Y Z t"
axes.X = { travel = ["-500 mm", "500 mm"] }
axes.Y = { travel = ["-500 mm", "500 mm"] }
axes.Z = { travel = ["-500 mm", "500 mm"] }
repeatability = { law = "normal", u = "1 um" }
[[effects]]
effect = "scale_expansion"
axis = "X"
alpha = "10 um/(m K)"
"""
PROGRAM = "G21 G17 G90 G94 G54\nT1 M6\nG43 H1 Z10. \nG0 X0 Y0\nG1 Z-1. F500.\nG1 X200.\nG0 Z10.\nM30\n"
SETUP = 'vcmm = "setup/1"\nmachine = "machine.toml"\ndialect = "fanuc"\n[offsets]\nG54 = ["0 mm", "0 mm", "0 mm"]\n[tools.1]\nlength = "50 mm"\ndiameter = "10 mm"\n[control]\ncompensation = []\n'


def test_what_is_stated_is_not_assumed():
    axes = {a: Axis(a, (0.0, 500.0)) for a in "XYZ"}
    effects = (ScaleExpansion("X", 1e-5), ScaleExpansion("Y", 1e-5))
    machine = Machine("m", "machine-tool", parse_structure("w b X Y Z t"), axes, effects)
    assumed, (said,) = with_temperatures(machine, Setup(), {"temp_scale_x_C": 22.0})
    assert assumed == {"temp_scale_x_C": 22.0, "temp_scale_y_C": 20.0}
    assert "scale_expansion[Y]" in said
    assert "scale_expansion[X]" not in said
    both = {"temp_scale_x_C": 22.0, "temp_scale_y_C": 21.0}
    assert with_temperatures(machine, Setup(), both) == (both, ())


def test_a_program_is_corrected_at_twenty_degrees_with_a_note(tmp_path, capsys):
    """At 20 degC nothing is left to correct; at 22 degC the scale of X makes 200 mm too long by 10e-6 x 2 x 200 = 4 um: X199.996."""
    for name, text in (("machine.toml", MACHINE), ("part.nc", PROGRAM), ("setup.toml", SETUP)):
        (tmp_path / name).write_text(text)
    words = ["compensate", str(tmp_path / "part.nc"), "--setup", str(tmp_path / "setup.toml"), "--out"]
    assert run([*words, str(tmp_path / "cold.nc")]) == 0
    said = capsys.readouterr().err
    assert "scale_expansion[X] of the machine file go with the temperature of scale_x" in said
    assert '[temperature] scale_x = "22 degC"' in said
    assert "X200." in (tmp_path / "cold.nc").read_text()
    (tmp_path / "setup.toml").write_text(SETUP + '[temperature]\nscale_x = "22 degC"\n')
    assert run([*words, str(tmp_path / "warm.nc")]) == 0
    assert "taken as 20 degC" not in capsys.readouterr().err
    assert "X199.996" in (tmp_path / "warm.nc").read_text()
