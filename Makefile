# Everything runs from here; `make` alone lists the targets. The first `make sim` or `make test` installs what it needs.

WEIGHTS ?= weights/spheiro
BOARD ?= list
DATA ?= data/prototype.csv
HIDDEN ?= 20
RUN := .venv/bin
LAB := $(RUN)/python -m gravcomp_lab
# BLAS keeps to one thread: the matrices are small, and -n auto takes all cores.
# A worker that runs out of tests takes over half of what another has left: the long ones come last.
PARALLEL := -n auto --dist worksteal
PYTEST := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(RUN)/python -m pytest
export WEIGHTS

.DEFAULT_GOAL := help
.PHONY: $(shell sed -n 's/^\([a-z0-9-]*\):.*/\1/p' Makefile)

help: ## list the targets
	@grep -E '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 17

setup:
	@scripts/setup.sh

sim: setup ## the main job: robot poses through the encoder pins of the VHDL under GHDL; table and pictures
	@$(RUN)/gravcomp rom --weights "$(WEIGHTS)" --check
	@$(LAB) sim-report --weights "$(WEIGHTS)"

formal: setup ## what is proven about the hardware, for every input and without a bound; docs/measured/formal.md says how
	@$(LAB) formal --docs docs/measured

mutate: setup ## plant faults in the VHDL, one at a time: does a test catch each? Only what changed; docs/measured/mutation.md
	@$(LAB) mutate --docs docs/measured

inject: setup ## flip single bits in every register and memory of gc_system while it holds a pose; docs/measured/injection.md
	@$(LAB) inject --docs docs/measured

ports: setup ## plant a fault at every output port of every entity: which proof or test sees it? docs/measured/ports.md
	@$(LAB) ports --docs docs/measured

cells: setup ## every cause of a fault in every state on every axis, or proven absent; docs/measured/cells.md
	@$(PYTEST) -q tb/test_rtl_safety_cells.py
	@$(LAB) cells --docs docs/measured

branches: setup ## the branches of the VHDL that the tests take, those that are not written too; docs/measured/branches.md
	@$(LAB) branches --docs docs/measured

coverage: ## the statements of the VHDL that the tests run; docs/measured/coverage.md
	@scripts/setup.sh ghdl-gcc
	@$(LAB) coverage --docs docs/measured

test: setup ## all tests but the long ones of the netlists, for which see gatesim
	@scripts/setup.sh chromium || echo "test: no Chromium can be installed here; report.html is not looked at" >&2
	@$(PYTEST) -q $(PARALLEL)

test-fast: setup ## the tests that take less than ten seconds each
	@$(PYTEST) -q $(PARALLEL) -m "not slow"

test-core: setup ## gc_core with the network of WEIGHTS, after rom: bit for bit, interval, latency, operations, at every number of lanes
	@$(RUN)/gravcomp rom --weights "$(WEIGHTS)" --check
	@$(PYTEST) -q $(PARALLEL) -m "" tb/test_rtl_core.py tb/test_rtl_budget.py -k "not shipped_machine"

test-simulators: setup ## the tests of the RTL on other simulators: Debian 13's GHDL 5.0.1 and ghdl-llvm; says what cannot be had
	@scripts/setup.sh ghdl-llvm || echo "test-simulators: ghdl-llvm cannot be installed here" >&2
	@scripts/test_simulators.sh -q $(PARALLEL) $(if $(TESTS),$(TESTS),tb/test_rtl_*.py)

train: setup ## train the network of the machine in WEIGHTS anew, of HIDDEN neurons; write it there, and its ROM
	@$(RUN)/gravcomp train --robot "$(WEIGHTS)" --hidden "$(HIDDEN)" --out "$(WEIGHTS)"
	@$(RUN)/gravcomp rom --weights "$(WEIGHTS)"

table1: setup ## the paper's Table 1, trained here, beside the paper's figures
	@$(LAB) table1

rom: setup ## write rtl/generated, network and registers, from the machine folder WEIGHTS
	@$(RUN)/gravcomp rom --weights "$(WEIGHTS)"

regs: setup ## write the C header of the registers, pages (build/registers) and IP-XACT from rtl/registers/gc_registers.rdl
	@scripts/registers.sh

system: setup ## gc_system: registers, interrupt, results on two clocks; path latency from encoder edge to command
	@$(PYTEST) -q tb/test_rtl_system.py
	@$(LAB) path --weights "$(WEIGHTS)"

hil: setup ## the robot in the physics engine and gc_system with its servo in one simulation, with and without the network, faults; docs/measured/hil.md
	@$(LAB) hil --docs docs/measured

campaign: setup ## a robot in the physics engine measures itself over the RTL, finds what its model lacks, loads it, measures again: SEEDS="0"
	@$(LAB) campaign --seeds $(or $(SEEDS),0)

campaign-blind: setup ## ten of them, each with an effect drawn by seed and sealed; docs/measured/campaign.md
	@$(LAB) campaign --seeds 0 1 2 3 4 5 6 7 8 9 --docs docs/measured

budget: setup ## operations per inference: counted in NumPy, counted in the running VHDL, and those of the statics
	@$(LAB) budget --weights "$(WEIGHTS)"

latency: setup ## initiation interval and latency per number of lanes, measured in simulation
	@$(LAB) latency --weights "$(WEIGHTS)"

formats: setup ## what every signal of the core can hold over all counts; fixed point against float
	@$(RUN)/gravcomp formats --weights "$(WEIGHTS)"

certify: setup ## prove the largest error of the core over all poses of the machine in WEIGHTS
	@$(RUN)/gravcomp certify "$(WEIGHTS)"

certify-all: setup ## the same for every shipped machine; docs/measured/certify.md
	@$(LAB) certify --docs docs/measured

docs: sim budget ## docs/measured/results.md and its pictures, from fresh runs
	@set -e; { echo "# Results"; echo; echo "Written by \`make docs\`."; \
	   echo; echo "## End to end"; echo; $(LAB) sim-report --weights "$(WEIGHTS)" --pictures docs/measured/figures; \
	   echo; echo "## Interval and latency"; echo; $(LAB) latency --weights "$(WEIGHTS)"; \
	   echo; echo "## Operations"; echo; $(LAB) budget --weights "$(WEIGHTS)"; \
	   echo; echo "## Fixed point"; echo; $(RUN)/gravcomp formats --weights "$(WEIGHTS)"; } >build/results.md
	@mv build/results.md docs/measured/results.md

docs-site: setup ## docs/ as a site in build/site; a broken link is an error
	@$(RUN)/mkdocs build --strict
	@echo "build/site/index.html"

loop: setup ## close the loop with measured data: DATA=log.csv, WEIGHTS=weights/mine, SAVE=weights/next; error before and after
	@$(RUN)/gravcomp loop "$(DATA)" --weights "$(WEIGHTS)" --out build/loop \
	   $(if $(SAVE),--save "$(SAVE)")
	@$(LAB) loop-rtl --loop build/loop

blind: setup ## tally of the diagnosis on data sets drawn by seed; docs/measured/blind.md
	@$(LAB) blind --jobs 2 --docs docs/measured

next-motion: setup ## does one planned measurement leave one name? docs/measured/plan.md
	@$(LAB) next-motion --docs docs/measured

joint-stages: setup ## what stages for play and passive joints' friction would gain and cost; docs/measured/joints.md
	@$(LAB) joint-stages --docs docs/measured

table2: setup ## the paper's Table 2 on the virtual prototype; docs/measured/table2.md
	@$(LAB) table2

table2-real: setup ## the paper's Table 2 on a real arm: GRAVCOMP_DATA=folder with dvrk_mtm/holds.csv; docs/measured/table2_real.md
	@$(LAB) table2-real

synth: setup ## area and clock of the core of WEIGHTS with LANES="1 4 20", FORM=paper or lean, placed and routed on ECP5, or FORM=serial on iCE40 and Gowin; docs/measured/synthesis.md
	@$(LAB) synth --weights "$(WEIGHTS)" $(if $(LANES),--lanes $(LANES)) $(if $(FORM),--form $(FORM)) \
	   $(if $(filter weights/spheiro,$(WEIGHTS)),$(if $(LANES),,--docs docs/measured))

machines: setup ## the shipped machines: error, neurons, operations, clocks, cells of the core; docs/measured/machines.md
	@$(LAB) machines --docs docs/measured

sweep: setup ## error of arm2 against the size of its network; docs/measured/machines.md
	@$(RUN)/gravcomp train --robot weights/arm2 --hidden 8,12,20,32,64 --starts 1 --search 0.03 --polish 300 --out build/sweep
	@$(LAB) sweep build/sweep --docs docs/measured

largest-error: setup ## mean square against largest error: both networks of the Sphe.I.Ro., picture; docs/measured/largest_error.md
	@$(LAB) largest-error --docs docs/measured

bitstream: setup ## a bitstream: BOARD=ulx3s-85f (BOARD=list names all), WEIGHTS=, SELFTEST=1 without a robot, SEED=
	@$(LAB) bitstream "$(BOARD)" --weights "$(WEIGHTS)" $(if $(SELFTEST),--selftest) --seed $(or $(SEED),1)

guards: setup ## cells of the safety chain with its guards off and on; docs/guide/safety.md
	@$(LAB) guards --docs docs/guide

synth-tops: setup ## area and both clocks of whole tops, ports on scan chains, or of TOP=gc_system with LANES, FORM, LOADABLE=1, SPEEDS, SEEDS
	@$(LAB) synth-top --weights "$(WEIGHTS)" $(if $(TOP),--top $(TOP) $(if $(LANES),--lanes $(LANES)) \
	   $(if $(FORM),--form $(FORM)) $(if $(LOADABLE),--loadable),$(if $(filter weights/spheiro,$(WEIGHTS)),--docs docs/measured)) \
	   $(if $(SPEEDS),--speeds $(SPEEDS)) $(if $(SEEDS),--seeds $(SEEDS))

synth-all: setup ## the same with 1, 2, 4, 5, 10 and 20 lanes
	@$(LAB) synth --lanes 1 2 4 5 10 20 --docs docs/measured

gatesim: setup ## the core as GHDL's Verilog, as generic and as ECP5 netlist passes the tests of the VHDL, under Icarus
	@$(PYTEST) -q $(PARALLEL) -m "" tb/test_rtl_gates.py

gatesim-nightly: setup ## 100 000 random poses through GHDL's Verilog, 10 000 through the ECP5 netlist, under Verilator
	@$(PYTEST) -s -m gatesim tb/test_rtl_poses.py

peers: setup ## the core beside da4ml and NNgen (same flow; slow) and beside this machine's processor; docs/measured/peers.md
	@$(RUN)/python -c "import da4ml, nngen" 2>/dev/null || \
	   $(RUN)/pip install --constraint constraints.txt --editable '.[peers]'
	@$(LAB) peers --docs docs/measured
	@$(LAB) jitter --docs docs/measured

peers-diagnosis: setup ## the diagnosis beside least squares, PySINDy and random trees on blind sets; docs/measured/peers_diagnosis.md
	@$(RUN)/python -c "import pysindy" 2>/dev/null || \
	   $(RUN)/pip install --constraint constraints.txt --editable '.[peers]'
	@$(LAB) peers-diagnosis --docs docs/measured

lint: setup ## Python and VHDL: style, and GHDL's warnings as errors
	@$(RUN)/ruff check . && $(RUN)/ruff format --check .
	@scripts/lint_vhdl.sh
	@scripts/lint_constructs.sh

clean: ## remove what was built, but not .venv
	rm -rf build
