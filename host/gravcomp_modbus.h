/* SPDX-License-Identifier: MIT
 *
 * The registers of gc_serial_system over its serial line: a Modbus RTU master that serves as a gravcomp_bus. C99, no calls
 * of an operating system: the caller sends and receives.
 *
 * A frame without an answer is sent again: a read as it is, a write only if the port, which counts the words that it
 * wrote, did not count it. So every word is written once, however many answers are lost.
 */
#ifndef GRAVCOMP_MODBUS_H
#define GRAVCOMP_MODBUS_H

#include "gravcomp.h"

#ifdef __cplusplus
extern "C" {
#endif

#define GRAVCOMP_MODBUS_MOST_READ 62u    /* words of a frame */
#define GRAVCOMP_MODBUS_MOST_WRITTEN 61u

/* The port's own registers, byte offsets. */
#define GRAVCOMP_MODBUS_ANSWERED 0x1000u   /* frames */
#define GRAVCOMP_MODBUS_DROPPED 0x1004u    /* frames */
#define GRAVCOMP_MODBUS_WRITTEN 0x1008u    /* words */
#define GRAVCOMP_MODBUS_EXCEPTIONS 0x100Cu /* sent */

typedef enum {
    GRAVCOMP_LINE_OK,
    GRAVCOMP_LINE_SILENT,  /* no answer: cable, power, or baud, parity and unit other than those of the core */
    GRAVCOMP_LINE_DAMAGED, /* answers came, all of them damaged: noise */
    GRAVCOMP_LINE_REFUSED  /* an exception, see gravcomp_line.exception: words before it stand */
} gravcomp_line_result;

/* Fill in the first five, and the rest with zero. */
typedef struct {
    /* Forget what was received, then send n bytes in one piece. */
    void (*send)(void *context, const uint8_t *bytes, uint32_t n);
    /* Receive n bytes; returns how many came in the time of an answer. */
    uint32_t (*receive)(void *context, uint8_t *bytes, uint32_t n);
    void *context;
    uint8_t unit;
    uint32_t attempts;          /* how often a frame is sent until it is given up; 5 will do */
    gravcomp_line_result first; /* what went wrong first in the calls of the bus; clear it with GRAVCOMP_LINE_OK */
    uint8_t exception;          /* the last one: 1 to 4 */
    uint32_t repeated;          /* frames sent again */
    uint32_t written;           /* words that the port has counted ... */
    bool is_counted;            /* ... unless a write ended without an answer and a count */
} gravcomp_line;

/* Find the port, and make a bus of the line. A register that cannot be read over this bus reads as 0, and first says so. */
gravcomp_line_result gravcomp_line_open(gravcomp_line *line, gravcomp_bus *bus);

/* n words from a byte offset on, GRAVCOMP_MODBUS_MOST_READ at most. */
gravcomp_line_result gravcomp_line_read(gravcomp_line *line, uint32_t offset, uint32_t *words, uint32_t n);

/* n words from a byte offset on, GRAVCOMP_MODBUS_MOST_WRITTEN at most; those before one that is refused are written. */
gravcomp_line_result gravcomp_line_write(gravcomp_line *line, uint32_t offset, const uint32_t *words, uint32_t n);

#ifdef __cplusplus
}
#endif

#endif
