/* SPDX-License-Identifier: MIT */
#include "gravcomp_modbus.h"

#define READ 0x03u
#define WRITE 0x10u
#define EXCEPTION 0x80u
#define LONGEST 256u
#define EXCEPTION_BYTES 5u
#define WRITTEN_BYTES 8u

static uint16_t crc16(const uint8_t *bytes, uint32_t n)
{
    uint16_t crc = 0xFFFF;

    for (uint32_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (uint16_t)(crc >> 1 ^ (crc & 1 ? 0xA001 : 0));
        }
    }
    return crc;
}

static void put_half(uint8_t *bytes, uint32_t half)
{
    bytes[0] = (uint8_t)(half >> 8);
    bytes[1] = (uint8_t)half;
}

static uint32_t get_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Unit, function, first register and number of registers: six bytes. */
static void put_head(const gravcomp_line *line, uint8_t *frame, uint8_t function, uint32_t offset, uint32_t n)
{
    frame[0] = line->unit;
    frame[1] = function;
    put_half(frame + 2, offset / 2);
    put_half(frame + 4, 2 * n);
}

/* Send a frame of n bytes, to which the CRC comes, and receive its answer of n_answer bytes into it. */
static gravcomp_line_result exchange(gravcomp_line *line, uint8_t *frame, uint32_t n, uint32_t n_answer)
{
    uint8_t function = frame[1];
    uint16_t crc = crc16(frame, n);
    uint32_t got = 0;

    frame[n] = (uint8_t)crc;
    frame[n + 1] = (uint8_t)(crc >> 8);
    line->send(line->context, frame, n + 2);
    got = line->receive(line->context, frame, EXCEPTION_BYTES);
    if (got == 0) {
        return GRAVCOMP_LINE_SILENT;
    }
    if (got == EXCEPTION_BYTES && frame[1] != (function | EXCEPTION)) {
        got += line->receive(line->context, frame + EXCEPTION_BYTES, n_answer - EXCEPTION_BYTES);
    } else {
        n_answer = EXCEPTION_BYTES;
    }
    if (got != n_answer || crc16(frame, n_answer) != 0 || frame[0] != line->unit || (frame[1] & ~EXCEPTION) != function) {
        return GRAVCOMP_LINE_DAMAGED;
    }
    if (frame[1] & EXCEPTION) {
        line->exception = frame[2];
        return GRAVCOMP_LINE_REFUSED;
    }
    return GRAVCOMP_LINE_OK;
}

/* Whether a frame that was answered in this way is to be sent again; worst: what was seen of the line so far. */
static bool is_lost(gravcomp_line_result result, gravcomp_line_result *worst)
{
    if (result != GRAVCOMP_LINE_SILENT && result != GRAVCOMP_LINE_DAMAGED) {
        return false;
    }
    *worst = result > *worst ? result : *worst;
    return true;
}

gravcomp_line_result gravcomp_line_read(gravcomp_line *line, uint32_t offset, uint32_t *words, uint32_t n)
{
    uint8_t frame[LONGEST];
    gravcomp_line_result worst = GRAVCOMP_LINE_SILENT;

    for (uint32_t attempt = 0; attempt < line->attempts; attempt++) {
        gravcomp_line_result result = GRAVCOMP_LINE_OK;

        line->repeated += attempt > 0;
        put_head(line, frame, READ, offset, n);
        result = exchange(line, frame, 6, 5 + 4 * n);
        if (!is_lost(result, &worst)) {
            for (uint32_t i = 0; result == GRAVCOMP_LINE_OK && i < n; i++) {
                words[i] = get_word(frame + 3 + 4 * i);
            }
            return result;
        }
    }
    return worst;
}

static gravcomp_line_result count_written(gravcomp_line *line)
{
    gravcomp_line_result result = gravcomp_line_read(line, GRAVCOMP_MODBUS_WRITTEN, &line->written, 1);

    line->is_counted = result == GRAVCOMP_LINE_OK;
    return result;
}

/* The answer to a write, or, if that is lost, what the port counted since it had counted `before`: all words stand, or
 * none of them, which is as lost as the answer, or some, which is a refusal. */
static gravcomp_line_result write_once(gravcomp_line *line, uint8_t *frame, uint32_t n, uint32_t before)
{
    gravcomp_line_result result = exchange(line, frame, 7 + 4 * n, WRITTEN_BYTES);
    gravcomp_line_result counted = GRAVCOMP_LINE_OK;

    if (result == GRAVCOMP_LINE_OK) {
        line->written = before + n;
        return result;
    }
    counted = count_written(line);
    if (counted != GRAVCOMP_LINE_OK) {
        return counted;
    }
    if (result == GRAVCOMP_LINE_REFUSED || line->written == before) {
        return result;
    }
    if (line->written == before + n) {
        return GRAVCOMP_LINE_OK;
    }
    line->exception = 4;
    return GRAVCOMP_LINE_REFUSED;
}

gravcomp_line_result gravcomp_line_write(gravcomp_line *line, uint32_t offset, const uint32_t *words, uint32_t n)
{
    uint8_t frame[LONGEST];
    uint32_t before = 0;
    gravcomp_line_result worst = line->is_counted ? GRAVCOMP_LINE_OK : count_written(line);

    if (worst != GRAVCOMP_LINE_OK) {
        return worst;
    }
    before = line->written;
    worst = GRAVCOMP_LINE_SILENT;
    for (uint32_t attempt = 0; attempt < line->attempts; attempt++) {
        gravcomp_line_result result = GRAVCOMP_LINE_OK;

        line->repeated += attempt > 0;
        put_head(line, frame, WRITE, offset, n);
        frame[6] = (uint8_t)(4 * n);
        for (uint32_t i = 0; i < n; i++) {
            put_half(frame + 7 + 4 * i, words[i] >> 16);
            put_half(frame + 9 + 4 * i, words[i]);
        }
        result = write_once(line, frame, n, before);
        if (!is_lost(result, &worst) || !line->is_counted) { /* never again what may stand */
            return result;
        }
    }
    return worst;
}

static void note(gravcomp_line *line, gravcomp_line_result result)
{
    if (line->first == GRAVCOMP_LINE_OK) {
        line->first = result;
    }
}

static uint32_t read_register(void *context, uint32_t offset)
{
    uint32_t word = 0;

    note(context, gravcomp_line_read(context, offset, &word, 1));
    return word;
}

static void write_register(void *context, uint32_t offset, uint32_t word)
{
    note(context, gravcomp_line_write(context, offset, &word, 1));
}

gravcomp_line_result gravcomp_line_open(gravcomp_line *line, gravcomp_bus *bus)
{
    bus->read = read_register;
    bus->write = write_register;
    bus->context = line;
    return count_written(line);
}
