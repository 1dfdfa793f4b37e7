"""The network: Gamma, training, weights as CSV, formats, the bit-true model and the ROM writer."""
