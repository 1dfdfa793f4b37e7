# Clocks of boards/de10_nano/de10_nano.vhd, and what crosses between them: see constraints/gc_serial_system.sdc. Never run.
create_clock -name clk_50mhz -period 20.000 [get_ports clk_50mhz]
derive_pll_clocks
derive_clock_uncertainty
set core [get_clocks {i_board|i_pll|*}]
set_max_delay -from $core -to [get_clocks clk_50mhz] 20.000
set_max_delay -from [get_clocks clk_50mhz] -to $core 20.000
set_min_delay -from $core -to [get_clocks clk_50mhz] -20.000
set_min_delay -from [get_clocks clk_50mhz] -to $core -20.000
set_false_path -from [get_ports {reset_n uart_rx enc_a[*] enc_b[*] enc_z[*] enc_error[*] estop_n brake_fed[*]}]
