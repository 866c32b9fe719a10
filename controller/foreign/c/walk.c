/* Walks: the torques are those of this project's controller in Rust, by biped_plan, and the session is this program's. Put
 * your own law where they are asked for.
 *
 *     cargo build --release -p biped_c
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
    int said = biped_open(&controller);
    while (said >= 0) {
        said = biped_wait(controller);
        if (said == BIPED_GOODBYE) break;
        if (said > 0) said = biped_plan(controller, &torques, &telemetry);
        if (said >= 0) said = biped_write(controller, &torques, &telemetry);
    }
    if (said < 0) fprintf(stderr, "error: %s\n", biped_last_error());
    if (controller) biped_close(&controller);
    return -said;
}
