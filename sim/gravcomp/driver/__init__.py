"""The host's side of gc_system: its registers and the driver that uses them."""
