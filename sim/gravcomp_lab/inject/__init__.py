"""Single-bit flips in every register and memory of gc_system while it holds a pose: what does one wrong bit do?"""
