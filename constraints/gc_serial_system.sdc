# Quartus and Radiant, gc_serial_system alone: its two clocks, and what crosses between them. In a larger design the clocks are
# defined there.
create_clock -name clk -period 25.000 [get_ports clk]
create_clock -name bus_clk -period 25.000 [get_ports bus_clk]

# The clocks are unrelated. A word that crosses (gc_crossing_bus) is stable for two clocks of its destination, a single
# bit ends in a synchroniser: less than one period of the faster clock is safe for both, and there is no hold to meet.
set_max_delay -from [get_clocks clk] -to [get_clocks bus_clk] 25.000
set_max_delay -from [get_clocks bus_clk] -to [get_clocks clk] 25.000
set_min_delay -from [get_clocks clk] -to [get_clocks bus_clk] -25.000
set_min_delay -from [get_clocks bus_clk] -to [get_clocks clk] -25.000

# Each pin ends in a synchroniser.
set_false_path -from [get_ports {pin_rx pin_a[*] pin_b[*] pin_z[*] pin_error[*] estop_n brake_fed[*]}]
