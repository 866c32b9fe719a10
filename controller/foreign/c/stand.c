/* A standing controller: a spring and a damper hold every joint at its initial angle.
 *
 *     cargo build --release -p biped-c
 *     cc controller/foreign/c/stand.c -o stand -I controller/foreign/c -I messages/include \
 *         -L target/release -lbiped_c -Wl,-rpath,"$PWD/target/release" -lm
 *     biped run stand --controller ./stand
 */
#include "controller.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>

#define STIFFNESS 1000.0 /* [N·m/rad] */
#define DAMPING 40.0     /* [N·m·s/rad] */
#define CUT_OFF 150.0    /* of the low-pass filter of the rates [Hz] */
#define TURN 6.283185307179586

/* One control period. `angle` and `speed` hold the values of the preceding one, except in the first period of a run. */
static int hold(biped_Controller *controller, const biped_Status *robot, int first, double *angle, double *speed) {
    biped_Encoders encoders;
    int result = biped_read(controller, &encoders);
    if (result < 0) return result;
    biped_Torques answer;
    double share = 1.0 - exp(-TURN * CUT_OFF / robot->rate);
    for (int j = 0; j < BIPED_JOINTS; j++) {
        double now = robot->count * (double)encoders.counts[j];
        speed[j] = first ? 0.0 : speed[j] + share * ((now - angle[j]) * robot->rate - speed[j]);
        angle[j] = now;
        double torque = STIFFNESS * (robot->start[j] - now) - DAMPING * speed[j];
        answer.torque[j] = fmax(-robot->torque_limit, fmin(robot->torque_limit, torque));
    }
    return biped_write(controller, &answer, NULL);
}

int main(void) {
    biped_Controller *controller = NULL;
    biped_Status robot;
    double angle[BIPED_JOINTS], speed[BIPED_JOINTS];
    signal(SIGTERM, biped_stop);
    int result = biped_open(&controller);
    if (result >= 0) result = biped_status(controller, &robot);
    while (result >= 0) {
        result = biped_wait(controller);
        if (result == BIPED_GOODBYE) break;
        if (result > 0) result = hold(controller, &robot, result == BIPED_BEGIN, angle, speed);
    }
    if (result < 0 && result != BIPED_STOPPED) fprintf(stderr, "error: %s\n", biped_last_error());
    if (controller) biped_close(&controller);
    return -result;
}
