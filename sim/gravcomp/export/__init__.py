"""The compensator's constants as tables of drives that add friction and cogging by themselves.

``tables`` samples the constants of an axis, ``motor`` sees its cogging from the motor's shaft, ``formats`` writes
files.
"""
