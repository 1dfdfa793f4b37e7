"""The core as a peripheral of a system on chip that is built in Python."""
