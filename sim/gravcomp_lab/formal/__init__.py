"""Proofs about the hardware for every input and every run, not for samples."""
