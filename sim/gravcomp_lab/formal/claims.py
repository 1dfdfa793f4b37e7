"""What is proven about the hardware, by which checker of tb/formal, for which generics."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gravcomp.core.compensation import no_compensation
from gravcomp.core.compensator_tables import (
    FRICTION_BITS,
    PHASE_STEP_BITS,
    quantise_compensation,
)
from gravcomp.core.cost import CoreCost
from gravcomp.core.formats import COUNT_BITS, OPERAND_BITS, FixedNetwork, quantise
from gravcomp.core.image import Record, image_records, record_words
from gravcomp.core.quantised import quantised
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.facts import DRIVE_CLOCKS, IMAGE_SECTIONS, IMAGE_WORD_BITS
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import PAPER, SERIAL
from gravcomp.twin.safety import Cause, State
from gravcomp_lab.formal.model_check import Verdict, induct, model_check, refute, shortest_run
from gravcomp_lab.formal.sums import hidden_sums, output_sums
from gravcomp_lab.forms import form_copy
from gravcomp_lab.shipped import SPHEIRO, shipped_machine
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog

HIDDEN = 20
LANES = (1, 2, 4, 5, 10, 20)
# Parameters of checkers.
STATES = {state.name: int(state) for state in State}
CAUSES = {name: int(Cause[name]) for name in ("SPEED", "COMMAND", "HOLD", "BRAKE", "UPSET")}
# Numbers small enough for a search, which finds the run that breaks a claim; its own are proven by induction.
SMALL = {"reversal_clocks_g": 6, "suspect_edges_g": 4, "dither_clocks_g": 8, "dither_edges_g": 4}
BISS = {"position_bits_g": 2, "half_clocks_g": 2, "start_periods_g": 2, "rest_clocks_g": 3}
ADC = {"channels_g": 2, "code_bits_g": 8, "id_bits_g": 1, "frame_bits_g": 9, "command_g": 0, "channel_shift_g": 0,
       "half_clocks_g": 3, "gap_clocks_g": 2}  # fmt: skip


@dataclass(frozen=True)
class Claim:
    """Assertions of one checker about one entity: entity with its generics, checker with its parameters.

    clocks_behind_core: what the entity's latency is longer than that of gc_core with the same generics; the checker
    then gets the sum as LATENCY. free_clocks, cuts: as of model_check. induction: clocks of induct, in place of
    model_check. axis: that of the claim, the checker's parameter AXIS. form: of the ROM, if another than the paper's.
    rewrite: as of model_check.
    """

    checker: str
    entity: str
    generics: Mapping[str, int | str] = field(default_factory=dict)
    parameters: Mapping[str, int] = field(default_factory=dict)
    clocks_behind_core: int | None = None
    free_clocks: bool = False
    cuts: tuple[str, ...] = ()
    induction: int = 0
    axis: int | None = None
    form: str = PAPER
    rewrite: bool = False

    @property
    def name(self) -> str:
        settings = {**self.generics, **({} if self.axis is None else {"axis": self.axis})}
        return "-".join([self.checker, *(f"{name}{value}" for name, value in settings.items())])


CLAIMS = (
    *(Claim("glitch_filter", "gc_glitch_filter", {"samples_g": n}, {"SAMPLES": n}) for n in (1, 2, 4, 5)),
    *(Claim("glitch_sample", "gc_glitch_filter", {"samples_g": n}, {"SAMPLES": n}) for n in (0, 4)),
    Claim("synchronizer", "gc_synchronizer", {"width_g": 3, "stages_g": 3}, {"WIDTH": 3, "STAGES": 3}),
    Claim("quad_decoder", "gc_quad_decoder", {"filter_samples_g": 0, "speed_timeout_g": 20}, {"SAMPLES": 0}),
    Claim("quad_decoder", "gc_quad_decoder", {"filter_samples_g": 4}, {"SAMPLES": 4}),
    Claim("edge_watch", "gc_edge_watch", SMALL, {name.removesuffix("_g").upper(): n for name, n in SMALL.items()}),
    Claim("edge_watch", "gc_edge_watch", induction=2),
    # A planted fault is found within few clocks: there the mark is a short one.
    *(Claim("index_check", "gc_index_check", {"mark_clocks_g": n}, {"MARK_CLOCKS": n}, induction=1) for n in (4, 20)),
    *(Claim("valid_pipeline", "gc_core", {"lanes_g": n}, {"INTERVAL": HIDDEN // n}, 0) for n in LANES),
    # One lane holds all neurons; the hidden sums are the same with more.
    Claim("hidden_sums", "gc_hidden_lane", {"lanes_g": 1}),
    *(Claim("output_sums", "gc_output_layer", {"lanes_g": n}) for n in LANES),
    Claim("input_clamp", "gc_input_scaler", {"serial_g": "false"}, {"LATENCY": 3, "PRODUCT_CLOCKS": 1}),
    Claim("input_clamp", "gc_input_scaler", {"serial_g": "true"}, {"LATENCY": 6, "PRODUCT_CLOCKS": 0}),
    Claim("phase", "gc_phase"),
    Claim("sin_cos", "gc_sin_cos"),
    Claim("hidden_saturation", "gc_hidden_lane"),
    Claim("serial_core", "gc_core_serial", form=SERIAL),
    Claim("output_saturation", "gc_output_scaler"),
    Claim("force_saturation", "gc_compensator", parameters={"TOTAL_BITS": FRICTION_BITS + 1}),
    Claim("safety", "gc_safety", {"two_paths_g": "true"}, STATES | CAUSES),
    Claim("safety_told", "gc_safety", {"brake_feedback_g": "true"}),
    Claim("parity_guard", "gc_parity_guard", {"width_g": 5}, {"BITS": 5}),
    Claim("timeout", "gc_timeout", {"bits_g": 4, "guard_g": "true"}, {"BITS": 4}),
    Claim("fault_latch", "gc_fault_latch", {"guard_g": "true"}, {"CAUSES": len(Cause), "POSITION": 3 * COUNT_BITS}),
    Claim("brake_sequencer", "gc_brake_sequencer", {"guard_g": "true"}, STATES),
    Claim("brake_permit", "gc_brake_permit"),
    Claim("brake_permit_guard", "gc_brake_permit", {"guard_g": "true"}),
    Claim("brake_test", "gc_brake_test", {"guard_g": "true"}),
    Claim("brake_feedback", "gc_brake_feedback", {"guard_g": "true"}),
    Claim("brakes", "gc_brakes", dict.fromkeys(("two_paths_g", "feedback_g", "test_g", "guard_g"), "true"), STATES),
    *(Claim("drive", "gc_drive", axis=axis, induction=1) for axis in range(3)),
    Claim("tick", "gc_tick"),
    Claim("setpoint", "gc_setpoint", {"axes_g": 1}),
    Claim("servo", "gc_servo", {"axes_g": 1}, induction=1),
    Claim("recorder", "gc_recorder", {"axes_g": 1, "address_bits_g": 4}),
    Claim("recorder_trigger", "gc_recorder", {"axes_g": 1, "address_bits_g": 4}),
    *(
        Claim("pwm", "gc_pwm", {"clocks_g": 6, "dead_g": 2, "two_pins_g": two}, {"DEAD": 2, "TWO": int(two == "true")})
        for two in ("false", "true")
    ),
    Claim("speed_meter", "gc_speed_meter", {"timeout_g": 5}, {"TIMEOUT": 5, "BITS": 5}),
    *(Claim("crossing_pulse", "gc_crossing_pulse", {"stages_g": n}, {"STAGES": n}, free_clocks=True) for n in (2, 3)),
    *(Claim("crossing_bus", "gc_crossing_bus", {"stages_g": n}, {"STAGES": n}, free_clocks=True) for n in (2, 3)),
    Claim("clock_monitor", "gc_clock_monitor", {"bus_limit_g": 8, "core_limit_g": 8}, free_clocks=True),
    Claim("loader", "gc_loader", induction=1),
    Claim("bank_switch", "gc_bank_switch", induction=1),
    Claim("friction", "gc_friction", {"loadable_g": "true"}, cuts=("sliding_8", "g_load_mu_8"), induction=14),
    *(
        Claim(
            "uart",
            "gc_uart",
            {"clock_hz_g": 8, "baud_g": 1, "parity_g": parity},
            {"BITS": bits, "ODD": odd},
            induction=1,
        )
        for parity, bits, odd in ((0, 10, 0), (1, 11, 1), (2, 11, 0))
    ),
    Claim("uart_received", "gc_uart", {"clock_hz_g": 8, "baud_g": 1}),
    Claim("uart_receiving", "gc_uart", {"clock_hz_g": 8, "baud_g": 1}),
    Claim("biss", "gc_biss", BISS, dict(zip(("BITS", "HALF", "PERIODS", "REST"), BISS.values(), strict=True))),
    Claim("adc_spi", "gc_adc_spi", ADC, {"HALF": ADC["half_clocks_g"], "GAP": ADC["gap_clocks_g"]}),
    Claim("modbus", "gc_modbus", {"gap_clocks_g": 2, "bus_clocks_g": 3}, cuts=("fetched",), induction=1),
    Claim("lockstep", "gc_lockstep", {"bits_g": 4}, {"BITS": 4}),
    Claim("register_split", "gc_register_split", induction=1),
    # What a register holds matters to no access, but to one setting.
    Claim(
        "motion_bus_access", "gc_motion_bus", {"record_bits_g": 5}, {"ANSWER": 4}, cuts=("i_registers.cpuif_rd_data",)
    ),
    Claim("motion_bus", "gc_motion_bus", {"record_bits_g": 5}),
    Claim("motion_current", "gc_motion", {"record_bits_g": 5}, {"AXES": 3}, induction=1),
    Claim(
        "motion",
        "gc_motion",
        {"record_bits_g": 5},
        {"BEFORE": DRIVE_CLOCKS, "BUSY": DRIVE_CLOCKS + 21},
        cuts=("move_ready", "too_narrow", "records", "triggered", "read_word"),
    ),
    Claim("axi", "gc_bus_side", parameters={"ANSWER": 4}),
    # Of the loader nothing matters to an interrupt, and its key is 32 bits.
    Claim("interrupts", "gc_bus_side", cuts=("unlocked", "loads", "loads_waiting"), rewrite=True),
    Claim(
        "force_path",
        "gc_force_path",
        {"lanes_g": 4},
        clocks_behind_core=CoreCost(HIDDEN, inputs=3, axes=3, lanes=4).clocks_behind(),
    ),
)


# Checkers written from the weights, one or several per claim, and those with parameters of the network.
SUMS = {
    "hidden_sums": lambda fixed, lanes: [hidden_sums(fixed, lanes)],
    "output_sums": lambda fixed, lanes: [output_sums(fixed, lanes, k) for k in range(fixed.n_axes)],
}
OF_THE_NETWORK = {
    "input_clamp": lambda fixed: {
        "LOW": _packed(fixed.count_low, COUNT_BITS),
        "HIGH": _packed(fixed.count_high, COUNT_BITS),
        "SCALE": _packed(fixed.input_scale, OPERAND_BITS),
        "SHIFT": _packed(fixed.count_shift, 6),
        "FRACTION": _packed(fixed.input_scale_fraction, 6),
    },
    "hidden_saturation": lambda fixed: {"SUM_BITS": fixed.hidden_sum_bits, "DROP": fixed.preactivation_drop},
    "output_saturation": lambda fixed: {"SUM_BITS": fixed.output_sum_bits, "DROP": fixed.output_drop},
    "serial_core": lambda _: _of_the_serial_core(),
    "bank_switch": lambda fixed: {**_scalar_bits(fixed), "ROM": _rom_scalars(fixed)},
    "loader": lambda fixed: {**_sections(fixed), **_scalar_bits(fixed)},
}


def verify(claim: Claim, rtl: Path, checkers: Path, out: Path, broken: Collection[str] = ()) -> Verdict:
    """Prove or refute a claim about the VHDL of folder rtl; intermediate files go to a folder of its name in out.

    broken: assertions that are looked at alone, to be refuted, where the claim is not one of induction.
    """
    folder, parameters = out / claim.name, dict(claim.parameters)
    if claim.checker in SUMS:
        return _verify_sums(claim, _design(claim.entity, claim.generics, rtl, folder), _network(checkers))
    if claim.checker in OF_THE_NETWORK:
        parameters |= OF_THE_NETWORK[claim.checker](_network(checkers))
    if claim.axis is not None:
        parameters["AXIS"] = claim.axis
    if claim.clocks_behind_core is not None:
        core = _design("gc_core", claim.generics, rtl, folder / "core")
        # The shortest run to a result; that all others take as long is then proven.
        latency = shortest_run(core, checkers / "valid_pipeline.sv", folder / "core", {"LATENCY": 0}) - 1
        parameters["LATENCY"] = latency + claim.clocks_behind_core
    design = _design(claim.entity, claim.generics, rtl, folder, claim.form)
    checker, clocks = checkers / f"{claim.checker}.sv", parameters.get("INTERVAL", 1)
    if claim.induction:
        return induct(design, checker, folder, parameters, claim.induction, claim.cuts)
    if broken:
        return refute(design, checker, folder, parameters, broken, free_clocks=claim.free_clocks, cuts=claim.cuts)
    return model_check(
        design,
        checker,
        folder,
        parameters,
        clocks,
        free_clocks=claim.free_clocks,
        cuts=claim.cuts,
        rewrite=claim.rewrite,
    )


def _verify_sums(claim: Claim, design: Path, fixed: FixedNetwork) -> Verdict:
    """The verdict about the first of a claim's checkers that is not proven, or about the last."""
    for k, text in enumerate(SUMS[claim.checker](fixed, claim.generics["lanes_g"])):
        folder = design.parent / str(k)
        folder.mkdir(exist_ok=True)
        checker = folder / f"{claim.checker}.sv"
        checker.write_text(text)
        verdict = induct(design, checker, folder)
        if not verdict.holds:
            break
    return verdict


def _network(checkers: Path) -> FixedNetwork:
    """The network that is shipped: tb/formal stands beside its weights."""
    return quantise(load_network(SPHEIRO), shipped_machine().drive)


def _scalar_bits(fixed: FixedNetwork) -> dict[str, int]:
    """Widths of those scalars of an image that depend on the network."""
    return {"BIAS_BITS": fixed.output_sum_bits, "PHASE_BITS": PHASE_STEP_BITS}


def _records(fixed: FixedNetwork) -> dict[str, list[Record]]:
    """Records of an image of the network that is shipped, which comes without compensation."""
    return image_records(fixed, quantise_compensation(no_compensation(fixed.n_axes), shipped_machine().drive))


def _rom_scalars(fixed: FixedNetwork) -> str:
    """The last record of an image."""
    (scalars,) = _records(fixed)["scalar"]
    return _packed(record_words(scalars), IMAGE_WORD_BITS)


def _sections(fixed: FixedNetwork) -> dict[str, str]:
    """Records of each section of an image, and words of each of its records."""
    sections = [_records(fixed)[name] for name in IMAGE_SECTIONS]
    return {
        "RECORDS": _packed([len(records) for records in sections], 16),
        "WORDS": _packed([len(record_words(records[0])) for records in sections], 16),
    }


def _packed(values: Iterable[int], bits: int) -> str:
    """Signed values as a Verilog constant, the first one lowest."""
    values = [int(value) % 2**bits for value in values]
    return f"{bits * len(values)}'h{sum(value << bits * k for k, value in enumerate(values)):x}"


def _of_the_serial_core() -> dict[str, int]:
    """Latency and widths in the serial form of the network that is shipped."""
    fixed = quantised(shipped_machine().with_form(SERIAL), load_network(SPHEIRO))
    latency = CoreCost(fixed.n_hidden, fixed.n_inputs, fixed.n_axes, 1, True, True).latency
    return {"LATENCY": latency, "SUM_BITS": fixed.output_sum_bits, "DROP": fixed.output_drop}


def _design(entity: str, generics: Mapping[str, int | str], rtl: Path, folder: Path, form: str = PAPER) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    generated = None
    if form != PAPER:
        generated = folder / "generated"
        write_rom(form_copy(SPHEIRO, folder, form), generated)
    return to_verilog(rtl_sources(rtl, generated), entity, generics, folder / "design.v")
