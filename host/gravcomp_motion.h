/* SPDX-License-Identifier: MIT
 *
 * Driver of gc_motion, setpoints, servo and recorder, for cores that have it: beside gravcomp.h, whose words hold here.
 */
#ifndef GRAVCOMP_MOTION_H
#define GRAVCOMP_MOTION_H

#include "gravcomp.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What becomes of a record that finds the ring full: it is lost and counted; recording ends; until a fault the oldest gives
 * way, then recording ends. */
typedef enum {
    GRAVCOMP_RECORD_OFF,
    GRAVCOMP_RECORD_FREE,
    GRAVCOMP_RECORD_SINGLE,
    GRAVCOMP_RECORD_FAULT
} gravcomp_record_mode;

/* In the units of the registers, docs/guide/motion.md. */
typedef struct {
    uint32_t servo_filter;                             /* ticks of the derivative's low-pass, as a power of two */
    uint32_t servo_speed_feed;                         /* 1: the setpoint's speed is fed forward, 0: it is not */
    uint32_t servo_proportional[GRAVCOMP_MAX_AXES];    /* 2^-12 uA per count */
    uint32_t servo_integral[GRAVCOMP_MAX_AXES];        /* 2^-20 uA per count and tick */
    uint32_t servo_derivative[GRAVCOMP_MAX_AXES];      /* 2^-8 uA per count of lag */
    uint32_t servo_limit_ua[GRAVCOMP_MAX_AXES];        /* largest correction, below 2^31 */
    uint32_t following_max[GRAVCOMP_MAX_AXES];         /* counts, largest distance from the setpoint that is no fault */
    uint32_t speed_max[GRAVCOMP_MAX_AXES];             /* of a setpoint, 2^-16 counts per tick */
    uint32_t acceleration_max[GRAVCOMP_MAX_AXES];      /* 2^-24 counts per tick^2 */
} gravcomp_motion_settings;

/* All of one clock. */
typedef struct {
    uint8_t moves;                                     /* commands to move that came, modulo 256 */
    uint8_t ready;                                     /* brakes released and no move under way */
    uint8_t refused;                                   /* the last command was not followed */
    uint8_t following;                                 /* axes further than following_max from their setpoint */
    int32_t setpoint[GRAVCOMP_MAX_AXES];               /* counts */
    int32_t correction_ua[GRAVCOMP_MAX_AXES];          /* of the servo */
} gravcomp_motion_state;

typedef struct {
    uint32_t mode;                                     /* a gravcomp_record_mode, as the core has it */
    uint32_t triggered;                                /* the fault came */
    uint32_t done;                                     /* recording has ended */
    uint32_t count;                                    /* whole records since it began */
    uint32_t lost;                                     /* records that found no room */
} gravcomp_record_status;

/* Whether the core has gc_motion; nothing below may be called without. */
bool gravcomp_motion_is_there(const gravcomp_bus *bus);

/* Write gains and limits. */
void gravcomp_motion_configure(const gravcomp_bus *bus, const gravcomp_identity *identity,
                               const gravcomp_motion_settings *settings);

/* Move to a target, counts, in so many ticks or, for the limits, more; returns once the core has the command, reading at
 * most `polls` times. GRAVCOMP_REFUSED when a move is under way or the brakes are not released. The move ends with
 * gravcomp_motion_state.ready; refused beside it: a limit is zero, and nothing moved. Kick the watchdog meanwhile. */
gravcomp_result gravcomp_move(const gravcomp_bus *bus, const gravcomp_identity *identity, const int32_t *target,
                              uint32_t ticks, uint32_t polls);

void gravcomp_motion_read(const gravcomp_bus *bus, const gravcomp_identity *identity, gravcomp_motion_state *state);

/* Record anew: a record per 2^ticks ticks, or their mean; before: records of GRAVCOMP_RECORD_FAULT that come before the
 * fault. What was recorded and not taken is gone. *taken becomes 0. */
gravcomp_result gravcomp_record(const gravcomp_bus *bus, gravcomp_record_mode mode, bool mean, uint32_t ticks,
                                uint32_t before, uint32_t polls, uint32_t *taken);

void gravcomp_record_read_status(const gravcomp_bus *bus, gravcomp_record_status *status);

/* Take whole records of 2 + 5 axes words, `most` of them at most, the oldest first; returns how many. *taken is that of
 * gravcomp_record. None while a fault is waited for. */
uint32_t gravcomp_take_records(const gravcomp_bus *bus, const gravcomp_identity *identity, uint32_t *taken,
                               uint32_t *words, uint32_t most);

#ifdef __cplusplus
}
#endif

#endif
