"""The virtual prototype: a machine in MuJoCo with imperfections, to measure on."""
