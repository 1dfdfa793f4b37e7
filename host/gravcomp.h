/* SPDX-License-Identifier: MIT
 *
 * Driver of gc_system: C99, no calls of an operating system, no memory but the caller's.
 *
 * Offsets are bytes from the base of the registers. For cores of 1 to 8 axes: arrays hold axis 1 first, sets of axes have
 * it in bit 0, and what is there for axes that the core lacks is not looked at. Not for use from two threads at once.
 */
#ifndef GRAVCOMP_H
#define GRAVCOMP_H

#include <stdbool.h>
#include <stdint.h>

#include "gravcomp_facts.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Access to one 32-bit register; context is handed through. */
typedef struct {
    uint32_t (*read)(void *context, uint32_t offset);
    void (*write)(void *context, uint32_t offset, uint32_t word);
    void *context;
} gravcomp_bus;

typedef enum {
    GRAVCOMP_OK,
    GRAVCOMP_NOT_FOUND,     /* no gravcomp core at this address */
    GRAVCOMP_WRONG_VERSION, /* registers of another version than this driver's */
    GRAVCOMP_TIMEOUT,       /* not within the polls allowed */
    GRAVCOMP_FAULT,         /* stopped by a fault, see gravcomp_state.fault */
    GRAVCOMP_REFUSED,       /* the core refuses the image, its length or its CRC; or a move */
    GRAVCOMP_NOT_LOADABLE,  /* the core was built without banks */
    GRAVCOMP_TOO_FAST,      /* speed_max_counts_per_s is more than the core can measure with its encoder filter */
    GRAVCOMP_BAD_PERIOD,    /* index_period is not a multiple of 4 */
    GRAVCOMP_UNUSABLE,      /* the brakes could never be released, see gravcomp_complaint */
    GRAVCOMP_WRONG_CLOCK,   /* clock_hz is not that of the core: the ROM is another machine's */
    GRAVCOMP_WRONG_AXES     /* the core has another number of axes than your machine */
} gravcomp_result;

/* What does not change. */
typedef struct {
    uint8_t axes;                                 /* encoders, motors and brakes */
    uint8_t hidden;                               /* neurons */
    uint8_t lanes;                                /* neurons per clock */
    bool lean;                                    /* the network's form: scalings in the weights */
    uint32_t clock_hz;                            /* of the core */
    uint32_t filter_samples;                      /* clocks that a level of an encoder must last */
    uint32_t weights_hash[8];                     /* SHA-256 of the weights, first bytes in word 0 */
    uint32_t compensation_hash[8];                /* SHA-256 of the compensator's constants */
    int32_t trained_low[GRAVCOMP_MAX_AXES];       /* counts */
    int32_t trained_high[GRAVCOMP_MAX_AXES];      /* counts */
} gravcomp_identity;

typedef struct {
    uint32_t axes;                                /* of robot.toml: GRAVCOMP_MACHINE_AXES of `make rom` */
    uint32_t clock_hz;                            /* of robot.toml: GRAVCOMP_MACHINE_CLOCK_HZ */
    uint32_t expected_weights;                    /* first word of the folder's hash: GRAVCOMP_MACHINE_WEIGHTS */
    int32_t index_position[GRAVCOMP_MAX_AXES];    /* counts at the index */
    uint32_t index_period[GRAVCOMP_MAX_AXES];     /* counts from index to index, a multiple of 4; 0: there is one */
    uint32_t margin_counts[GRAVCOMP_MAX_AXES];    /* allowed beyond the trained range */
    uint32_t speed_max_counts_per_s[GRAVCOMP_MAX_AXES]; /* 0: any motion that can be measured is too fast */
    uint32_t current_limit_ua[GRAVCOMP_MAX_AXES];
    uint32_t current_slew_ua[GRAVCOMP_MAX_AXES];  /* per result */
    uint32_t command_bound_ua[GRAVCOMP_MAX_AXES]; /* largest distance of a command from the current asked for ... */
    uint32_t tick_us;
    uint32_t saturation_us;                       /* longest time saturated or clamped */
    uint32_t watchdog_us;                         /* longest time from kick to kick */
    uint32_t result_us;                           /* longest time from result to result */
    uint32_t brake_us;                            /* for a brake to close and for the motors to take the load */
    uint32_t command_us;                          /* ... but for so long, while the brakes are released */
    uint32_t hold_us;                             /* longest time until the motors have taken the load */
    uint32_t brake_test_us;                       /* for the read-back of a brake to follow in its test; 0 without one */
} gravcomp_settings;

/* All of one clock. Causes are bits as in GC_REGISTERS__FAULT__*. */
typedef struct {
    uint32_t result_number;                       /* results since reset */
    uint32_t missed_ticks;                        /* ticks that found an inference under way */
    uint8_t brakes;                               /* a gravcomp_brakes */
    uint8_t released;                             /* axes whose brake is released */
    uint8_t run;                                  /* commands are not forced to zero */
    uint8_t busy;                                 /* an inference is under way */
    uint8_t clamped;                              /* axes: result from a clamped count */
    uint8_t saturated;                            /* axes: force saturated */
    uint8_t limited;                              /* axes: command limited in magnitude */
    uint8_t reached;                              /* axes: command is the whole current asked for */
    uint8_t referenced;                           /* axes: count refers to the index */
    uint8_t illegal;                              /* axes: encoder lost counts */
    uint8_t glitch;                               /* axes: encoder filter dropped a pulse */
    uint8_t speed_valid;                          /* axes: speed is known */
    uint8_t speed_zero;                           /* axes: at rest */
    uint8_t deviates;                             /* axes: command is beyond command_bound_ua */
    int32_t position[GRAVCOMP_MAX_AXES];          /* counts that the result comes from */
    int32_t speed_period[GRAVCOMP_MAX_AXES];      /* clocks per four counts there, negative downwards */
    int32_t force_mn[GRAVCOMP_MAX_AXES];          /* of a rotary axis mNm */
    int32_t current_ua[GRAVCOMP_MAX_AXES];        /* asked for */
    int32_t command_ua[GRAVCOMP_MAX_AXES];        /* as the drives get it */
    int32_t position_now[GRAVCOMP_MAX_AXES];      /* counts */
    uint32_t cause;                               /* present now */
    uint32_t fault;                               /* came, and were not cleared yet */
    uint32_t first_cause;                         /* those that came first; 0 when no fault is left */
    int32_t first_position[GRAVCOMP_MAX_AXES];    /* counts at the first fault */
} gravcomp_state;

/* Check that the core is there and read who it is. */
gravcomp_result gravcomp_open(const gravcomp_bus *bus, gravcomp_identity *identity);

/* Why the brakes could never be released with these settings, in a line; NULL when they can. The slew must take each
 * command from zero to its current_limit_ua, a tick per step and one more, and leave brake_us and four times brake_test_us
 * per axis, within hold_us. */
const char *gravcomp_complaint(const gravcomp_identity *identity, const gravcomp_settings *settings);

/* Write limits and times; those of speed and time become clocks, rounded down. Nothing where it refuses them. */
gravcomp_result gravcomp_configure(const gravcomp_bus *bus, const gravcomp_identity *identity,
                                   const gravcomp_settings *settings);

/* Begin homing of these axes, end it of the others: each is referenced once it passes its index from at least one encoder
   cycle away. */
gravcomp_result gravcomp_home(const gravcomp_bus *bus, uint8_t axes);

/* Start one inference; the tick starts them periodically. */
void gravcomp_start(const gravcomp_bus *bus);
gravcomp_result gravcomp_tick(const gravcomp_bus *bus, bool is_on);

/* Wait until there are more results than number, reading at most `polls` times. */
gravcomp_result gravcomp_wait(const gravcomp_bus *bus, uint32_t number, uint32_t polls);

/* Clear some faults; one whose cause lasts comes back, and with the last of them the brakes may be released again. */
void gravcomp_clear_faults(const gravcomp_bus *bus, uint32_t faults);

/* Clear all faults and release the brakes: needs referenced axes and a running tick. Kicks the watchdog at every poll. */
gravcomp_result gravcomp_release(const gravcomp_bus *bus, uint32_t polls);

/* Engage the brakes; the commands follow when they have closed. */
gravcomp_result gravcomp_stop(const gravcomp_bus *bus);

/* The host is alive. */
void gravcomp_kick(const gravcomp_bus *bus);

/* Whether the core's clock runs. While it does not, what gravcomp_read tells is old; the brakes are engaged. */
bool gravcomp_core_runs(const gravcomp_bus *bus);

/* Axes whose brake is fed by its read-back; 0 if the core was built without. */
uint8_t gravcomp_brakes_fed(const gravcomp_bus *bus);

/* Forget lost counts and glitches. */
void gravcomp_clear_encoders(const gravcomp_bus *bus);

/* Everything as of one clock; never a mixture of two results. */
void gravcomp_read(const gravcomp_bus *bus, const gravcomp_identity *identity, gravcomp_state *state);

/* CRC-32 of an image: the words of `gravcomp image`, low byte first. */
uint32_t gravcomp_crc32(const uint8_t *image, uint32_t n_words);

/* Replace weights, scaling and compensation by those of an image, between two inferences. Whatever goes wrong, the core
 * goes on with those it has; a refused image is a fault that lasts until the next load or gravcomp_use_rom. Kicks the
 * watchdog. The limits of gravcomp_configure stay those of the ROM. */
gravcomp_result gravcomp_load(const gravcomp_bus *bus, const uint8_t *image, uint32_t n_words, uint32_t crc,
                              uint32_t polls);

/* Back to the weights, scaling and compensation of the ROM, between two inferences. */
gravcomp_result gravcomp_use_rom(const gravcomp_bus *bus, uint32_t polls);

/* CRC-32 of the image in use, 0 with the ROM. */
uint32_t gravcomp_bank_crc(const gravcomp_bus *bus);

/* Choose what interrupts; read and clear what did. */
void gravcomp_interrupt_on(const gravcomp_bus *bus, uint32_t events);
uint32_t gravcomp_interrupts(const gravcomp_bus *bus);

#ifdef __cplusplus
}
#endif

#endif
