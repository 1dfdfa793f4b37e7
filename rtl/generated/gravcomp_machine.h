/* SPDX-License-Identifier: MIT
 *
 * Written by `make rom` from weights/spheiro. Do not edit.
 */
#ifndef GRAVCOMP_MACHINE_H
#define GRAVCOMP_MACHINE_H

#define GRAVCOMP_MACHINE_AXES 3
#define GRAVCOMP_MACHINE_CLOCK_HZ 40000000u
#define GRAVCOMP_MACHINE_WEIGHTS 0xcfaace90u /* first word of weights_hash */

#endif
