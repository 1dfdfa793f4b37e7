"""One module per command of the lab, as in gravcomp.commands."""
