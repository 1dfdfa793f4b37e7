"""The network: Gamma, and the folder of weights as CSV."""
