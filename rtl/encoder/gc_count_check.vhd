-- SPDX-License-Identifier: MIT
--
-- Whether the levels of a and b that the glitch filters let through make the same count as all levels, the short ones
-- included: a level that is too short for the filter costs nothing, or four counts.
--
--   lead = counts of the samples - counts of the filtered levels, modulo 8
--
-- Where samples and levels agree, nothing waits in a filter, and lead is 0 or four counts ahead or behind: the encoder
-- has turned a whole cycle that the filters did not see. out_lost tells that, one clock, and lead starts anew.
-- Samples of a and b that change at once are two counts of unknown direction. The next such change takes them back, as
-- at the end of a pulse that comes and goes on both channels; if samples and levels agree before, or a level changes,
-- or lead comes to four, counts are lost.
-- Levels that change at once are left to gc_quad_decoder: lead starts anew.
-- Latency: 1 clock from in_sample, in_level to out_lost.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_count_check is
  port (
    clk       : in    std_ulogic;
    rst       : in    std_ulogic;
    -- levels are known
    in_valid  : in    std_ulogic;
    -- bits b, a: newest sample, and what the filter made of all samples up to it
    in_sample : in    std_ulogic_vector(1 downto 0);
    in_level  : in    std_ulogic_vector(1 downto 0);
    -- counts were lost, one clock
    out_lost  : out   std_ulogic := '0'
  );
end entity gc_count_check;

architecture rtl of gc_count_check is

  -- 0 1 2 3 for (a, b) = 00 10 11 01

  function phase_of (
    b_a : std_ulogic_vector(1 downto 0)
  ) return unsigned is
  begin

    return b_a(1) & (b_a(0) xor b_a(1));

  end function phase_of;

  -- ahead or behind
  constant four_c : signed(2 downto 0) := "100";

  signal sample_1 : unsigned(1 downto 0) := (others => '0');
  signal level_1  : unsigned(1 downto 0) := (others => '0');
  signal lead     : signed(2 downto 0) := (others => '0');
  -- a and b changed at once, and have not changed back: two counts more or less than lead
  signal both     : std_ulogic := '0';

begin

  p_check : process (clk) is

    variable sample_v  : unsigned(1 downto 0);
    variable level_v   : unsigned(1 downto 0);
    variable sampled_v : unsigned(1 downto 0);
    variable passed_v  : unsigned(1 downto 0);
    variable ahead_v   : unsigned(1 downto 0);
    variable lead_v    : signed(2 downto 0);
    variable both_v    : std_ulogic;
    variable lost_v    : std_ulogic;

  begin

    if rising_edge(clk) then
      sample_v := phase_of(in_sample);
      level_v := phase_of(in_level);
      sampled_v := sample_v - sample_1;
      passed_v := level_v - level_1;
      ahead_v := sample_v - level_v;
      lead_v := lead;
      both_v := both;
      lost_v := '0';

      if sampled_v = 1 then
        lead_v := lead_v + 1;
      elsif sampled_v = 3 then
        lead_v := lead_v - 1;
      elsif sampled_v = 2 then
        both_v := not both_v;
      end if;
      if passed_v = 1 then
        lead_v := lead_v - 1;
      elsif passed_v = 3 then
        lead_v := lead_v + 1;
      end if;

      if lead_v = four_c then
        lost_v := '1';
      elsif both_v = '1' and (ahead_v = 0 or passed_v /= 0) then
        lost_v := '1';
      end if;
      if passed_v = 2 or in_valid = '0' then
        lost_v := '0';
      end if;

      if lost_v = '1' or passed_v = 2 or in_valid = '0' then
        both_v := '0';
        lead_v := signed('0' & ahead_v);
        if ahead_v = 3 then
          lead_v := to_signed(-1, 3);
        end if;
      end if;

      sample_1 <= sample_v;
      level_1 <= level_v;
      lead <= lead_v;
      both <= both_v;
      out_lost <= lost_v;

      if rst = '1' then
        lead <= (others => '0');
        both <= '0';
        out_lost <= '0';
      end if;
    end if;

  end process p_check;

end architecture rtl;
