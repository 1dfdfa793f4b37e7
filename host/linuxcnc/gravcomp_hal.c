/* SPDX-License-Identifier: MIT
 *
 * LinuxCNC: a board with gc_serial_system as a userspace HAL component. An example to start from; docs/guide/linuxcnc.md.
 *
 *     loadusr -W gravcomp_hal -n gravcomp /dev/ttyUSB0
 *
 * Nothing but the core's own servo moves the robot. This component says when the brakes may open, and sends targets. It
 * kicks the core's watchdog only while enable is set, heartbeat changes and nothing has failed, so brakes engage by
 * themselves when LinuxCNC, this process or the line stops. Whatever fails, brakes are engaged and stay so until enable
 * has been low.
 */
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <hal.h>
#include <rtapi.h>

#include "gravcomp.h"
#include "gravcomp_machine.h"
#include "gravcomp_modbus.h"
#include "gravcomp_motion.h"

#define AXES GRAVCOMP_MACHINE_AXES
#define ALL_AXES ((1u << AXES) - 1)
#ifndef GRAVCOMP_BAUD
#define GRAVCOMP_BAUD B3000000
#endif
#ifndef ANSWER_MS
#define ANSWER_MS 50 /* of a frame, a USB bridge included */
#endif
#ifndef HEARTBEAT_MS
#define HEARTBEAT_MS 100 /* longest time without a change */
#endif
#define ATTEMPTS 5
#define POLLS 2000u /* each takes a frame at least */

struct axis {
    hal_float_t *target, *position, *effort, *command;
    hal_bit_t *referenced;
    hal_float_t scale; /* counts per m or rad */
};

struct component { /* in HAL's memory; settings and motion are its parameters */
    hal_bit_t *enable, *heartbeat, *home, *move;
    hal_float_t *move_time;
    hal_bit_t *connected, *released, *fault, *ready, *refused;
    hal_u32_t *causes;
    struct axis axis[AXES];
    gravcomp_settings settings;
    gravcomp_motion_settings motion;
};

static struct component *hal;
static gravcomp_line line;
static gravcomp_bus bus;
static gravcomp_identity identity;
static bool has_motion, is_on, has_failed, is_lost, was_beating, was_homing, was_moving;
static int64_t last_beat_ms;
static volatile sig_atomic_t is_over;

static int64_t now_ms(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* ---- the serial port: after a frame that came to nothing, nothing more in this cycle, so that no call waits long ---- */

static void send_bytes(void *context, const uint8_t *bytes, uint32_t n)
{
    int port = *(int *)context;

    if (line.first != GRAVCOMP_LINE_OK) {
        return;
    }
    tcflush(port, TCIFLUSH);
    if (write(port, bytes, n) != (ssize_t)n) {
        rtapi_print_msg(RTAPI_MSG_DBG, "gravcomp: the port takes no frame\n"); /* no answer will come */
    }
}

static uint32_t receive_bytes(void *context, uint8_t *bytes, uint32_t n)
{
    struct pollfd port = {*(int *)context, POLLIN, 0};
    int64_t end = now_ms() + ANSWER_MS;
    uint32_t came = 0;

    while (came < n && line.first == GRAVCOMP_LINE_OK) {
        int64_t left = end - now_ms();

        if (left <= 0 || poll(&port, 1, (int)left) <= 0) {
            break;
        }
        ssize_t part = read(port.fd, bytes + came, n - came);
        if (part <= 0) {
            break;
        }
        came += (uint32_t)part;
    }
    return came;
}

static int open_port(const char *name)
{
    struct termios settings;
    int port = open(name, O_RDWR | O_NOCTTY);

    if (port < 0 || tcgetattr(port, &settings) != 0) {
        return -1;
    }
    cfmakeraw(&settings);
    cfsetspeed(&settings, GRAVCOMP_BAUD);
    settings.c_cflag |= CLOCAL | CREAD;
    return tcsetattr(port, TCSANOW, &settings) == 0 ? port : -1;
}

/* ---- what the robot does ---- */

/* Engage the brakes, whatever becomes of it: without an answer the watchdog engages them. */
static void fail(const char *why)
{
    if (line.first != GRAVCOMP_LINE_OK) {
        is_lost = true;
        why = "the line is lost";
        line.first = GRAVCOMP_LINE_OK;
    }
    gravcomp_stop(&bus);
    if (!has_failed) {
        rtapi_print_msg(RTAPI_MSG_ERR, "gravcomp: %s; brakes are engaged until enable has been low\n", why);
    }
    is_on = false;
    has_failed = true;
}

static bool is_configured(void)
{
    if (gravcomp_configure(&bus, &identity, &hal->settings) != GRAVCOMP_OK) {
        const char *why = gravcomp_complaint(&identity, &hal->settings);

        fail(why != NULL ? why : "the settings are not taken");
        return false;
    }
    if (has_motion) {
        gravcomp_motion_configure(&bus, &identity, &hal->motion);
    }
    return true;
}

static void turn_on(void)
{
    if (!is_configured()) {
        return;
    }
    if (gravcomp_tick(&bus, true) != GRAVCOMP_OK || gravcomp_release(&bus, POLLS) != GRAVCOMP_OK) {
        fail("the brakes are not released, see causes");
        return;
    }
    is_on = true;
}

/* Every axis is referenced once somebody moves it over its index by hand. */
static void begin_homing(void)
{
    if (is_on || !is_configured()) {
        return;
    }
    if (gravcomp_home(&bus, ALL_AXES) != GRAVCOMP_OK || gravcomp_tick(&bus, true) != GRAVCOMP_OK) {
        fail("the core's clock stands still");
    }
}

static void begin_move(void)
{
    int32_t target[GRAVCOMP_MAX_AXES] = {0};
    double ticks = *hal->move_time * 1e6 / hal->settings.tick_us;

    for (int i = 0; i < AXES; i++) {
        double counts = *hal->axis[i].target * hal->axis[i].scale;

        if (!(fabs(counts) < INT32_MAX)) { /* and not for a NaN */
            *hal->refused = true;
            return;
        }
        target[i] = (int32_t)lrint(counts);
    }
    if (!(ticks >= 0 && ticks < UINT32_MAX)) {
        *hal->refused = true;
        return;
    }
    gravcomp_result result = gravcomp_move(&bus, &identity, target, (uint32_t)ticks, POLLS);
    *hal->refused = result != GRAVCOMP_OK;
    if (result == GRAVCOMP_TIMEOUT) {
        fail("a move is not taken");
    }
}

static bool beats(void)
{
    if (*hal->heartbeat != was_beating) {
        was_beating = *hal->heartbeat;
        last_beat_ms = now_ms();
    }
    return now_ms() - last_beat_ms < HEARTBEAT_MS;
}

static void publish(const gravcomp_state *state)
{
    *hal->causes = state->cause | state->fault;
    *hal->released = state->released == ALL_AXES;
    for (int i = 0; i < AXES; i++) {
        struct axis *axis = &hal->axis[i];

        *axis->position = axis->scale != 0 ? state->position_now[i] / axis->scale : 0;
        *axis->effort = state->force_mn[i] / 1e3;
        *axis->command = state->command_ua[i] / 1e6;
        *axis->referenced = state->referenced >> i & 1;
    }
    *hal->ready = false;
    if (has_motion && is_on) {
        gravcomp_motion_state motion;

        gravcomp_motion_read(&bus, &identity, &motion);
        *hal->ready = motion.ready;
    }
}

static void follow_pins(bool is_alive)
{
    if (!*hal->enable) {
        has_failed = false;
        if (is_on) {
            gravcomp_stop(&bus);
            is_on = false;
        }
    }
    if (is_on && !is_alive) {
        fail("the heartbeat stands still");
    }
    if (*hal->enable && is_alive && !is_on && !has_failed) {
        turn_on();
    }
    if (*hal->home && !was_homing) {
        begin_homing();
    }
    was_homing = *hal->home;
    if (is_on && has_motion && *hal->move && !was_moving) {
        begin_move();
    }
    was_moving = *hal->move;
}

static void cycle(void)
{
    gravcomp_state state;

    is_lost = false;
    line.first = GRAVCOMP_LINE_OK;
    gravcomp_read(&bus, &identity, &state);
    if (line.first == GRAVCOMP_LINE_OK) {
        publish(&state);
        if (is_on && (state.fault != 0 || state.released != ALL_AXES || !gravcomp_core_runs(&bus))) {
            fail("the core engaged the brakes, see causes");
        } else if (has_failed) {
            gravcomp_stop(&bus); /* the one that fail sent may be lost */
        }
        follow_pins(beats());
        if (is_on) {
            gravcomp_kick(&bus);
        }
    }
    if (line.first != GRAVCOMP_LINE_OK) {
        fail("the line is lost");
    }
    *hal->connected = !is_lost;
    *hal->fault = has_failed;
}

/* ---- what HAL sees ---- */

#define AXIS_NUMBERS(x) \
    x(index_period, "index-period") x(margin_counts, "margin-counts") x(speed_max_counts_per_s, "speed-max") \
    x(current_limit_ua, "current-limit-ua") x(current_slew_ua, "current-slew-ua") x(command_bound_ua, "command-bound-ua")
#define NUMBERS(x) \
    x(tick_us, "tick-us") x(saturation_us, "saturation-us") x(watchdog_us, "watchdog-us") x(result_us, "result-us") \
    x(brake_us, "brake-us") x(command_us, "command-us") x(hold_us, "hold-us") x(brake_test_us, "brake-test-us")
#define MOTION_NUMBERS(x) \
    x(servo_proportional, "servo-proportional") x(servo_integral, "servo-integral") \
    x(servo_derivative, "servo-derivative") x(servo_limit_ua, "servo-limit-ua") x(following_max, "following-max") \
    x(speed_max, "setpoint-speed-max") x(acceleration_max, "setpoint-acceleration-max")

static int export_axis(int id, const char *name, int i)
{
    struct axis *axis = &hal->axis[i];
    int bad = 0;

    bad |= hal_pin_float_newf(HAL_IN, &axis->target, id, "%s.%d.target", name, i);
    bad |= hal_pin_float_newf(HAL_OUT, &axis->position, id, "%s.%d.position", name, i);
    bad |= hal_pin_float_newf(HAL_OUT, &axis->effort, id, "%s.%d.effort", name, i);
    bad |= hal_pin_float_newf(HAL_OUT, &axis->command, id, "%s.%d.command", name, i);
    bad |= hal_pin_bit_newf(HAL_OUT, &axis->referenced, id, "%s.%d.referenced", name, i);
    bad |= hal_param_float_newf(HAL_RW, &axis->scale, id, "%s.%d.scale", name, i);
    bad |= hal_param_s32_newf(HAL_RW, &hal->settings.index_position[i], id, "%s.%d.index-position", name, i);
#define EXPORT(field, words) bad |= hal_param_u32_newf(HAL_RW, &hal->settings.field[i], id, "%s.%d." words, name, i);
    AXIS_NUMBERS(EXPORT)
#undef EXPORT
#define EXPORT(field, words) bad |= hal_param_u32_newf(HAL_RW, &hal->motion.field[i], id, "%s.%d." words, name, i);
    MOTION_NUMBERS(EXPORT)
#undef EXPORT
    return bad;
}

static int export_all(int id, const char *name)
{
    int bad = 0;

    bad |= hal_pin_bit_newf(HAL_IN, &hal->enable, id, "%s.enable", name);
    bad |= hal_pin_bit_newf(HAL_IN, &hal->heartbeat, id, "%s.heartbeat", name);
    bad |= hal_pin_bit_newf(HAL_IN, &hal->home, id, "%s.home", name);
    bad |= hal_pin_bit_newf(HAL_IN, &hal->move, id, "%s.move", name);
    bad |= hal_pin_float_newf(HAL_IN, &hal->move_time, id, "%s.move-time", name);
    bad |= hal_pin_bit_newf(HAL_OUT, &hal->connected, id, "%s.connected", name);
    bad |= hal_pin_bit_newf(HAL_OUT, &hal->released, id, "%s.released", name);
    bad |= hal_pin_bit_newf(HAL_OUT, &hal->fault, id, "%s.fault", name);
    bad |= hal_pin_bit_newf(HAL_OUT, &hal->ready, id, "%s.ready", name);
    bad |= hal_pin_bit_newf(HAL_OUT, &hal->refused, id, "%s.refused", name);
    bad |= hal_pin_u32_newf(HAL_OUT, &hal->causes, id, "%s.causes", name);
#define EXPORT(field, words) bad |= hal_param_u32_newf(HAL_RW, &hal->settings.field, id, "%s." words, name);
    NUMBERS(EXPORT)
#undef EXPORT
    bad |= hal_param_u32_newf(HAL_RW, &hal->motion.servo_filter, id, "%s.servo-filter", name);
    bad |= hal_param_u32_newf(HAL_RW, &hal->motion.servo_speed_feed, id, "%s.servo-speed-feed", name);
    for (int i = 0; i < AXES; i++) {
        bad |= export_axis(id, name, i);
    }
    return bad;
}

static void end(int number)
{
    (void)number;
    is_over = 1;
}

static int refuse(const char *what, const char *mend)
{
    fprintf(stderr, "gravcomp_hal: %s; %s\n", what, mend);
    return 2;
}

/* Find the core of this machine; 0 when it is there. */
static int open_core(int *port, const char *name, uint8_t unit)
{
    *port = open_port(name);
    if (*port < 0) {
        return refuse(name, "is no serial port that can be opened; check name, cable and permissions");
    }
    line = (gravcomp_line){.send = send_bytes, .receive = receive_bytes, .context = port, .unit = unit,
                           .attempts = ATTEMPTS};
    if (gravcomp_line_open(&line, &bus) != GRAVCOMP_LINE_OK) {
        return refuse(name, "nothing answers; check power, baud and unit");
    }
    if (gravcomp_open(&bus, &identity) != GRAVCOMP_OK || line.first != GRAVCOMP_LINE_OK) {
        return refuse(name, "no gravcomp core, or another version; build it with this driver's RTL");
    }
    if (identity.axes != AXES || identity.weights_hash[0] != GRAVCOMP_MACHINE_WEIGHTS) {
        return refuse(name, "the core is of another machine; compile with the gravcomp_machine.h of its ROM");
    }
    has_motion = gravcomp_motion_is_there(&bus);
    return 0;
}

int main(int argc, char **argv)
{
    const char *name = "gravcomp";
    int option, port, id, unit = 1;

    while ((option = getopt(argc, argv, "n:u:")) != -1) {
        if (option == 'n') {
            name = optarg;
        } else if (option != 'u' || (unit = atoi(optarg)) < 1 || unit > 247) {
            return refuse("wrong argument", "give [-n NAME] [-u UNIT 1 to 247] PORT");
        }
    }
    if (optind != argc - 1) {
        return refuse("no port", "give [-n NAME] [-u UNIT 1 to 247] PORT");
    }
    signal(SIGINT, end);
    signal(SIGTERM, end);
    if (open_core(&port, argv[optind], (uint8_t)unit) != 0) {
        return 2;
    }
    id = hal_init(name);
    if (id < 0) {
        return refuse(name, "HAL takes no component of this name; see its messages");
    }
    hal = hal_malloc(sizeof *hal);
    if (hal == NULL || (memset(hal, 0, sizeof *hal), export_all(id, name)) != 0) {
        hal_exit(id);
        return refuse(name, "HAL takes not all pins; see its messages");
    }
    hal->settings.axes = AXES;
    hal->settings.clock_hz = GRAVCOMP_MACHINE_CLOCK_HZ;
    hal->settings.expected_weights = GRAVCOMP_MACHINE_WEIGHTS;
    hal_ready(id);
    gravcomp_stop(&bus); /* what a process before this one may have left released */
    while (!is_over) {
        cycle();
        usleep(1000);
    }
    line.first = GRAVCOMP_LINE_OK;
    gravcomp_stop(&bus);
    hal_exit(id);
    return 0;
}
