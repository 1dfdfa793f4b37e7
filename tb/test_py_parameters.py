"""Robot parameters from TOML: the nominal file, and an error for every way in which a file can be wrong."""

import numpy as np
import pytest

from gravcomp.errors import InputError
from gravcomp.robot.spheiro.parameters import NOMINAL_TOML, load_parameters, parameters_from_table

NOMINAL = NOMINAL_TOML.read_text()


def test_nominal_file_holds_the_designs_values():
    p = load_parameters()
    masses = (p.carriage_mass_kg, p.link1_mass_kg, p.link2_mass_kg, p.platform_mass_kg)
    assert (p.d_m, *masses) == (0.25, 4.5, 4.5, 3.5, 10.5)
    assert (p.link1_com_m, p.link2_com_m, p.encoder_m_per_count, p.thrust_constant_n_per_a) == (0.10, 0.12, 1e-6, 45.0)
    np.testing.assert_allclose(p.platform_com_m, 0.06 / np.sqrt(3) * np.ones(3), rtol=1e-12)
    np.testing.assert_allclose(p.gravity_mps2, -9.81 / np.sqrt(3) * np.ones(3), rtol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("d_m = 0.25 ", "", "[geometry] d_m is missing"),
        ("[carriage]", "[carrige]", "[carriage] mass_kg is missing"),
        ("d_m = 0.25 ", 'd_m = "0.25" ', "[geometry] d_m = '0.25' is not a finite number"),
        ("d_m = 0.25 ", "d_m = nan ", "[geometry] d_m = nan is not a finite number"),
        ("d_m = 0.25 ", "d_m = true ", "[geometry] d_m = True is not a finite number"),
        ("d_m = 0.25 ", "d_m = 0.0 ", "[geometry] d_m = 0.0 is out of range"),
        ("com_m = 0.10", "com_m = -0.10", "[link1] com_m = -0.1 is out of range"),
        ("com_m = [0.03464101615137755, ", "com_m = [", "[platform] com_m = "),
        ("com_m = [0.03464101615137755", "com_m = [inf", "[platform] com_m = "),
        ("com_m = [0.03464101615137755", 'com_m = ["a"', "[platform] com_m = "),
        ("-0.5773502691896258", "0.0", "[gravity] direction has zero length"),
        ("-0.5773502691896258", f"1{'0' * 400}", "[gravity] direction = "),
        ("d_m = 0.25 ", f"d_m = 1{'0' * 400} ", "[geometry] d_m = 1000"),
        ("[geometry]", "[geometry", "not valid TOML"),
        ("[geometry]", "a = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_wrong_file_is_refused_by_file_table_and_key(tmp_path, old, new, said):
    assert old in NOMINAL
    path = tmp_path / "robot.toml"
    path.write_text(NOMINAL.replace(old, new))
    with pytest.raises(InputError) as error:
        load_parameters(path)
    message = str(error.value)
    assert message.startswith(str(path))
    assert said in message
    assert "\n" not in message


def test_value_where_a_table_belongs_is_refused():
    with pytest.raises(InputError, match=r"^here: \[geometry\] d_m is missing"):
        parameters_from_table({"geometry": 1}, "here")


def test_unreadable_file_is_refused_by_name(tmp_path):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path in (tmp_path / "absent.toml", tmp_path, binary):
        with pytest.raises(InputError, match="cannot be read") as error:
            load_parameters(path)
        assert str(path) in str(error.value)
