/* A controller's end of a session. Made by this crate's test `header`: do not edit.
 *
 * A result below zero is an error, minus the exit code to end with; biped_last_error() says it in a sentence.
 */

#ifndef BIPED_CONTROLLER_H
#define BIPED_CONTROLLER_H

#include "biped.h"

// Said by `biped_wait`: the plant's goodbye, which wants no answer.
#define BIPED_GOODBYE 0

// Said by `biped_wait`: encoders are there, torques are wanted.
#define BIPED_TICK 1

// Said by `biped_wait`: the same, and they are the first of a run: forget what was before.
#define BIPED_BEGIN 2

// Wrong arguments, calls in a wrong order, or an environment that is not `biped run`'s.
#define BIPED_MISUSE -2

// No plant sent sensors.
#define BIPED_NO_PLANT -3

// A robot for which `biped_plan` knows no torques, or a defect of this library.
#define BIPED_DEFECT -4

// The session has another contract, or a controller already.
#define BIPED_INCOMPATIBLE -5

// Shared memory is missing, full or blocked.
#define BIPED_SHARED_MEMORY -6

// `biped_stop` was called.
#define BIPED_STOPPED -130

// A controller's place in a session.
typedef struct biped_Controller biped_Controller;

// Where the session is, and what a controller needs to know of its robot.
typedef struct {
    // Number of the plant's run; 0 before the first encoders came.
    uint64_t run;
    // Number of the newest encoders in that run, from 1.
    uint64_t seq;
    // Their simulated time [s].
    double time;
    // Control periods in a second [Hz].
    double rate;
    // Angle of one encoder count [rad].
    double count;
    // Greatest torque that a drive gives [N·m].
    double torque_limit;
    // Joint angles at time zero [rad].
    double start[8];
} biped_Status;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Takes the controller's place in the session that `biped run --controller` put into the environment; or, if there is
// only BIPED_SESSION, attaches to the session of that name, as `biped_attach` does.
//
// `controller` is null or points to a pointer that may be written.
int biped_open(biped_Controller **controller);

// Takes the controller's place in the session of this name, which `biped plant SCENE --session NAME` has started, or will
// within `patience` seconds. Sensors may be missing for as long.
//
// `controller` is null or points to a pointer that may be written; `session` is null or ends with a zero.
int biped_attach(biped_Controller **controller,
                 const char *session,
                 double patience);

// Waits for encoders that have not been answered: BIPED_GOODBYE, BIPED_TICK or BIPED_BEGIN. What the plant asks again is
// answered again by itself.
//
// `controller` is null or from `biped_open`.
int biped_wait(biped_Controller *controller);

// The encoders that `biped_wait` found.
//
// `controller` is null or from `biped_open`; `encoders` is null or may be written.
int biped_read(biped_Controller *controller, biped_Encoders *encoders);

// What this project's own controller, in Rust, would answer to them, and what it thinks; telemetry may be NULL. Once for
// each `biped_wait`, if at all: a place to begin from, or to add to.
//
// `controller` is null or from `biped_open`; `torques` and `telemetry` are null or may be written.
int biped_plan(biped_Controller *controller,
               biped_Torques *torques,
               biped_Telemetry *telemetry);

// Answers them by torques; telemetry may be NULL. Once for each `biped_wait`.
//
// `controller` is null or from `biped_open`; `torques` and `telemetry` are null or may be read.
int biped_write(biped_Controller *controller,
                const biped_Torques *torques,
                const biped_Telemetry *telemetry);

// Where the session is.
//
// `controller` is null or from `biped_open`; `status` is null or may be written.
int biped_status(biped_Controller *controller, biped_Status *status);

// Leaves the session, and makes the pointer NULL.
//
// `controller` is null or points to a pointer that is null or from `biped_open`.
int biped_close(biped_Controller **controller);

// Makes `biped_wait` return, now and later: `signal(SIGTERM, biped_stop)` ends a controller in order.
void biped_stop(int signal);

// What the last call of this thread that failed has to say, until the next one fails: a sentence, never NULL.
const char *biped_last_error(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BIPED_CONTROLLER_H */
