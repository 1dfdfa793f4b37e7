/* SPDX-License-Identifier: MIT
 *
 * The machine folder spheiro. Written by `make rom`.
 */
#ifndef GRAVCOMP_MACHINE_H
#define GRAVCOMP_MACHINE_H

#define GRAVCOMP_MACHINE_CLOCK_HZ 40000000u
#define GRAVCOMP_MACHINE_WEIGHTS 0xcfaace90u /* first word of weights_hash */

#endif
