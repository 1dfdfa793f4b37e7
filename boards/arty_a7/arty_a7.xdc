# Pins of the Arty A7-35T and A7-100T for boards/arty_a7/arty_a7.vhd, by the pins of its Pmod sockets. Never run.
create_clock -name clk_100mhz -period 10.000 [get_ports clk_100mhz]
# Registers and core: what crosses, see constraints/gc_serial_system.xdc.
set_max_delay -datapath_only -from [get_clocks -of_objects [get_nets clk_25]] -to [get_clocks -of_objects [get_nets i_board/clk]] 25.000
set_max_delay -datapath_only -from [get_clocks -of_objects [get_nets i_board/clk]] -to [get_clocks -of_objects [get_nets clk_25]] 25.000
set_false_path -from [get_ports {reset_n uart_rx enc_a[*] enc_b[*] enc_z[*] enc_error[*] estop_n brake_fed[*]}]
set_property CFGBVS VCCO [current_design]
set_property CONFIG_VOLTAGE 3.3 [current_design]
# Pulls act once the part is configured; until then pins float or are pulled up, by its pin PUDC_B: brake_free needs a resistor to
# ground, brake_hold one to 3.3 V, outside.
set_property -dict {PACKAGE_PIN E3 IOSTANDARD LVCMOS33} [get_ports {clk_100mhz}]
set_property -dict {PACKAGE_PIN D10 IOSTANDARD LVCMOS33} [get_ports {uart_tx}]; # of the part
set_property -dict {PACKAGE_PIN A9 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {uart_rx}]
set_property -dict {PACKAGE_PIN C2 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {reset_n}]; # RESET
set_property -dict {PACKAGE_PIN J5 IOSTANDARD LVCMOS33} [get_ports {led}]; # LD5
# What must not float: an encoder without a plug, a loose emergency stop.
set_property -dict {PACKAGE_PIN G13 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {enc_a[0]}]; # JA1
set_property -dict {PACKAGE_PIN B11 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {enc_b[0]}]; # JA2
set_property -dict {PACKAGE_PIN A11 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {enc_z[0]}]; # JA3
set_property -dict {PACKAGE_PIN D12 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {enc_error[0]}]; # JA4
set_property -dict {PACKAGE_PIN D13 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {brake_fed[0]}]; # JA7
set_property -dict {PACKAGE_PIN B18 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {pwm_up[0]}]; # JA8
set_property -dict {PACKAGE_PIN A18 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {pwm_down[0]}]; # JA9
set_property -dict {PACKAGE_PIN K16 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {brake_free[0]}]; # JA10
set_property -dict {PACKAGE_PIN E15 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {brake_hold[0]}]; # JB1
set_property -dict {PACKAGE_PIN E16 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {enc_a[1]}]; # JB2
set_property -dict {PACKAGE_PIN D15 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {enc_b[1]}]; # JB3
set_property -dict {PACKAGE_PIN C15 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {enc_z[1]}]; # JB4
set_property -dict {PACKAGE_PIN J17 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {enc_error[1]}]; # JB7
set_property -dict {PACKAGE_PIN J18 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {brake_fed[1]}]; # JB8
set_property -dict {PACKAGE_PIN K15 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {pwm_up[1]}]; # JB9
set_property -dict {PACKAGE_PIN J15 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {pwm_down[1]}]; # JB10
set_property -dict {PACKAGE_PIN U12 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {brake_free[1]}]; # JC1
set_property -dict {PACKAGE_PIN V12 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {brake_hold[1]}]; # JC2
set_property -dict {PACKAGE_PIN V10 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {enc_a[2]}]; # JC3
set_property -dict {PACKAGE_PIN V11 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {enc_b[2]}]; # JC4
set_property -dict {PACKAGE_PIN U14 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {enc_z[2]}]; # JC7
set_property -dict {PACKAGE_PIN V14 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {enc_error[2]}]; # JC8
set_property -dict {PACKAGE_PIN T13 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {brake_fed[2]}]; # JC9
set_property -dict {PACKAGE_PIN U13 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {pwm_up[2]}]; # JC10
set_property -dict {PACKAGE_PIN D4 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {pwm_down[2]}]; # JD1
set_property -dict {PACKAGE_PIN D3 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {brake_free[2]}]; # JD2
set_property -dict {PACKAGE_PIN F4 IOSTANDARD LVCMOS33 PULLUP true} [get_ports {brake_hold[2]}]; # JD3
set_property -dict {PACKAGE_PIN F3 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {estop_n}]; # JD4
set_property -dict {PACKAGE_PIN E2 IOSTANDARD LVCMOS33 PULLDOWN true} [get_ports {drive_on}]; # JD7
