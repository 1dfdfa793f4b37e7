# Quartus and Radiant, gc_force_path alone: its clock, and pins without a timing relation to it. In a larger design the clock
# is defined there.
create_clock -name clk -period 25.000 [get_ports clk]

# Each pin ends in a synchroniser.
set_false_path -from [get_ports {pin_a[*] pin_b[*] pin_z[*] pin_error[*]}]
