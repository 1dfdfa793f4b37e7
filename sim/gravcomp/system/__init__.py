"""The system around the network as a host sees it: registers and driver."""
