"""What is proven about the hardware, by which checker of tb/formal, for which generics."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gravcomp.formal.model_check import Verdict, induct, model_check, shortest_run
from gravcomp.formal.sums import hidden_sums, output_sums
from gravcomp.network.quantise import quantise
from gravcomp.network.weights import load_network
from gravcomp.robot.parameters import load_parameters
from gravcomp.synthesis.verilog import rtl_sources, to_verilog

HIDDEN = 20
LANES = (1, 2, 4, 5, 10, 20)


@dataclass(frozen=True)
class Claim:
    """Assertions of one checker about one entity: entity with its generics, checker with its parameters.

    clocks_behind_core: what the entity's latency is longer than that of gc_core with the same generics; the checker
    then gets the sum as LATENCY.
    """

    checker: str
    entity: str
    generics: Mapping[str, int] = field(default_factory=dict)
    parameters: Mapping[str, int] = field(default_factory=dict)
    clocks_behind_core: int | None = None

    @property
    def name(self) -> str:
        return "-".join([self.checker, *(f"{name}{value}" for name, value in self.generics.items())])


CLAIMS = (
    *(Claim("glitch_filter", "gc_glitch_filter", {"samples_g": n}, {"SAMPLES": n}) for n in (1, 2, 4, 5)),
    Claim("quad_decoder", "gc_quad_decoder", {"filter_samples_g": 0, "speed_timeout_g": 20}),
    Claim("quad_decoder", "gc_quad_decoder", {"filter_samples_g": 4}),
    *(Claim("valid_pipeline", "gc_core", {"lanes_g": n}, {"INTERVAL": HIDDEN // n}, 0) for n in LANES),
    # One lane holds all neurons; the hidden sums are the same with more.
    Claim("hidden_sums", "gc_hidden_lane", {"lanes_g": 1}),
    *(Claim("output_sums", "gc_output_layer", {"lanes_g": n}) for n in (1, 4)),
    Claim("safety", "gc_safety"),
    Claim("axi", "gc_host", parameters={"ANSWER": 3}),
    Claim("top", "gc_top", {"lanes_g": 4}, clocks_behind_core=16),
)


SUMS = {"hidden_sums": hidden_sums, "output_sums": output_sums}


def verify(claim: Claim, rtl: Path, checkers: Path, out: Path) -> Verdict:
    """Prove or refute a claim about the VHDL of folder rtl; intermediate files go to a folder of its name in out."""
    folder, parameters = out / claim.name, dict(claim.parameters)
    if claim.checker in SUMS:
        design = _design(claim.entity, claim.generics, rtl, folder)
        # tb/formal stands beside the weights that are shipped.
        fixed = quantise(load_network(checkers.parents[1] / "weights" / "spheiro"), load_parameters())
        checker = folder / f"{claim.checker}.sv"
        checker.write_text(SUMS[claim.checker](fixed, claim.generics["lanes_g"]))
        return induct(design, checker, folder)
    if claim.clocks_behind_core is not None:
        core = _design("gc_core", claim.generics, rtl, folder / "core")
        # The shortest run to a result; that all others take as long is then proven.
        latency = shortest_run(core, checkers / "valid_pipeline.sv", folder / "core", {"LATENCY": 0}) - 1
        parameters["LATENCY"] = latency + claim.clocks_behind_core
    design = _design(claim.entity, claim.generics, rtl, folder)
    checker, clocks = checkers / f"{claim.checker}.sv", parameters.get("INTERVAL", 1)
    return model_check(design, checker, folder, parameters, clocks)


def _design(entity: str, generics: Mapping[str, int], rtl: Path, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return to_verilog(rtl_sources(rtl), entity, generics, folder / "design.v")
