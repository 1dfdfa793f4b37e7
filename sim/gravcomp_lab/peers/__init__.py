"""The same network from other people's generators, for comparison: da4ml and NNgen."""
