/* Every wrong call gives its code and a sentence, in a session without a plant. Prints each call that does not. */
#include "controller.h"

#include <stdio.h>
#include <string.h>

static int failed = 0;

static void expect(const char *call, int said, int code, const char *word) {
    if (said == code && strstr(biped_last_error(), word)) return;
    printf("%s: %d, not %d with `%s`: %s\n", call, said, code, word, biped_last_error());
    failed = 1;
}

int main(void) {
    biped_Controller *controller = NULL, *second = NULL;
    biped_Encoders encoders;
    biped_Torques torques = {{0}};
    biped_Status status;
    if (biped_last_error()[0]) failed = 1;
    expect("open", biped_open(NULL), BIPED_MISUSE, "NULL");
    expect("wait", biped_wait(NULL), BIPED_MISUSE, "not open");
    expect("close", biped_close(&controller), BIPED_MISUSE, "not open");
    if (biped_open(&controller) != 0) printf("open: %s\n", biped_last_error()), failed = 1;
    expect("second", biped_open(&second), BIPED_INCOMPATIBLE, "already has a controller");
    expect("read early", biped_read(controller, &encoders), BIPED_MISUSE, "biped_wait first");
    expect("read nowhere", biped_read(controller, NULL), BIPED_MISUSE, "NULL");
    expect("plan early", biped_plan(controller, &torques, NULL), BIPED_MISUSE, "no reading to answer");
    expect("write early", biped_write(controller, &torques, NULL), BIPED_MISUSE, "no reading to answer");
    expect("write nothing", biped_write(controller, NULL, NULL), BIPED_MISUSE, "NULL");
    expect("status nowhere", biped_status(controller, NULL), BIPED_MISUSE, "NULL");
    if (biped_status(controller, &status) != 0 || status.seq != 0 || status.rate != 1000.0) failed = 1;
    expect("wait alone", biped_wait(controller), BIPED_NO_PLANT, "no plant");
    biped_stop(0);
    expect("wait stopped", biped_wait(controller), BIPED_STOPPED, "stop");
    if (biped_close(&controller) != 0 || controller != NULL) failed = 1;
    expect("close again", biped_close(&controller), BIPED_MISUSE, "closed already");
    return failed;
}
