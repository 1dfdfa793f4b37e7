/* SPDX-License-Identifier: MIT
 *
 * Load an image of `gravcomp image`, home the robot, release its brakes, print positions in counts, efforts in N or Nm
 * and currents of a number of results.
 *
 * On a processor with the registers at BASE:   example FILE, or without a file for the weights of the ROM.
 * gravcomp_machine.h is written by `make rom` beside the ROM (rtl/generated).
 */
#include <stdio.h>

#include "gravcomp.h"
#include "gravcomp_machine.h"

#ifdef BASE
static uint32_t read_memory(void *context, uint32_t offset)
{
    return *(volatile uint32_t *)((uintptr_t)context + offset);
}

static void write_memory(void *context, uint32_t offset, uint32_t word)
{
    *(volatile uint32_t *)((uintptr_t)context + offset) = word;
}

const gravcomp_bus memory_bus = {read_memory, write_memory, (void *)BASE};
#endif

#define POLLS 100000u

#ifndef TICK_US
#define TICK_US 100
#endif

#define ALL_AXES ((1u << GRAVCOMP_MACHINE_AXES) - 1)

static void print_state(const gravcomp_state *state)
{
    printf("%6lu", (unsigned long)state->result_number);
    for (int i = 0; i < GRAVCOMP_MACHINE_AXES; i++) {
        printf("  q%d %8ld %8.3f %8.4f A", i + 1, (long)state->position[i], state->force_mn[i] / 1e3,
               state->command_ua[i] / 1e6);
    }
    printf("\n");
}

static int fail(const gravcomp_bus *bus, const gravcomp_identity *identity, const char *what)
{
    gravcomp_state state;

    gravcomp_read(bus, identity, &state);
    printf("%s: causes 0x%03lx, faults 0x%03lx, first 0x%03lx\n", what, (unsigned long)state.cause,
           (unsigned long)state.fault, (unsigned long)state.first_cause);
    return 1;
}

/* n_words = 0: without an image. */
int run_example(const gravcomp_bus *bus, const uint8_t *image, uint32_t n_words, int n_results)
{
    gravcomp_identity identity;
    gravcomp_settings settings = {
        .axes = GRAVCOMP_MACHINE_AXES,
        .clock_hz = GRAVCOMP_MACHINE_CLOCK_HZ,
        .expected_weights = GRAVCOMP_MACHINE_WEIGHTS,
        .tick_us = TICK_US,
        .saturation_us = 10000,
        .watchdog_us = 20000,
        .result_us = 1000,
        .brake_us = 50,
        .command_us = 5000,
        .hold_us = 10000,
    };
    gravcomp_state state = {0};

    for (int i = 0; i < GRAVCOMP_MACHINE_AXES; i++) { /* all alike here, index at 0 */
        settings.margin_counts[i] = 2000;
        settings.speed_max_counts_per_s[i] = 500000;
        settings.current_limit_ua[i] = 4000000;
        settings.current_slew_ua[i] = 500000;
        settings.command_bound_ua[i] = 100000;
    }
    if (gravcomp_open(bus, &identity) != GRAVCOMP_OK) {
        printf("no gravcomp core, or another version\n");
        return 1;
    }
    printf("%u neurons, %u per clock, %lu Hz, weights %08lx\n", (unsigned)identity.hidden, (unsigned)identity.lanes,
           (unsigned long)identity.clock_hz, (unsigned long)identity.weights_hash[0]);
    if (gravcomp_configure(bus, &identity, &settings) != GRAVCOMP_OK) {
        printf("%s\n", gravcomp_complaint(&identity, &settings));
        return 1;
    }
    if (n_words > 0) {
        uint32_t crc = gravcomp_crc32(image, n_words); /* better: the one that you have tested */

        if (gravcomp_load(bus, image, n_words, crc, POLLS) != GRAVCOMP_OK) {
            return fail(bus, &identity, "the image is not taken");
        }
        printf("image of %lu words, CRC-32 %08lx\n", (unsigned long)n_words, (unsigned long)gravcomp_bank_crc(bus));
    }
    if (gravcomp_home(bus, ALL_AXES) != GRAVCOMP_OK || gravcomp_tick(bus, true) != GRAVCOMP_OK) {
        return fail(bus, &identity, "the core's clock stands still");
    }
    for (uint32_t i = 0; i < POLLS && state.referenced != ALL_AXES; i++) { /* move every axis over its index by hand */
        gravcomp_read(bus, &identity, &state);
    }
    if (gravcomp_release(bus, POLLS) != GRAVCOMP_OK) {
        return fail(bus, &identity, "brakes are not released");
    }
    for (int i = 0; i < n_results; i++) {
        gravcomp_read(bus, &identity, &state);
        print_state(&state);
        gravcomp_kick(bus);
        if (gravcomp_wait(bus, state.result_number, POLLS) != GRAVCOMP_OK) {
            return fail(bus, &identity, "no result");
        }
    }
    return gravcomp_stop(bus) == GRAVCOMP_OK ? 0 : 1;
}

#ifdef BASE
#define MOST_WORDS 16384

int main(int argc, char **argv)
{
    static uint8_t image[4 * MOST_WORDS];
    size_t n_bytes = 0;

    if (argc > 1) {
        FILE *file = fopen(argv[1], "rb");

        if (file == NULL) {
            printf("%s: cannot be read\n", argv[1]);
            return 1;
        }
        n_bytes = fread(image, 1, sizeof image, file);
        fclose(file);
    }
    return run_example(&memory_bus, image, (uint32_t)(n_bytes / 4), 100);
}
#endif
