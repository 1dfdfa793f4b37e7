"""The loop closes by itself: a machine measures itself, finds what its model lacks, loads it and measures again."""
