/* SPDX-License-Identifier: MIT */
#include "gravcomp_motion.h"

#include <stddef.h>

#include "gravcomp_motion_registers.h"
#include "gravcomp_registers.h"

#define OFFSET(name) ((uint32_t)offsetof(gc_motion_registers_t, name))
#define FIELD(word, name) (((word) & GC_MOTION_REGISTERS__##name##_bm) >> GC_MOTION_REGISTERS__##name##_bp)

static uint32_t read_word(const gravcomp_bus *bus, uint32_t offset)
{
    return bus->read(bus->context, offset);
}

static void write_word(const gravcomp_bus *bus, uint32_t offset, uint32_t word)
{
    bus->write(bus->context, offset, word);
}

static void write_axes(const gravcomp_bus *bus, const gravcomp_identity *identity, uint32_t offset,
                       const uint32_t *words)
{
    for (uint32_t i = 0; i < identity->axes; i++) {
        write_word(bus, offset + 4 * i, words[i]);
    }
}

/* Two's complement, without a conversion that C leaves to the compiler. */
static int32_t to_signed(uint32_t word)
{
    return word <= INT32_MAX ? (int32_t)word : -(int32_t)~word - 1;
}

bool gravcomp_motion_is_there(const gravcomp_bus *bus)
{
    uint32_t word = read_word(bus, (uint32_t)offsetof(gc_registers_t, encoder_geometry));

    return (word & GC_REGISTERS__ENCODER_GEOMETRY__MOTION_bm) != 0;
}

void gravcomp_motion_configure(const gravcomp_bus *bus, const gravcomp_identity *identity,
                               const gravcomp_motion_settings *settings)
{
    uint32_t speed_feed = settings->servo_speed_feed << GC_MOTION_REGISTERS__SERVO_FILTER__SPEED_FEED_bp;

    write_word(bus, OFFSET(servo_filter), settings->servo_filter | speed_feed);
    write_axes(bus, identity, OFFSET(servo_proportional), settings->servo_proportional);
    write_axes(bus, identity, OFFSET(servo_integral), settings->servo_integral);
    write_axes(bus, identity, OFFSET(servo_derivative), settings->servo_derivative);
    write_axes(bus, identity, OFFSET(servo_limit_ua), settings->servo_limit_ua);
    write_axes(bus, identity, OFFSET(following_max), settings->following_max);
    write_axes(bus, identity, OFFSET(speed_max), settings->speed_max);
    write_axes(bus, identity, OFFSET(acceleration_max), settings->acceleration_max);
}

gravcomp_result gravcomp_move(const gravcomp_bus *bus, const gravcomp_identity *identity, const int32_t *target,
                              uint32_t ticks, uint32_t polls)
{
    uint32_t due = (FIELD(read_word(bus, OFFSET(motion_status)), MOTION_STATUS__MOVES) + 1) % 256;

    for (uint32_t i = 0; i < identity->axes; i++) {
        write_word(bus, OFFSET(move_target) + 4 * i, (uint32_t)target[i]);
    }
    write_word(bus, OFFSET(move_ticks), ticks);
    write_word(bus, OFFSET(motion_command), GC_MOTION_REGISTERS__MOTION_COMMAND__MOVE_bm);
    for (uint32_t i = 0; i < polls; i++) {
        uint32_t status = read_word(bus, OFFSET(motion_status));

        if (FIELD(status, MOTION_STATUS__MOVES) == due) {
            return FIELD(status, MOTION_STATUS__REFUSED) ? GRAVCOMP_REFUSED : GRAVCOMP_OK;
        }
    }
    return GRAVCOMP_TIMEOUT;
}

void gravcomp_motion_read(const gravcomp_bus *bus, const gravcomp_identity *identity, gravcomp_motion_state *state)
{
    uint32_t status = read_word(bus, OFFSET(motion_status)); /* freezes the rest */

    state->moves = (uint8_t)FIELD(status, MOTION_STATUS__MOVES);
    state->ready = (uint8_t)FIELD(status, MOTION_STATUS__READY);
    state->refused = (uint8_t)FIELD(status, MOTION_STATUS__REFUSED);
    state->following = (uint8_t)FIELD(status, MOTION_STATUS__FOLLOWING);
    for (uint32_t i = 0; i < identity->axes; i++) {
        state->setpoint[i] = to_signed(read_word(bus, OFFSET(setpoint) + 4 * i));
    }
    for (uint32_t i = 0; i < identity->axes; i++) {
        state->correction_ua[i] = to_signed(read_word(bus, OFFSET(correction_ua) + 4 * i));
    }
}

/* Whether the core has that mode, within so many polls. */
static bool records(const gravcomp_bus *bus, gravcomp_record_mode mode, uint32_t polls)
{
    for (uint32_t i = 0; i < polls; i++) {
        if (FIELD(read_word(bus, OFFSET(record_status)), RECORD_STATUS__MODE) == (uint32_t)mode) {
            return true;
        }
    }
    return false;
}

gravcomp_result gravcomp_record(const gravcomp_bus *bus, gravcomp_record_mode mode, bool mean, uint32_t ticks,
                                uint32_t before, uint32_t polls, uint32_t *taken)
{
    uint32_t control = (uint32_t)mode << GC_MOTION_REGISTERS__RECORD_CONTROL__MODE_bp
                       | (uint32_t)mean << GC_MOTION_REGISTERS__RECORD_CONTROL__MEAN_bp
                       | ticks << GC_MOTION_REGISTERS__RECORD_CONTROL__TICKS_bp;

    write_word(bus, OFFSET(record_control), 0);
    if (!records(bus, GRAVCOMP_RECORD_OFF, polls)) {
        return GRAVCOMP_TIMEOUT;
    }
    *taken = 0;
    if (mode == GRAVCOMP_RECORD_OFF) {
        return GRAVCOMP_OK;
    }
    write_word(bus, OFFSET(record_taken), 0);
    write_word(bus, OFFSET(record_before), before);
    write_word(bus, OFFSET(record_control), control);
    return records(bus, mode, polls) ? GRAVCOMP_OK : GRAVCOMP_TIMEOUT;
}

void gravcomp_record_read_status(const gravcomp_bus *bus, gravcomp_record_status *status)
{
    uint32_t word = read_word(bus, OFFSET(record_status));

    status->mode = FIELD(word, RECORD_STATUS__MODE);
    status->triggered = FIELD(word, RECORD_STATUS__TRIGGERED);
    status->done = FIELD(word, RECORD_STATUS__DONE);
    status->count = read_word(bus, OFFSET(record_count));
    status->lost = read_word(bus, OFFSET(record_lost));
}

uint32_t gravcomp_take_records(const gravcomp_bus *bus, const gravcomp_identity *identity, uint32_t *taken,
                               uint32_t *words, uint32_t most)
{
    uint32_t size = 2u + 5u * identity->axes;
    uint32_t n = 0;
    gravcomp_record_status status;

    gravcomp_record_read_status(bus, &status);
    if (status.mode == GRAVCOMP_RECORD_FAULT && !status.triggered) {
        return 0;
    }
    most = status.count - *taken < most ? status.count - *taken : most;
    while (n < most) {
        uint32_t at_once = GRAVCOMP_RECORD_WINDOW / size < most - n ? GRAVCOMP_RECORD_WINDOW / size : most - n;

        for (uint32_t i = 0; i < at_once * size; i++) {
            words[n * size + i] = read_word(bus, OFFSET(record_word) + 4 * i);
        }
        n += at_once;
        *taken += at_once;
        write_word(bus, OFFSET(record_taken), *taken);
    }
    return n;
}
