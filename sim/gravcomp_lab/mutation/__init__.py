"""How good the tests of the VHDL are: faults planted in it, one at a time, and the statements that no test runs."""
