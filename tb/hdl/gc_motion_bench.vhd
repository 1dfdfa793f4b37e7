-- SPDX-License-Identifier: MIT
--
-- Setpoints, servo, drive and recorder, wired as docs/guide/motion.md says; the test is encoders, core and robot.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;
  use work.gc_servo_pkg.all;

entity gc_motion_bench is
  port (
    clk              : in    std_ulogic;
    rst              : in    std_ulogic;
    run              : in    std_ulogic;
    in_valid         : in    std_ulogic;
    in_count         : in    signed(axes_c * 32 - 1 downto 0);
    feed_valid       : in    std_ulogic;
    feed_current     : in    signed(axes_c * 32 - 1 downto 0);
    move_valid       : in    std_ulogic;
    move_ready       : out   std_ulogic;
    move_target      : in    signed(axes_c * 32 - 1 downto 0);
    move_ticks       : in    unsigned(31 downto 0);
    cfg_speed        : in    unsigned(axes_c * 32 - 1 downto 0);
    cfg_acceleration : in    unsigned(axes_c * 32 - 1 downto 0);
    cfg_proportional : in    unsigned(axes_c * gain_bits_c - 1 downto 0);
    cfg_integral     : in    unsigned(axes_c * gain_bits_c - 1 downto 0);
    cfg_derivative   : in    unsigned(axes_c * gain_bits_c - 1 downto 0);
    cfg_filter       : in    unsigned(filter_bits_c - 1 downto 0);
    cfg_speed_feed   : in    std_ulogic;
    cfg_limit        : in    unsigned(axes_c * 31 - 1 downto 0);
    cfg_astray       : in    unsigned(axes_c * 32 - 1 downto 0);
    drive_limit      : in    unsigned(axes_c * 31 - 1 downto 0);
    drive_slew       : in    unsigned(axes_c * 31 - 1 downto 0);
    out_setpoint     : out   signed(axes_c * 32 - 1 downto 0);
    out_current      : out   signed(axes_c * 32 - 1 downto 0);
    out_astray       : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_correction   : out   signed(axes_c * 32 - 1 downto 0);
    in_tick          : in    unsigned(31 downto 0);
    cfg_mode         : in    unsigned(1 downto 0);
    cfg_before       : in    unsigned(7 downto 0);
    read_addr        : in    unsigned(7 downto 0);
    read_word        : out   std_ulogic_vector(31 downto 0);
    sts_records      : out   unsigned(7 downto 0);
    sts_done         : out   std_ulogic
  );
end entity gc_motion_bench;

architecture sim of gc_motion_bench is

  constant none_c : std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');

  signal setpoint      : signed(axes_c * 32 - 1 downto 0);
  signal servo_valid   : std_ulogic;
  signal servo_current : signed(axes_c * 32 - 1 downto 0);
  signal command       : signed(axes_c * 32 - 1 downto 0);
  signal drive_valid   : std_ulogic;
  signal status        : std_ulogic_vector(29 downto 0);
  signal fault         : std_ulogic;

begin

  i_setpoint : entity work.gc_setpoint
    generic map (
      axes_g => axes_c
    )
    port map (
      clk              => clk,
      rst              => rst,
      run              => run,
      in_count         => in_count,
      in_valid         => in_valid,
      move_valid       => move_valid,
      move_ready       => move_ready,
      move_target      => move_target,
      move_ticks       => move_ticks,
      cfg_speed        => cfg_speed,
      cfg_acceleration => cfg_acceleration,
      out_setpoint     => setpoint,
      sts_refused      => open,
      sts_rate         => open
    );

  i_servo : entity work.gc_servo
    generic map (
      axes_g => axes_c
    )
    port map (
      clk              => clk,
      rst              => rst,
      run              => run,
      in_valid         => in_valid,
      in_count         => in_count,
      in_setpoint      => setpoint,
      cfg_proportional => cfg_proportional,
      cfg_integral     => cfg_integral,
      cfg_derivative   => cfg_derivative,
      cfg_filter       => cfg_filter,
      cfg_speed_feed   => cfg_speed_feed,
      cfg_limit        => cfg_limit,
      cfg_astray       => cfg_astray,
      feed_valid       => feed_valid,
      feed_current     => feed_current,
      out_valid        => servo_valid,
      out_current      => servo_current,
      out_astray       => out_astray,
      sts_correction   => sts_correction
    );

  i_drive : entity work.gc_drive
    port map (
      clk          => clk,
      rst          => rst,
      run          => run,
      in_valid     => servo_valid,
      in_current   => servo_current,
      in_clipped   => none_c,
      cfg_limit    => drive_limit,
      cfg_slew     => drive_slew,
      cfg_bound    => drive_limit,
      out_valid    => drive_valid,
      out_current  => command,
      out_limited  => open,
      out_reached  => open,
      out_deviates => open
    );

  status <= (0 => run, others => '0');
  fault <= not run;

  i_recorder : entity work.gc_recorder
    generic map (
      axes_g         => axes_c,
      address_bits_g => 8
    )
    port map (
      clk           => clk,
      rst           => rst,
      cfg_mode      => cfg_mode,
      cfg_ticks     => "0000",
      cfg_mean      => '0',
      cfg_before    => cfg_before,
      in_valid      => drive_valid,
      in_tick       => in_tick,
      in_status     => status,
      in_count      => in_count,
      in_period     => setpoint,
      in_command    => command,
      in_force      => feed_current,
      in_trigger    => fault,
      sense_valid   => not none_c,
      sense_current => command,
      read_addr     => read_addr,
      read_word     => read_word,
      in_drop       => '0',
      sts_records   => sts_records,
      sts_lost      => open,
      sts_triggered => open,
      sts_done      => sts_done
    );

  out_setpoint <= setpoint;
  out_current <= command;

end architecture sim;
