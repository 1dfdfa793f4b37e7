"""Robot parameters from TOML: the nominal file, and an error for every way in which a file can be wrong."""

import numpy as np
import pytest

from gravcomp.errors import InputError
from gravcomp.robot.machine import read_machine
from gravcomp.robot.spheiro.parameters import parameters_from_table
from machines import MACHINE, P

NOMINAL = MACHINE.text


def test_nominal_file_holds_the_designs_values():
    p = P
    masses = (p.carriage_mass_kg, p.link1_mass_kg, p.link2_mass_kg, p.platform_mass_kg)
    assert (p.d_m, *masses) == (0.25, 4.5, 4.5, 3.5, 10.5)
    assert (p.link1_com_m, p.link2_com_m) == (0.10, 0.12)
    np.testing.assert_array_equal(MACHINE.drive.counts_per_unit, [1e6] * 3)
    np.testing.assert_array_equal(MACHINE.drive.effort_per_ampere, [45.0] * 3)
    assert MACHINE.clock_hz == 40e6
    np.testing.assert_allclose(p.platform_com_m, 0.06 / np.sqrt(3) * np.ones(3), rtol=1e-12)
    np.testing.assert_allclose(p.gravity_mps2, -9.81 / np.sqrt(3) * np.ones(3), rtol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("d_m = 0.25 ", "", "[model.geometry] d_m is missing"),
        ("[model.carriage]", "[model.carrige]", "[model.carriage] mass_kg is missing"),
        ("d_m = 0.25 ", 'd_m = "0.25" ', "[model.geometry] d_m = '0.25' is not a finite number"),
        ("d_m = 0.25 ", "d_m = nan ", "[model.geometry] d_m = nan is not a finite number"),
        ("d_m = 0.25 ", "d_m = true ", "[model.geometry] d_m = True is not a finite number"),
        ("d_m = 0.25 ", "d_m = 0.0 ", "[model.geometry] d_m = 0.0 is out of range"),
        ("com_m = 0.10", "com_m = -0.10", "[model.link1] com_m = -0.1 is out of range"),
        ("com_m = [0.03464101615137755, ", "com_m = [", "[model.platform] com_m = "),
        ("com_m = [0.03464101615137755", "com_m = [inf", "[model.platform] com_m = "),
        ("com_m = [0.03464101615137755", 'com_m = ["a"', "[model.platform] com_m = "),
        ("-0.5773502691896258", "0.0", "[model.gravity] direction has zero length"),
        ("-0.5773502691896258", f"1{'0' * 400}", "[model.gravity] direction = "),
        ("d_m = 0.25 ", f"d_m = 1{'0' * 400} ", "[model.geometry] d_m = 1000"),
        ("[model.geometry]", "[model.geometry", "not valid TOML"),
        ("[model.geometry]", "a = " + "[" * 5000, "not valid TOML"),
        ("clock_hz = 40e6", "clock_hz = 40.5", "clock_hz = 40.5 is not a whole number of Hz"),
        ("clock_hz = 40e6", "clock_hz = -1", "clock_hz = -1.0 is out of range"),
        ("clock_hz = 40e6", "", "clock_hz is missing"),
        ('activation = "gamma"', 'activation = "relu"', "[network] activation = 'relu'; give one of gamma, tanh"),
        ('kind = "spheiro"     ', 'kind = "ur5"', "kind = 'ur5' is not installed; give one of arm, mujoco, sph"),
        ('kind = "spheiro"\ntilt', 'kind = "box"\ntilt', "[workspace] kind = 'box'"),
        (
            "counts_per_m = 1000000  ",
            "counts_per_turn = 1000000",
            "axis 1: counts_per_m is missing; the axis moves in m",
        ),
        ("effort_per_ampere = 45.0  ", "effort_per_ampere = 0 ", "axis 1: effort_per_ampere = 0.0 is out of range"),
        ("index_period = 0  ", "index_period = -1 ", "axis 1: index_period = -1 is no multiple of 4 counts"),
        ("index_period = 0  ", "index_period = 402 ", "axis 1: index_period = 402 is no multiple of 4 counts"),
        ("index_period = 0  ", f"index_period = {2**32} ", "axis 1: index_period = 4294967296 is no multiple"),
        ("d_m = 0.25 ", f"d_m = 1{'0' * 5000} ", "not valid TOML (Exceeds the limit"),
        ("[workspace]", "[wings]\n[workspace]", "wings is not known; give axis, clock_hz, "),
        ('name = "spheiro"', "name = 3", "name = 3 is not a text"),
        (
            'activation = "gamma"',
            'activation = "gamma"\nfrom = "lean"',
            "[network]: from is not known; give act",
        ),
        ("index_period = 0  ", "index_periods = 0 ", "axis 1: index_periods is not known"),
        ("low = -0.161  ", "low = 0.161 ", "axis 1: low = 0.161 is not below high"),
        ("low = -0.161  ", 'input = "sin_cos" ', "axis 1: input = 'sin_cos'; this core takes positions alone"),
    ],
)
def test_wrong_file_is_refused_by_file_table_and_key(tmp_path, old, new, said):
    assert old in NOMINAL
    path = tmp_path / "robot.toml"
    path.write_text(NOMINAL.replace(old, new))
    with pytest.raises(InputError) as error:
        read_machine(path)
    message = str(error.value)
    assert message.startswith(str(path))
    assert said in message
    assert "\n" not in message


def test_value_where_a_table_belongs_is_refused():
    with pytest.raises(InputError, match=r"^here: \[model.geometry\] d_m is missing"):
        parameters_from_table({"model": {"geometry": 1}}, "here")


def test_unreadable_file_is_refused_by_name(tmp_path):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path in (tmp_path / "absent.toml", tmp_path, binary):
        with pytest.raises(InputError, match="cannot be read") as error:
            read_machine(path)
        assert str(path) in str(error.value)
