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
-- Latency: 2 clocks from in_sample, in_level to out_lost.

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
  -- steps of samples and of levels, and how far they are apart
  signal sampled  : unsigned(1 downto 0) := (others => '0');
  signal passed   : unsigned(1 downto 0) := (others => '0');
  signal ahead    : unsigned(1 downto 0) := (others => '0');
  signal valid_1  : std_ulogic := '0';
  signal lead     : signed(2 downto 0) := (others => '0');
  -- a and b changed at once, and have not changed back: two counts more or less than lead
  signal both     : std_ulogic := '0';

begin

  p_check : process (clk) is

    variable lead_v : signed(2 downto 0);
    variable both_v : std_ulogic;
    variable lost_v : std_ulogic;

  begin

    if rising_edge(clk) then
      -- stage 1: what changed
      sample_1 <= phase_of(in_sample);
      level_1 <= phase_of(in_level);
      sampled <= phase_of(in_sample) - sample_1;
      passed <= phase_of(in_level) - level_1;
      ahead <= phase_of(in_sample) - phase_of(in_level);
      valid_1 <= in_valid;

      -- stage 2: what that adds up to
      lead_v := lead;
      both_v := both;
      lost_v := '0';

      if sampled = 1 then
        lead_v := lead_v + 1;
      elsif sampled = 3 then
        lead_v := lead_v - 1;
      elsif sampled = 2 then
        both_v := not both_v;
      end if;
      if passed = 1 then
        lead_v := lead_v - 1;
      elsif passed = 3 then
        lead_v := lead_v + 1;
      end if;

      if lead_v = four_c then
        lost_v := '1';
      elsif both_v = '1' and (ahead = 0 or passed /= 0) then
        lost_v := '1';
      end if;
      if passed = 2 or valid_1 = '0' then
        lost_v := '0';
      end if;

      if lost_v = '1' or passed = 2 or valid_1 = '0' then
        both_v := '0';
        lead_v := signed('0' & ahead);
        if ahead = 3 then
          lead_v := to_signed(-1, 3);
        end if;
      end if;

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
