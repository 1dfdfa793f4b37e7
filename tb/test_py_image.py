"""The image of loadable constants: what is packed comes back, in the core's formats; what does not fit is refused."""

import subprocess
import zlib
from dataclasses import replace

import numpy as np
import pytest

from codes import ROOT
from compensated import CSV
from gravcomp.core import formats as q
from gravcomp.core.compensator_tables import PHASE_STEP_BITS
from gravcomp.core.formats import quantise
from gravcomp.core.image import load_image
from gravcomp.errors import InputError
from gravcomp.network.weights import load_network
from gravcomp.twin.bounds import intervals
from loading import OTHER_CSV, SPHEIRO, image_of, other_weights
from machines import MACHINE, machine_folder


class Reader:
    """Takes the fields of an image apart again."""

    def __init__(self, words: np.ndarray):
        self.words = [int(word) for word in words]

    def record(self, *widths: int) -> list[int]:
        """The next record as signed fields of these widths; its upper bits must be zero."""
        n = -(-sum(widths) // 32)
        bits = sum(word << 32 * k for k, word in enumerate(self.words[:n]))
        self.words = self.words[n:]
        values = []
        for width in widths:
            values.append((bits & (1 << width) - 1 ^ 1 << width - 1) - (1 << width - 1))
            bits >>= width
        assert bits == 0
        return values


@pytest.mark.parametrize("seed", range(5))
def test_image_holds_the_constants_in_order(tmp_path, seed):
    image = image_of(other_weights(tmp_path, CSV, seed))
    reader, net, added, n = Reader(image.words), image.network, image.compensation, 3
    for weights, bias in zip(net.hidden_weights, net.hidden_bias, strict=True):
        assert reader.record(18, 18, 18, net.hidden_sum_bits) == [*weights, bias]
    for weights in net.output_weights.T:
        assert reader.record(18, 18, 18) == weights.tolist()
    for table in (added.friction, added.mu, added.position):
        for node in table.reshape(-1, 2):
            assert reader.record(18, 18) == node.tolist()
    widths = [32] * 2 * n + [18] * 3 * n + [net.output_sum_bits] * n + [18] * 2 * n + [PHASE_STEP_BITS] * n
    limits = [*net.count_low, *net.count_high, *net.input_scale, *net.x_low, *net.x_high]
    scales = [*net.output_bias, *net.output_scale, *net.current_scale, *added.phase_step]
    assert reader.record(*widths) == limits + scales
    assert reader.words == []


def test_crc_is_that_of_zlib_over_little_endian_bytes(tmp_path):
    image = image_of(other_weights(tmp_path))
    assert image.data == b"".join(int(word).to_bytes(4, "little") for word in image.words)
    assert image.crc32 == zlib.crc32(image.data)


def test_image_of_the_rom_has_the_constants_of_the_rom():
    image, fixed = image_of(SPHEIRO), quantise(load_network(SPHEIRO), MACHINE.drive)
    for name, value in vars(fixed).items():
        np.testing.assert_array_equal(getattr(image.network, name), value)


def test_whatever_is_accepted_keeps_the_formats_and_cannot_overflow(tmp_path):
    """Networks around the limits of the formats: refused, or within every bound of the core."""
    rng, network, rom = np.random.default_rng(63), load_network(SPHEIRO), quantise(load_network(SPHEIRO), MACHINE.drive)
    names = ("hidden_weights", "hidden_bias", "output_weights", "output_bias", "q_scale", "f_scale")
    formats = [name for name in vars(rom) if name.endswith(("_bits", "_fraction", "_shift"))]
    n_accepted, n = 0, 300
    for _ in range(n):
        changed = {name: getattr(network, name) * 2 ** rng.normal(0, 0.15) for name in names}
        try:
            fixed = quantise(replace(network, **changed), MACHINE.drive, tmp_path, rom)
        except InputError:
            continue
        n_accepted += 1
        for name in formats:
            np.testing.assert_array_equal(getattr(fixed, name), getattr(rom, name))
        for name, interval in intervals(fixed).items():
            assert interval.needed_bits <= interval.bits, name
        codes = (fixed.hidden_weights, fixed.output_weights, fixed.input_scale, fixed.output_scale)
        assert max(np.abs(values).max() for values in codes) < 2 ** (q.OPERAND_BITS - 1)
    assert 30 < n_accepted < n - 30, n_accepted


def changed(column: str, factor: float):
    return lambda network: replace(network, **{column: getattr(network, column) * factor})


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (changed("hidden_weights", 2), r"hidden.csv: row \d+, column w_q\d: .* does not fit 18 bits \(limit 3.99997\)"),
        (changed("output_weights", 2), r"output.csv: row \d, column v_\d+: .* does not fit"),
        (changed("hidden_bias", 6), "hidden.csv: its sums need"),
        (changed("output_bias", 90), "output.csv: its sums need"),
        (changed("q_scale", 0.4), "scaling.csv: row 1, column q_scale: the trained range is wider"),
        (changed("q_scale", 1.5), "scaling.csv: row 1, column q_scale is too large"),
        (changed("f_scale", 4), "output.csv: row 1, column v_"),
        (changed("f_offset", 9), "scaling.csv: row 1, column f_offset / f_scale"),
        (lambda n: replace(n, f_offset=0 * n.f_offset, f_scale=n.f_scale / 100), "too small for the format"),
        (lambda n: replace(n, q_offset=n.q_offset + 0.01), "scaling.csv: row 1, column q_offset"),
        (
            lambda n: replace(
                n,
                hidden_weights=n.hidden_weights[:7],
                hidden_bias=n.hidden_bias[:7],
                output_weights=n.output_weights[:, :7],
            ),
            "3 axes and 7 neurons, but the core has 3 and 20",
        ),
    ],
)
def test_what_the_core_cannot_hold_is_refused(tmp_path, change, complaint):
    machine_folder(tmp_path, change(load_network(SPHEIRO)))
    with pytest.raises(InputError, match=complaint):
        load_image(tmp_path, SPHEIRO)


@pytest.mark.parametrize("factor", [0.6, 1.0, 1.4])
def test_same_network_at_another_output_scale_is_the_same_forces(tmp_path, factor):
    """The weights and the offset of one, and the scale of the other, would not fit as they stand."""
    network = load_network(SPHEIRO)
    other = replace(
        network,
        output_weights=network.output_weights * factor,
        output_bias=network.output_bias * factor,
        f_scale=network.f_scale / factor,
    )
    machine_folder(tmp_path, other)
    image, plain = load_image(tmp_path, SPHEIRO), image_of(SPHEIRO)
    # Against the float network, which is the same. The shipped weights are rounded with care, these as they come.
    assert image.precision.largest_mn < plain.precision.limit_mn
    assert np.all(image.network.output_scale_fraction == plain.network.output_scale_fraction)


def test_command_writes_the_words_and_tells_their_crc(tmp_path):
    folder, out = other_weights(tmp_path / "other", OTHER_CSV), tmp_path / "other.bin"
    command = [
        str(ROOT / ".venv/bin/gravcomp"),
        "image",
        "--weights",
        str(folder),
        "--rom",
        str(SPHEIRO),
        "--out",
        str(out),
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    image = image_of(folder)
    assert out.read_bytes() == image.data
    assert f"{len(image.words)} words, CRC-32 0x{image.crc32:08X}" in done.stdout
    (folder / "compensation.csv").write_text("axis,name,value\n1,mu,2\n")
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 2
    assert "compensation.csv" in done.stderr
    assert out.read_bytes() == image.data
