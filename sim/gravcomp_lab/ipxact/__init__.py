"""The core as an IP-XACT component."""
