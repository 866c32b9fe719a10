/* Stands: every joint is held where the scene puts it at the start, by a spring and a damper.
 *
 *     cargo build --release -p biped_c
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
#define CUT_OFF 150.0    /* of the low-pass on the rates [Hz] */
#define TURN 6.283185307179586

/* One control period: angle and speed are of the one before, unless it is the first of a run. */
static int hold(biped_Controller *controller, const biped_Status *robot, int first, double *angle, double *speed) {
    biped_Encoders encoders;
    int said = biped_read(controller, &encoders);
    if (said < 0) return said;
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
    int said = biped_open(&controller);
    if (said >= 0) said = biped_status(controller, &robot);
    while (said >= 0) {
        said = biped_wait(controller);
        if (said == BIPED_GOODBYE) break;
        if (said > 0) said = hold(controller, &robot, said == BIPED_BEGIN, angle, speed);
    }
    if (said < 0) fprintf(stderr, "error: %s\n", biped_last_error());
    if (controller) biped_close(&controller);
    return -said;
}
