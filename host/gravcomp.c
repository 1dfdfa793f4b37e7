/* SPDX-License-Identifier: MIT */
#include "gravcomp.h"

#include <stddef.h>

#include "gravcomp_registers.h"

#define OFFSET(name) ((uint32_t)offsetof(gc_registers_t, name))
#define FIELD(word, name) (((word) & GC_REGISTERS__##name##_bm) >> GC_REGISTERS__##name##_bp)
#define AXES(word, name) ((uint8_t)FIELD(word, name))

static uint32_t read_word(const gravcomp_bus *bus, uint32_t offset)
{
    return bus->read(bus->context, offset);
}

static void write_word(const gravcomp_bus *bus, uint32_t offset, uint32_t word)
{
    bus->write(bus->context, offset, word);
}

static void read_words(const gravcomp_bus *bus, uint32_t offset, uint32_t *words, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        words[i] = read_word(bus, offset + 4 * i);
    }
}

/* Two's complement, without a conversion that C leaves to the compiler. */
static int32_t to_signed(uint32_t word)
{
    return word <= INT32_MAX ? (int32_t)word : -(int32_t)~word - 1;
}

static void read_axes(const gravcomp_bus *bus, const gravcomp_identity *identity, uint32_t offset, int32_t *values)
{
    for (uint32_t i = 0; i < identity->axes; i++) {
        values[i] = to_signed(read_word(bus, offset + 4 * i));
    }
}

/* Returns once the core has it, so that no edge is lost on the way; a core without a clock is waited for in vain. */
static gravcomp_result change_control(const gravcomp_bus *bus, uint32_t mask, uint32_t bits)
{
    uint32_t control = (read_word(bus, OFFSET(control)) & ~mask) | bits;

    write_word(bus, OFFSET(control), control);
    for (int i = 0; i < 1000; i++) {
        if (read_word(bus, OFFSET(control_now)) == control) {
            return GRAVCOMP_OK;
        }
    }
    return GRAVCOMP_TIMEOUT;
}

static uint32_t clocks(const gravcomp_identity *identity, uint32_t us)
{
    uint64_t n = (uint64_t)us * identity->clock_hz / 1000000u;

    return n > UINT32_MAX ? UINT32_MAX : (uint32_t)n;
}

/* Clocks per four counts at the speed beyond which the encoder interface loses counts. */
static uint32_t shortest_period(const gravcomp_identity *identity)
{
    return 2 * (identity->filter_samples > 2 ? identity->filter_samples : 2);
}

static uint32_t period_min(const gravcomp_identity *identity, uint32_t counts_per_s)
{
    uint64_t n = counts_per_s ? 4u * (uint64_t)identity->clock_hz / counts_per_s : 0;

    return n > INT32_MAX ? INT32_MAX : (uint32_t)n;
}

gravcomp_result gravcomp_open(const gravcomp_bus *bus, gravcomp_identity *identity)
{
    uint32_t version = 0;
    uint32_t geometry = 0;

    if (read_word(bus, OFFSET(id)) != GC_REGISTERS__ID__VALUE_reset) {
        return GRAVCOMP_NOT_FOUND;
    }
    version = read_word(bus, OFFSET(version));
    geometry = read_word(bus, OFFSET(geometry));
    if (FIELD(version, VERSION__MAJOR) != GC_REGISTERS__VERSION__MAJOR_reset
        || FIELD(version, VERSION__MINOR) != GC_REGISTERS__VERSION__MINOR_reset) {
        return GRAVCOMP_WRONG_VERSION;
    }
    identity->axes = AXES(geometry, GEOMETRY__OUTPUTS);
    if (identity->axes > GRAVCOMP_MAX_AXES) {
        return GRAVCOMP_WRONG_VERSION;
    }
    identity->hidden = (uint8_t)FIELD(geometry, GEOMETRY__HIDDEN);
    identity->lanes = (uint8_t)FIELD(geometry, GEOMETRY__LANES);
    identity->lean = FIELD(geometry, GEOMETRY__LEAN) != 0;
    identity->clock_hz = read_word(bus, OFFSET(clock_hz));
    identity->filter_samples = FIELD(read_word(bus, OFFSET(encoder_geometry)), ENCODER_GEOMETRY__FILTER_SAMPLES);
    read_words(bus, OFFSET(weights_hash), identity->weights_hash, 8);
    read_words(bus, OFFSET(compensation_hash), identity->compensation_hash, 8);
    read_axes(bus, identity, OFFSET(trained_low), identity->trained_low);
    read_axes(bus, identity, OFFSET(trained_high), identity->trained_high);
    return GRAVCOMP_OK;
}

static bool is_too_fast(const gravcomp_identity *identity, const gravcomp_settings *settings)
{
    for (uint32_t i = 0; i < identity->axes; i++) {
        uint32_t speed = settings->speed_max_counts_per_s[i];

        if (speed > 0 && period_min(identity, speed) <= shortest_period(identity)) {
            return true;
        }
    }
    return false;
}

static bool is_bad_period(const gravcomp_identity *identity, const gravcomp_settings *settings)
{
    for (uint32_t i = 0; i < identity->axes; i++) {
        if (settings->index_period[i] % 4) {
            return true;
        }
    }
    return false;
}

/* Of the currents of an axis, a line or NULL. */
static const char *current_complaint(const gravcomp_settings *settings, uint32_t axis)
{
    if (settings->current_limit_ua[axis] > INT32_MAX) {
        return "current_limit_ua: above 2147483647";
    }
    if (settings->current_slew_ua[axis] > INT32_MAX) {
        return "current_slew_ua: above 2147483647";
    }
    if (settings->command_bound_ua[axis] > INT32_MAX) {
        return "command_bound_ua: above 2147483647";
    }
    if (settings->current_limit_ua[axis] == 0) {
        return "current_limit_ua: 0 carries no load";
    }
    if (settings->current_slew_ua[axis] == 0) {
        return "current_slew_ua: 0 never reaches current_limit_ua";
    }
    return NULL;
}

/* Results from zero to current_limit_ua, of the axis that takes most, and one more. */
static uint64_t results_of_ramp(const gravcomp_identity *identity, const gravcomp_settings *settings)
{
    uint64_t most = 0;

    for (uint32_t i = 0; i < identity->axes; i++) {
        uint64_t slew = settings->current_slew_ua[i];
        uint64_t results = (settings->current_limit_ua[i] + slew - 1) / slew + 1;

        most = results > most ? results : most;
    }
    return most;
}

const char *gravcomp_complaint(const gravcomp_identity *identity, const gravcomp_settings *settings)
{
    uint64_t ramp = 0;
    uint64_t test = clocks(identity, settings->brake_test_us);

    if (settings->axes != identity->axes) {
        return "axes: not those of the core; give those of the machine folder of its ROM, or build it with your ROM";
    }
    if (settings->clock_hz != identity->clock_hz) {
        return "clock_hz: not that of the core; give that of the machine folder of its ROM, or build it with your ROM";
    }
    for (uint32_t i = 0; i < identity->axes; i++) {
        const char *line = current_complaint(settings, i);

        if (line != NULL) {
            return line;
        }
    }
    if (is_too_fast(identity, settings)) {
        return "speed_max_counts_per_s: more than the core can measure with its encoder filter";
    }
    if (is_bad_period(identity, settings)) {
        return "index_period: not a multiple of 4";
    }
    ramp = results_of_ramp(identity, settings) * clocks(identity, settings->tick_us);
    ramp += clocks(identity, settings->brake_us);
    if (test > 0) {
        ramp += 4 * identity->axes * (test + 2) + 1;
    }
    if (ramp > clocks(identity, settings->hold_us)) {
        return "hold_us: shorter than the slew from 0 to current_limit_ua, brake_us and the test of the brakes";
    }
    return NULL;
}

gravcomp_result gravcomp_configure(const gravcomp_bus *bus, const gravcomp_identity *identity,
                                   const gravcomp_settings *settings)
{
    if (settings->axes != identity->axes) {
        return GRAVCOMP_WRONG_AXES;
    }
    if (settings->clock_hz != identity->clock_hz) {
        return GRAVCOMP_WRONG_CLOCK;
    }
    if (is_too_fast(identity, settings)) {
        return GRAVCOMP_TOO_FAST;
    }
    if (is_bad_period(identity, settings)) {
        return GRAVCOMP_BAD_PERIOD;
    }
    if (gravcomp_complaint(identity, settings) != NULL) {
        return GRAVCOMP_UNUSABLE;
    }
    write_word(bus, OFFSET(expected_weights), settings->expected_weights);
    write_word(bus, OFFSET(tick_clocks), clocks(identity, settings->tick_us));
    write_word(bus, OFFSET(saturation_clocks), clocks(identity, settings->saturation_us));
    write_word(bus, OFFSET(watchdog_clocks), clocks(identity, settings->watchdog_us));
    write_word(bus, OFFSET(result_clocks), clocks(identity, settings->result_us));
    write_word(bus, OFFSET(brake_clocks), clocks(identity, settings->brake_us));
    write_word(bus, OFFSET(command_clocks), clocks(identity, settings->command_us));
    write_word(bus, OFFSET(hold_clocks), clocks(identity, settings->hold_us));
    write_word(bus, OFFSET(brake_test_clocks), clocks(identity, settings->brake_test_us));
    for (uint32_t i = 0; i < identity->axes; i++) {
        uint32_t low = (uint32_t)identity->trained_low[i] - settings->margin_counts[i];
        uint32_t high = (uint32_t)identity->trained_high[i] + settings->margin_counts[i];

        write_word(bus, OFFSET(index_position) + 4 * i, (uint32_t)settings->index_position[i]);
        write_word(bus, OFFSET(index_period) + 4 * i, settings->index_period[i]);
        write_word(bus, OFFSET(window_low) + 4 * i, low);
        write_word(bus, OFFSET(window_high) + 4 * i, high);
        write_word(bus, OFFSET(current_limit_ua) + 4 * i, settings->current_limit_ua[i]);
        write_word(bus, OFFSET(current_slew_ua) + 4 * i, settings->current_slew_ua[i]);
        write_word(bus, OFFSET(command_bound_ua) + 4 * i, settings->command_bound_ua[i]);
        write_word(bus, OFFSET(period_min_clocks) + 4 * i, period_min(identity, settings->speed_max_counts_per_s[i]));
    }
    return GRAVCOMP_OK;
}

gravcomp_result gravcomp_home(const gravcomp_bus *bus, uint8_t axes)
{
    uint32_t mask = GC_REGISTERS__CONTROL__HOME_ENABLE_bm;

    if (change_control(bus, mask, 0) != GRAVCOMP_OK) {
        return GRAVCOMP_TIMEOUT;
    }
    return change_control(bus, mask, ((uint32_t)axes << GC_REGISTERS__CONTROL__HOME_ENABLE_bp) & mask);
}

void gravcomp_start(const gravcomp_bus *bus)
{
    write_word(bus, OFFSET(command), GC_REGISTERS__COMMAND__START_bm);
}

gravcomp_result gravcomp_tick(const gravcomp_bus *bus, bool is_on)
{
    uint32_t mask = GC_REGISTERS__CONTROL__TICK_ENABLE_bm;

    return change_control(bus, mask, is_on ? mask : 0);
}

gravcomp_result gravcomp_wait(const gravcomp_bus *bus, uint32_t number, uint32_t polls)
{
    for (uint32_t i = 0; i < polls; i++) {
        if (read_word(bus, OFFSET(result_number)) != number) {
            return GRAVCOMP_OK;
        }
    }
    return GRAVCOMP_TIMEOUT;
}

/* The state of the brakes and the causes present, a kick after each other. */
static gravcomp_brakes poll_brakes(const gravcomp_bus *bus, uint32_t *cause)
{
    uint32_t status = 0;

    gravcomp_kick(bus);
    (void)read_word(bus, OFFSET(result_number)); /* freezes both */
    status = read_word(bus, OFFSET(status));
    *cause = read_word(bus, OFFSET(cause));
    return (gravcomp_brakes)FIELD(status, STATUS__STATE);
}

gravcomp_result gravcomp_release(const gravcomp_bus *bus, uint32_t polls)
{
    uint32_t cause = 0;
    gravcomp_brakes brakes = GRAVCOMP_FAULTED;
    gravcomp_result result = gravcomp_stop(bus);

    while (result == GRAVCOMP_OK && (brakes != GRAVCOMP_BRAKED || cause != 0)) {
        if (polls-- == 0) {
            return cause != 0 ? GRAVCOMP_FAULT : GRAVCOMP_TIMEOUT;
        }
        brakes = poll_brakes(bus, &cause);
        if (brakes == GRAVCOMP_FAULTED && cause == 0) {
            gravcomp_clear_faults(bus, GC_REGISTERS__FAULT__CLEAR_bm);
        }
    }
    if (result == GRAVCOMP_OK) {
        result = change_control(bus, GC_REGISTERS__CONTROL__ENABLE_bm, GC_REGISTERS__CONTROL__ENABLE_bm);
    }
    while (result == GRAVCOMP_OK && brakes != GRAVCOMP_RUN) {
        if (polls-- == 0) {
            return GRAVCOMP_TIMEOUT;
        }
        brakes = poll_brakes(bus, &cause);
        if (brakes == GRAVCOMP_FAULTED) {
            return GRAVCOMP_FAULT;
        }
    }
    return result;
}

gravcomp_result gravcomp_stop(const gravcomp_bus *bus)
{
    return change_control(bus, GC_REGISTERS__CONTROL__ENABLE_bm, 0);
}

void gravcomp_kick(const gravcomp_bus *bus)
{
    write_word(bus, OFFSET(command), GC_REGISTERS__COMMAND__KICK_bm);
}

void gravcomp_clear_faults(const gravcomp_bus *bus, uint32_t faults)
{
    write_word(bus, OFFSET(fault), faults);
}

bool gravcomp_core_runs(const gravcomp_bus *bus)
{
    return FIELD(read_word(bus, OFFSET(guards)), GUARDS__CORE_CLOCK) != 0;
}

uint8_t gravcomp_brakes_fed(const gravcomp_bus *bus)
{
    return (uint8_t)FIELD(read_word(bus, OFFSET(guards)), GUARDS__FEEDBACK);
}

void gravcomp_clear_encoders(const gravcomp_bus *bus)
{
    write_word(bus, OFFSET(command), GC_REGISTERS__COMMAND__CLEAR_ENCODER_bm);
}

static void read_flags(const gravcomp_bus *bus, gravcomp_state *state)
{
    uint32_t status = read_word(bus, OFFSET(status));
    uint32_t result = read_word(bus, OFFSET(result_flags));
    uint32_t command = read_word(bus, OFFSET(command_flags));
    uint32_t encoder = read_word(bus, OFFSET(encoder_flags));
    uint32_t speed = read_word(bus, OFFSET(speed_flags));

    state->brakes = (uint8_t)FIELD(status, STATUS__STATE);
    state->released = AXES(status, STATUS__RELEASED);
    state->run = (uint8_t)FIELD(status, STATUS__RUN);
    state->busy = (uint8_t)FIELD(status, STATUS__BUSY);
    state->clamped = AXES(result, RESULT_FLAGS__CLAMPED);
    state->saturated = AXES(result, RESULT_FLAGS__SATURATED);
    state->limited = AXES(command, COMMAND_FLAGS__LIMITED);
    state->reached = AXES(command, COMMAND_FLAGS__REACHED);
    state->deviates = AXES(command, COMMAND_FLAGS__DEVIATES);
    state->referenced = AXES(encoder, ENCODER_FLAGS__REFERENCED);
    state->illegal = AXES(encoder, ENCODER_FLAGS__ILLEGAL);
    state->glitch = AXES(encoder, ENCODER_FLAGS__GLITCH);
    state->speed_valid = AXES(speed, SPEED_FLAGS__SPEED_VALID);
    state->speed_zero = AXES(speed, SPEED_FLAGS__SPEED_ZERO);
}

void gravcomp_read(const gravcomp_bus *bus, const gravcomp_identity *identity, gravcomp_state *state)
{
    state->result_number = read_word(bus, OFFSET(result_number)); /* freezes the rest */
    state->missed_ticks = read_word(bus, OFFSET(missed_ticks));
    read_flags(bus, state);
    state->cause = read_word(bus, OFFSET(cause));
    state->fault = read_word(bus, OFFSET(fault));
    state->first_cause = read_word(bus, OFFSET(first_cause));
    read_axes(bus, identity, OFFSET(position), state->position);
    read_axes(bus, identity, OFFSET(speed_period), state->speed_period);
    read_axes(bus, identity, OFFSET(force_mn), state->force_mn);
    read_axes(bus, identity, OFFSET(current_ua), state->current_ua);
    read_axes(bus, identity, OFFSET(command_ua), state->command_ua);
    read_axes(bus, identity, OFFSET(position_now), state->position_now);
    read_axes(bus, identity, OFFSET(first_position), state->first_position);
}

uint32_t gravcomp_crc32(const uint8_t *image, uint32_t n_words)
{
    uint32_t crc = UINT32_MAX;

    for (uint32_t i = 0; i < 4 * n_words; i++) {
        crc ^= image[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
        }
    }
    return ~crc;
}

static void send_image(const gravcomp_bus *bus, const uint8_t *image, uint32_t n_words)
{
    write_word(bus, OFFSET(load_command), GC_REGISTERS__LOAD_COMMAND__BEGIN_IMAGE_bm);
    for (uint32_t i = 0; i < n_words; i++) {
        const uint8_t *bytes = image + 4 * i;

        if (i % GRAVCOMP_WORDS_PER_KICK == 0) {
            gravcomp_kick(bus);
        }
        write_word(bus, OFFSET(load_word),
                   (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24);
    }
}

gravcomp_result gravcomp_load(const gravcomp_bus *bus, const uint8_t *image, uint32_t n_words, uint32_t crc,
                              uint32_t polls)
{
    uint32_t status = read_word(bus, OFFSET(load_status));
    uint32_t bank = 0;

    if (!FIELD(status, LOAD_STATUS__LOADABLE)) {
        return GRAVCOMP_NOT_LOADABLE;
    }
    write_word(bus, OFFSET(load_unlock), GRAVCOMP_LOAD_KEY);
    send_image(bus, image, n_words);
    bank = FIELD(read_word(bus, OFFSET(load_status)), LOAD_STATUS__BANK);
    write_word(bus, OFFSET(load_crc), crc);
    write_word(bus, OFFSET(load_command), GC_REGISTERS__LOAD_COMMAND__COMMIT_bm); /* locks, too */
    for (uint32_t i = 0; i < polls; i++) {
        status = read_word(bus, OFFSET(load_status));
        if (FIELD(status, LOAD_STATUS__BANK) != bank) {
            return GRAVCOMP_OK;
        }
        if (FIELD(status, LOAD_STATUS__BAD)) {
            return GRAVCOMP_REFUSED;
        }
    }
    return GRAVCOMP_TIMEOUT;
}

gravcomp_result gravcomp_use_rom(const gravcomp_bus *bus, uint32_t polls)
{
    write_word(bus, OFFSET(load_unlock), GRAVCOMP_LOAD_KEY);
    write_word(bus, OFFSET(load_command), GC_REGISTERS__LOAD_COMMAND__BEGIN_IMAGE_bm); /* forgets a refused image */
    write_word(bus, OFFSET(load_command), GC_REGISTERS__LOAD_COMMAND__USE_ROM_bm);
    write_word(bus, OFFSET(load_unlock), 0);
    for (uint32_t i = 0; i < polls; i++) {
        uint32_t status = read_word(bus, OFFSET(load_status));

        if (!FIELD(status, LOAD_STATUS__BANK) && !FIELD(status, LOAD_STATUS__BAD)) {
            return GRAVCOMP_OK;
        }
    }
    return GRAVCOMP_TIMEOUT;
}

uint32_t gravcomp_bank_crc(const gravcomp_bus *bus)
{
    return read_word(bus, OFFSET(bank_crc));
}

void gravcomp_interrupt_on(const gravcomp_bus *bus, uint32_t events)
{
    write_word(bus, OFFSET(interrupt_enable), events);
}

uint32_t gravcomp_interrupts(const gravcomp_bus *bus)
{
    uint32_t events = read_word(bus, OFFSET(interrupt_status));

    write_word(bus, OFFSET(interrupt_status), events);
    return events;
}
