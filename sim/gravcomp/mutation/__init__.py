"""Mutation testing of the VHDL: small faults are planted, one at a time; a test must fail for each."""
