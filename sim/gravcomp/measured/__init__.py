"""Measured data: reading it, effects that a model may lack, diagnosis, report; the virtual prototype to measure."""
