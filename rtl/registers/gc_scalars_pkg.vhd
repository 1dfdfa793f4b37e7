-- SPDX-License-Identifier: MIT
--
-- What is not in a table; axis 1 lowest. Written by `make regs` from facts.toml; do not edit.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

package gc_scalars_pkg is

  type scalars_t is record
    count_low     : signed(inputs_c * count_bits_c - 1 downto 0);
    count_high    : signed(inputs_c * count_bits_c - 1 downto 0);
    input_scale   : signed(inputs_c * operand_bits_c - 1 downto 0);
    x_low         : signed(features_c * operand_bits_c - 1 downto 0);
    x_high        : signed(features_c * operand_bits_c - 1 downto 0);
    output_bias   : signed(outputs_c * output_sum_bits_c - 1 downto 0);
    output_scale  : signed(outputs_c * operand_bits_c - 1 downto 0);
    current_scale : signed(outputs_c * operand_bits_c - 1 downto 0);
    phase_step    : signed(outputs_c * phase_step_bits_c - 1 downto 0);
  end record scalars_t;

  constant scalar_bits_c : positive :=
    inputs_c * count_bits_c
    + inputs_c * count_bits_c
    + inputs_c * operand_bits_c
    + features_c * operand_bits_c
    + features_c * operand_bits_c
    + outputs_c * output_sum_bits_c
    + outputs_c * operand_bits_c
    + outputs_c * operand_bits_c
    + outputs_c * phase_step_bits_c;

  constant rom_scalars_c : scalars_t := (
    count_low     => flat(count_low_c),
    count_high    => flat(count_high_c),
    input_scale   => input_scale_c,
    x_low         => x_low_c,
    x_high        => x_high_c,
    output_bias   => output_bias_c,
    output_scale  => output_scale_c,
    current_scale => current_scale_c,
    phase_step    => flat(phase_step_c)
  );

  -- The scalars of their record, fields from bit 0 upwards.
  function scalars_of (
    bits : std_ulogic_vector(scalar_bits_c - 1 downto 0)
  ) return scalars_t;

end package gc_scalars_pkg;

package body gc_scalars_pkg is

  function scalars_of (
    bits : std_ulogic_vector(scalar_bits_c - 1 downto 0)
  ) return scalars_t is

    variable scalars_v : scalars_t;
    variable low_v     : natural := 0;

    -- The next field.
    procedure take (
      variable field_v : out signed
    ) is
    begin
      field_v := signed(bits(low_v + field_v'length - 1 downto low_v));
      low_v := low_v + field_v'length;
    end procedure take;

  begin
    take(scalars_v.count_low);
    take(scalars_v.count_high);
    take(scalars_v.input_scale);
    take(scalars_v.x_low);
    take(scalars_v.x_high);
    take(scalars_v.output_bias);
    take(scalars_v.output_scale);
    take(scalars_v.current_scale);
    take(scalars_v.phase_step);
    return scalars_v;
  end function scalars_of;

end package body gc_scalars_pkg;
