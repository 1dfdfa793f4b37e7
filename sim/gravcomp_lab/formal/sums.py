"""Checkers, in SystemVerilog, that no sum of the network overflows: written from the weights that the ROMs hold.

A checker follows the data through gc_hidden_lane or gc_output_layer, neuron by neuron, and asserts of every register on
the way in which interval it lies: that of the products of its weights with any operand of 18 bits. The intervals are
inductive, each follows from those before it, and no adder leaves its width within them. Products are free values
that lie, where one operand is a weight w, between -2^17 w and (2^17 - 1) w: all that is used about a multiplier.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from gravcomp.core.formats import OPERAND_BITS, FixedNetwork

_LOW, _HIGH = -(2 ** (OPERAND_BITS - 1)), 2 ** (OPERAND_BITS - 1) - 1
Interval = tuple[int, int]


@dataclass(frozen=True)
class Multiplier:
    """A multiplier of the design, the ROM word that holds its weight, with width and lowest bit, a weight per step."""

    multiplier: str
    word: str
    word_bits: int
    word_low: int
    weights: list[int]


@dataclass(frozen=True)
class AdderTree:
    """An adder tree of the design, its products, and the bias of each step: its last term (bias_term), or the start of
    an accumulator, which then has a width and a lowest bit in its register."""

    path: str
    products: list[Multiplier]
    bias: list[int]
    bias_term: bool = True
    accumulator_bits: int = 0
    accumulator_low: int = 0


def hidden_sums(fixed: FixedNetwork, lanes: int, lane: int = 0) -> str:
    """Checker of gc_hidden_lane with generics lanes_g and lane_g: module hidden_sums."""
    neurons = slice(lane, None, lanes)
    bits = OPERAND_BITS * fixed.n_inputs + fixed.hidden_sum_bits
    products = [
        Multiplier(f"g_input_n{i + 1}_i_multiply", "word", bits, OPERAND_BITS * i, [int(row[i]) for row in rows])
        for i, rows in enumerate([fixed.hidden_weights[neurons]] * fixed.n_inputs)
    ]
    tree = AdderTree("i_sum", products, [int(bias) for bias in fixed.hidden_bias[neurons]])
    width = fixed.hidden_sum_bits
    return _checker(
        "hidden_sums", "gc_hidden_lane", "in_x", fixed.n_inputs, width, int(lanes == 1), ["g_weights_i_rom"], tree
    )


def output_sums(fixed: FixedNetwork, lanes: int, k: int) -> str:
    """Checker of gc_output_layer with generic lanes_g, of output k: module output_sums."""
    bits, n = fixed.output_sum_bits, fixed.n_axes
    products = [
        Multiplier(
            f"g_lane_n{lane + 1}_g_output_n{k + 1}_i_multiply",
            f"g_lane_n{lane + 1}_word",
            OPERAND_BITS * n,
            OPERAND_BITS * k,
            [int(weight) for weight in fixed.output_weights[k, lane::lanes]],
        )
        for lane in range(lanes)
    ]
    bias = [int(fixed.output_bias[k])] * (fixed.n_hidden // lanes)
    accumulates = (
        {} if len(bias) == 1 else {"bias_term": False, "accumulator_bits": bits * n, "accumulator_low": bits * k}
    )
    tree = AdderTree(f"g_tree_n{k + 1}_i_tree", products, bias, **accumulates)
    roms = [f"g_lane_n{lane + 1}_g_weights_i_rom" for lane in range(lanes)]
    term_clocks = int(lanes in (1, fixed.n_hidden))
    packed = sum(int(value) % 2**bits << bits * axis for axis, value in enumerate(fixed.output_bias))
    constants = {"scalars_output_bias": f"{bits * n}'h{packed:x}"}
    return _checker("output_sums", "gc_output_layer", "in_h", lanes, bits, term_clocks, roms, tree, constants)


def _checker(
    name: str,
    entity: str,
    port: str,
    n_operands: int,
    bits: int,
    term_clocks: int,
    roms: list[str],
    tree: AdderTree,
    constants: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """term_clocks: registers between product and tree, as gc_fixed_pkg has it; no proof succeeds with a wrong one.

    constants: what ports of the entity are tied to, as Verilog.
    """
    steps = len(tree.bias)
    depth = (len(tree.products) + tree.bias_term - 1).bit_length()
    facts = _Facts(bits, 2 + term_clocks + depth)
    facts.add(f"done < {steps}")
    for rom in roms if steps > 1 else []:
        address = facts.wire(f"{rom}.g_rom_address", (steps - 1).bit_length())
        facts.add(f"{address} == (at_0 == {steps - 1} ? 0 : at_0 + 1)")
    per_step = _intervals(tree, 2**depth)
    for product in tree.products:
        _product_facts(facts, product)
    if tree.bias_term and steps > 1:
        word = facts.wire("word", tree.products[0].word_bits)
        facts.add(f"$signed({word}[{OPERAND_BITS * len(tree.products)} +: {bits}]) == {facts.pick(0, tree.bias)}")
        for stage in (1, 2):
            bias = facts.wire(f"bias_{stage}", bits)
            facts.add(f"!valid_{stage} || $signed({bias}) == {facts.pick(stage, tree.bias)}")
    root = _node_facts(facts, tree, depth, per_step)
    if not tree.bias_term:
        _accumulator_facts(facts, tree, root, per_step)
    valids, last = _valids(facts, tree), facts.n_stages
    tied = "".join(f", .{pin}({value})" for pin, value in constants.items())
    places = [f"  wire [5:0] at_{last} = done;"]
    for k in reversed(range(last)):
        places.append(f"  wire [5:0] at_{k} = valid_{k + 1} ? ({_following(f'at_{k + 1}', steps)}) : at_{k + 1};")
    return _MODULE.format(
        name=name, entity=entity, port=port, constants=tied, high=OPERAND_BITS * n_operands - 1, bits=bits, last=last,
        wires="\n".join(facts.wires), assumptions="\n".join(facts.assumptions), facts=" &&\n        ".join(facts.facts),
        valids=valids, places="\n".join(places), next_step=_following("done", steps),
    )  # fmt: skip


def _following(step: str, steps: int) -> str:
    return f"{step} == {steps - 1} ? 0 : {step} + 1"


_MODULE = """\
// Written by gravcomp_lab.formal.sums from the weights.
module fits (
    input [{bits}-1:0] a,
    input [{bits}-1:0] b,
    output ok
);
  wire [{bits}:0] sum = {{a[{bits}-1], a}} + {{b[{bits}-1], b}};
  assign ok = sum[{bits}] == sum[{bits}-1];
endmodule

module {name} (
    input clk,
    input rst,
    input in_valid,
    input [{high}:0] data
);

  {entity} dut (.clk(clk), .rst(rst), .in_valid(in_valid), .{port}(data){constants});

{wires}

  // Whether there are data in stage k, and their step; done: the step of the next data to leave the last stage.
{valids}
  reg [5:0] done = 0;
{places}

  always @(posedge clk) done <= rst ? 0 : valid_{last} ? ({next_step}) : done;

  always @* begin
{assumptions}
    no_sum_overflows :
      assert (
        {facts}
      );
  end

endmodule
"""


def _valids(facts: "_Facts", tree: AdderTree) -> str:
    """Wires valid_1, valid_2 ... of the stages: the multiplier's two, then one per level of the tree."""
    multiplier = tree.products[0].multiplier
    ends = facts.n_stages - 2
    names = [facts.wire(f"{multiplier}.valid_1", 1)]
    levels = facts.wire(f"{tree.path}.valid", ends + 1)
    names += [f"{levels}[{ends - k}]" for k in range(ends + 1)]
    return "\n".join(f"  wire valid_{k} = {name};" for k, name in enumerate(names, start=1))


def _intervals(tree: AdderTree, leaves: int) -> list[list[Interval]]:
    """Interval of each leaf of the tree in each step."""
    per_step = []
    for s, bias in enumerate(tree.bias):
        leaf = [_product_interval(product.weights[s]) for product in tree.products] + [(bias, bias)] * tree.bias_term
        per_step.append(leaf + [(0, 0)] * (leaves - len(leaf)))
    return per_step


def _node_facts(facts: "_Facts", tree: AdderTree, depth: int, per_step: list[list[Interval]]) -> str:
    """Facts about the nodes of a tree, a heap whose node 1 is the root, in the highest bits; returns the root."""
    leaves = 2**depth
    wire = facts.wire(f"{tree.path}.node", (2 * leaves - 1) * facts.bits)
    node = {k: f"{wire}[{(2 * leaves - 1 - k) * facts.bits} +: {facts.bits}]" for k in range(1, 2 * leaves)}
    for k in node:
        level = depth + 1 - k.bit_length()
        under = slice((k << level) - leaves, (k + 1 << level) - leaves)
        of_step = [tuple(sum(ends) for ends in zip(*leaf[under], strict=True)) for leaf in per_step]
        stage = facts.n_stages - depth + level
        facts.within(f"$signed({node[k]})", stage, of_step)
        if level:
            facts.fits(node[2 * k], node[2 * k + 1], stage - 1)
    return node[1]


def _accumulator_facts(facts: "_Facts", tree: AdderTree, root: str, per_step: list[list[Interval]]) -> None:
    wire = facts.wire("g_accumulate_acc", tree.accumulator_bits)
    accumulator = f"{wire}[{tree.accumulator_low} +: {facts.bits}]"
    before = [(tree.bias[0], tree.bias[0])]
    for leaf in per_step[:-1]:
        before.append(tuple(end + sum(ends) for end, ends in zip(before[-1], zip(*leaf, strict=True), strict=True)))
    facts.within(f"$signed({accumulator})", facts.n_stages, before, when="")
    facts.fits(accumulator, root, facts.n_stages)
    ring = facts.wire("g_accumulate_step", len(tree.bias))
    facts.add(f"{ring} == 1 << at_{facts.n_stages}")


def _product_facts(facts: "_Facts", product: Multiplier) -> None:
    word = facts.wire(product.word, product.word_bits)
    facts.add(f"$signed({word}[{product.word_low} +: {OPERAND_BITS}]) == {facts.pick(0, product.weights)}")
    operand = facts.wire(f"{product.multiplier}.b_1", OPERAND_BITS)
    facts.add(f"!valid_1 || $signed({operand}) == {facts.pick(1, product.weights)}")
    free = facts.wire(f"{product.multiplier}.product", 2 * OPERAND_BITS)
    intervals = [_product_interval(weight) for weight in product.weights]
    low, high = (facts.pick(1, [interval[end] for interval in intervals]) for end in (0, 1))
    facts.assumptions.append(
        f"    assume ($signed({operand}) != {facts.pick(1, product.weights)} "
        f"|| $signed({free}) >= {low} && $signed({free}) <= {high});"
    )
    result = facts.wire(f"{product.multiplier}.product_2", 2 * OPERAND_BITS)
    facts.within(f"$signed({result})", 2, intervals)


def _product_interval(weight: int) -> Interval:
    return min(_LOW * weight, _HIGH * weight), max(_LOW * weight, _HIGH * weight)


class _Facts:
    """Wires into the design, assumptions and facts of a checker. Stage 0 is the input, each next one a clock later."""

    def __init__(self, bits: int, n_stages: int):
        self.bits, self.n_stages = bits, n_stages
        self.wires: list[str] = []
        self.assumptions: list[str] = []
        self.facts: list[str] = []
        self._n_adders = 0

    def wire(self, path: str, bits: int) -> str:
        """The name of the design's signal of this path and width."""
        name = f"\\dut.{path} "
        line = f"  (* hierconn *) wire [{bits - 1}:0] {name};"
        if line not in self.wires:
            self.wires.append(line)
        return name

    def pick(self, stage: int, values: list[int]) -> str:
        """The value of the step that is in a stage, as an expression one bit wider than the sums."""
        *others, last = [f"{'-' * (value < 0)}{self.bits + 1}'sd{abs(value)}" for value in values]
        if set(others) <= {last}:
            return last
        for s in reversed(range(len(others))):
            last = f"at_{stage} == {s} ? {others[s]} : {last}"
        return f"({last})"

    def add(self, fact: str) -> None:
        self.facts.append(f"({fact})")

    def within(self, value: str, stage: int, intervals: list[Interval], when: str | None = None) -> None:
        low, high = (self.pick(stage, [interval[end] for interval in intervals]) for end in (0, 1))
        when = f"!valid_{stage} || " if when is None else when
        self.add(f"{when}{value} >= {low} && {value} <= {high}")

    def fits(self, left: str, right: str, stage: int) -> None:
        """No overflow of the sum of two values of a stage."""
        ok = f"fits_{self._n_adders}"
        self._n_adders += 1
        self.wires.append(f"  wire {ok};\n  fits i_{ok} (.a({left}), .b({right}), .ok({ok}));")
        self.add(f"!valid_{stage} || {ok}")
