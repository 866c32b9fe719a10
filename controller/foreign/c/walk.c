/* A walking controller: this program runs the session, and biped_plan returns the torques of this project's controller. Replace that
 * call by your own control law.
 *
 *     cargo build --release -p biped-c
 *     cc controller/foreign/c/walk.c -o walk -I controller/foreign/c -I messages/include \
 *         -L target/release -lbiped_c -Wl,-rpath,"$PWD/target/release"
 *     biped run walk --controller ./walk
 */
#include "controller.h"

#include <signal.h>
#include <stdio.h>

int main(void) {
    biped_Controller *controller = NULL;
    biped_Torques torques;
    biped_Telemetry telemetry;
    signal(SIGTERM, biped_stop);
    int result = biped_open(&controller);
    while (result >= 0) {
        result = biped_wait(controller);
        if (result == BIPED_GOODBYE) break;
        if (result > 0) result = biped_plan(controller, &torques, &telemetry);
        if (result >= 0) result = biped_write(controller, &torques, &telemetry);
    }
    if (result < 0 && result != BIPED_STOPPED) fprintf(stderr, "error: %s\n", biped_last_error());
    if (controller) biped_close(&controller);
    return -result;
}
