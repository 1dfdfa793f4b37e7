/* SPDX-License-Identifier: MIT
 *
 * Written by `make regs` from rtl/registers/facts.toml and gc_registers.rdl; do not edit.
 */
#ifndef GRAVCOMP_FACTS_H
#define GRAVCOMP_FACTS_H

#define GRAVCOMP_MAX_AXES 8

/* States of the brakes. */
typedef enum {
    GRAVCOMP_BRAKED = 0,
    GRAVCOMP_HOLDING = 3,
    GRAVCOMP_RUN = 5,
    GRAVCOMP_FAULTED = 6
} gravcomp_brakes;

/* Interrupts, to be combined. */
#define GRAVCOMP_ON_RESULT 1u
#define GRAVCOMP_ON_FAULT 2u
#define GRAVCOMP_ON_MISSED_TICK 4u
#define GRAVCOMP_ON_CORE_STOPPED 8u

/* Loading: the key, and words from kick to kick. */
#define GRAVCOMP_LOAD_KEY 0x4B455953u
#define GRAVCOMP_WORDS_PER_KICK 64u

/* Words of records that can be read at once, from record_word on. */
#define GRAVCOMP_RECORD_WINDOW 64u

#endif
