/* The wire format of biped. Made by `biped wire c`: do not edit. */
#ifndef BIPED_WIRE_H
#define BIPED_WIRE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define BIPED_ASSERT static_assert
#else
#define BIPED_ASSERT _Static_assert
#endif

#define BIPED_MAGIC 0x42504944u
#define BIPED_SCHEMA 0xcb822b76123a5e4bull
#define BIPED_JOINTS 8
#define BIPED_CONTACTS 16

/* Telemetry.phase */
#define BIPED_PHASE_STAND 0
#define BIPED_PHASE_SWAY 1
#define BIPED_PHASE_LIFT 2
#define BIPED_PHASE_WALK 3
#define BIPED_PHASE_LAND 4
#define BIPED_PHASE_REST 5

/* Truth.state, Reply.state */
#define BIPED_STATE_WAIT 0
#define BIPED_STATE_RUN 1
#define BIPED_STATE_PAUSED 2
#define BIPED_STATE_HOLD 3
#define BIPED_STATE_DAMP 4
#define BIPED_STATE_FAULT 5

/* Request.kind */
#define BIPED_REQUEST_PAUSE 0
#define BIPED_REQUEST_RESUME 1
#define BIPED_REQUEST_STEP 2
#define BIPED_REQUEST_RESET 3
#define BIPED_REQUEST_PUSH 4
#define BIPED_REQUEST_REARM 5
#define BIPED_REQUEST_SET 6
#define BIPED_REQUEST_STOP 7

/* Reply.verdict */
#define BIPED_VERDICT_DONE 0
/* 1: this request is for the other process */
/* 2: no such body */
/* 3: a number is out of range */
/* 4: damaged request */
/* 5: this program does not serve the request */
/* 6: the robot stands or stops, so the request has no effect */

/* Tally.refused */
/* 0: of another version */
/* 1: for another run */
/* 2: of a controller that has been replaced */
#define BIPED_REFUSED_DAMAGED 3
/* 4: not newer than the last */
/* 5: ahead of the sensors */
/* 6: not finite */
/* 7: beyond four times the torque limit */
/* 8: a jump beyond twice the torque limit */

/* Stamp at the head of every message. */
typedef struct {
    uint32_t magic; /* MAGIC. */
    uint32_t check; /* Check sum of all bytes after this field: lower half of XXH3 (64 bits, no seed). */
    uint64_t schema; /* SCHEMA_HASH. */
    uint64_t run; /* Number of the plant's run. It is random and changes at each start or reset. */
    uint64_t epoch; /* Number of the sending process, random at each start. */
    uint64_t seq; /* Number of the message: the sender counts its messages of this run from 1. */
    uint64_t ack; /* In a command: `seq` of the sensors that it answers. In other messages: 0. */
    uint64_t sim_ns; /* Simulated time [ns]. */
    uint64_t mono_ns; /* Monotonic clock of the sender when it sent the message [ns]. */
} biped_Stamp;
BIPED_ASSERT(sizeof(biped_Stamp) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, magic) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, check) == 4, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, schema) == 8, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, run) == 16, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, epoch) == 24, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, seq) == 32, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, ack) == 40, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, sim_ns) == 48, "layout");
BIPED_ASSERT(offsetof(biped_Stamp, mono_ns) == 56, "layout");

/* Reading of the joint encoders. */
typedef struct {
    int64_t counts[8]; /* Counts of each joint: 2^bits counts per turn, 0 at angle zero. */
} biped_Encoders;
BIPED_ASSERT(sizeof(biped_Encoders) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Encoders, counts) == 0, "layout");

/* Torque command for the drives. */
typedef struct {
    double torque[8]; /* Torque at each joint [N·m]. */
} biped_Torques;
BIPED_ASSERT(sizeof(biped_Torques) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Torques, torque) == 0, "layout");

/* State of the controller, for display and recording. The plant does not use it. */
typedef struct {
    uint32_t phase; /* Index into PHASES. */
    uint32_t support; /* Supporting leg: 0 left, 1 right. */
    uint64_t steps; /* Number of steps taken, that is, of exchanges of support. */
    double com[3]; /* Measured centre of gravity in the support frame S: forward, toward the swing foot, up [m]. */
    double swing[3]; /* Measured position of the centre of the swing foot's sole in S [m]. */
    double pendulum[4]; /* Planned state x_1, v_1, x_2, v_2 of the two pendulums (31), (32) in S [m, m/s]. */
    double energy[2]; /* Energies E_1, E_2 by (33) [m²/s²]. */
    double energy_ref[2]; /* Reference values of E_1, E_2 by (42), (40) [m²/s²]. */
    double landing; /* Planned landing position of the swing foot, x_t1 in S [m]. */
    double surface[8]; /* Sliding variable of each servo, wire order [rad/s]. */
} biped_Telemetry;
BIPED_ASSERT(sizeof(biped_Telemetry) == 200, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, phase) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, support) == 4, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, steps) == 8, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, com) == 16, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, swing) == 40, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, pendulum) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, energy) == 96, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, energy_ref) == 112, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, landing) == 128, "layout");
BIPED_ASSERT(offsetof(biped_Telemetry, surface) == 136, "layout");

/* Plant to controller: data that a real robot could measure. */
typedef struct {
    biped_Stamp stamp; /* Stamp. */
    biped_Encoders encoders; /* Joint encoders. */
    uint64_t last; /* 1 in the last message of a run, which needs no answer; otherwise 0. */
} biped_Sensors;
BIPED_ASSERT(sizeof(biped_Sensors) == 136, "layout");
BIPED_ASSERT(offsetof(biped_Sensors, stamp) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Sensors, encoders) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Sensors, last) == 128, "layout");

/* Controller to plant. */
typedef struct {
    biped_Stamp stamp; /* Stamp; `ack` is the number of the sensors that this command answers. */
    biped_Torques torques; /* Joint torques. */
    biped_Telemetry telemetry; /* State of the controller, for recording only. */
} biped_Command;
BIPED_ASSERT(sizeof(biped_Command) == 328, "layout");
BIPED_ASSERT(offsetof(biped_Command, stamp) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Command, torques) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Command, telemetry) == 128, "layout");

/* Counters of the plant since the start of its run. */
typedef struct {
    uint64_t refused[9]; /* Refused commands, one counter for each reason in REFUSALS. */
    uint64_t lost; /* Commands that never arrived, counted by gaps in their numbers. A repeated answer does not count. */
    uint64_t held; /* Control periods that reused the torques of an earlier command. */
    uint64_t damped; /* Control periods in which the joints were damped because no recent command had arrived. */
    uint64_t faulted; /* Control periods in which the drives were off. */
    uint64_t skipped; /* Control periods skipped because the plant was late by whole periods of real time. */
    uint64_t takeovers; /* Number of times that another controller process took over. */
    uint64_t unrecorded; /* Messages of truth that a recorder did not receive. */
    uint64_t requests; /* Requests answered. */
} biped_Tally;
BIPED_ASSERT(sizeof(biped_Tally) == 136, "layout");
BIPED_ASSERT(offsetof(biped_Tally, refused) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Tally, lost) == 72, "layout");
BIPED_ASSERT(offsetof(biped_Tally, held) == 80, "layout");
BIPED_ASSERT(offsetof(biped_Tally, damped) == 88, "layout");
BIPED_ASSERT(offsetof(biped_Tally, faulted) == 96, "layout");
BIPED_ASSERT(offsetof(biped_Tally, skipped) == 104, "layout");
BIPED_ASSERT(offsetof(biped_Tally, takeovers) == 112, "layout");
BIPED_ASSERT(offsetof(biped_Tally, unrecorded) == 120, "layout");
BIPED_ASSERT(offsetof(biped_Tally, requests) == 128, "layout");

/* Data that only the simulation knows, for recording. Never for control. */
typedef struct {
    biped_Stamp stamp; /* Stamp; `seq` is that of the sensors of the same instant. */
    double base_position[3]; /* Position of the base frame in W [m]. */
    double base_orientation[4]; /* Orientation of the base in W: unit quaternion w, x, y, z. */
    double base_velocity[3]; /* Velocity of the base frame's origin in W [m/s]. */
    double base_spin[3]; /* Angular velocity of the base in W [rad/s]. */
    double angle[8]; /* Joint angles [rad]. */
    double rate[8]; /* Joint rates [rad/s]. */
    double torque[8]; /* Torques of the drives over the control period before this instant, after delay and limits [N·m]. */
    double contact_force[48]; /* Mean force of the ground on each contact point over that period: x, y, z in W [N]. */
    double natural_map; /* Largest natural-map residual of the steps in that period, relative to each step's scale. */
    double signorini; /* Largest Signorini residual, scaled likewise. */
    double slip_misalignment; /* Largest angle between the friction force and the direction opposite to slip, over slipping contacts [rad]. */
    double energy_gain; /* Largest excess of the energy after the contact impulse over that of the free motion [J]. */
    double penetration; /* Deepest penetration of the ground at this instant, as a positive number [m]. */
    uint64_t hash; /* Hash of every state since the start of the run. */
    uint64_t fallbacks; /* Number of steps so far whose contact problem needed a fallback. */
    uint64_t pivots; /* Largest number of pivots of one step in the period. */
    uint64_t plant_ns; /* Time in which the plant computed the period [ns]. */
    uint64_t wait_ns; /* Time for which the plant waited for the command [ns]. */
    uint64_t late_ns; /* Delay of the period's start after its deadline, in real time [ns]. */
    uint64_t reply_ns; /* Time from sending the sensors to sending the command that answers them; 0 if that command did not arrive [ns]. */
    uint32_t state; /* Index into STATES. */
    uint32_t age; /* Age of the command that drives the robot [control periods]. */
    biped_Tally tally; /* Counters of the plant so far. */
    biped_Telemetry telemetry; /* Telemetry of the last accepted command. */
    biped_Stamp command; /* Stamp of that command, the newest one accepted before this instant; zero before the first. */
    biped_Torques asked; /* Torques of that command. */
    biped_Encoders encoders; /* Reading of the joint encoders at this instant. */
} biped_Truth;
BIPED_ASSERT(sizeof(biped_Truth) == 1376, "layout");
BIPED_ASSERT(offsetof(biped_Truth, stamp) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Truth, base_position) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Truth, base_orientation) == 88, "layout");
BIPED_ASSERT(offsetof(biped_Truth, base_velocity) == 120, "layout");
BIPED_ASSERT(offsetof(biped_Truth, base_spin) == 144, "layout");
BIPED_ASSERT(offsetof(biped_Truth, angle) == 168, "layout");
BIPED_ASSERT(offsetof(biped_Truth, rate) == 232, "layout");
BIPED_ASSERT(offsetof(biped_Truth, torque) == 296, "layout");
BIPED_ASSERT(offsetof(biped_Truth, contact_force) == 360, "layout");
BIPED_ASSERT(offsetof(biped_Truth, natural_map) == 744, "layout");
BIPED_ASSERT(offsetof(biped_Truth, signorini) == 752, "layout");
BIPED_ASSERT(offsetof(biped_Truth, slip_misalignment) == 760, "layout");
BIPED_ASSERT(offsetof(biped_Truth, energy_gain) == 768, "layout");
BIPED_ASSERT(offsetof(biped_Truth, penetration) == 776, "layout");
BIPED_ASSERT(offsetof(biped_Truth, hash) == 784, "layout");
BIPED_ASSERT(offsetof(biped_Truth, fallbacks) == 792, "layout");
BIPED_ASSERT(offsetof(biped_Truth, pivots) == 800, "layout");
BIPED_ASSERT(offsetof(biped_Truth, plant_ns) == 808, "layout");
BIPED_ASSERT(offsetof(biped_Truth, wait_ns) == 816, "layout");
BIPED_ASSERT(offsetof(biped_Truth, late_ns) == 824, "layout");
BIPED_ASSERT(offsetof(biped_Truth, reply_ns) == 832, "layout");
BIPED_ASSERT(offsetof(biped_Truth, state) == 840, "layout");
BIPED_ASSERT(offsetof(biped_Truth, age) == 844, "layout");
BIPED_ASSERT(offsetof(biped_Truth, tally) == 848, "layout");
BIPED_ASSERT(offsetof(biped_Truth, telemetry) == 984, "layout");
BIPED_ASSERT(offsetof(biped_Truth, command) == 1184, "layout");
BIPED_ASSERT(offsetof(biped_Truth, asked) == 1248, "layout");
BIPED_ASSERT(offsetof(biped_Truth, encoders) == 1312, "layout");

/* Request to the control service of the plant or of the controller. */
typedef struct {
    biped_Stamp stamp; /* Stamp. */
    uint64_t kind; /* Index into REQUESTS. */
    uint64_t count; /* For `step`: number of control periods to run. For `push`: number of the body in the scene. */
    uint64_t seed; /* For `reset`: the new seed; 0 keeps the old one. */
    double impulse[3]; /* For `push`: impulse in W [N·s]. */
    double duration; /* For `push`: duration [s]. */
    double period; /* For `set`: period of two steps [s]; infinity leaves it unchanged. */
    double speed; /* For `set`: walking speed [m/s]; infinity leaves it unchanged. */
} biped_Request;
BIPED_ASSERT(sizeof(biped_Request) == 136, "layout");
BIPED_ASSERT(offsetof(biped_Request, stamp) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Request, kind) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Request, count) == 72, "layout");
BIPED_ASSERT(offsetof(biped_Request, seed) == 80, "layout");
BIPED_ASSERT(offsetof(biped_Request, impulse) == 88, "layout");
BIPED_ASSERT(offsetof(biped_Request, duration) == 112, "layout");
BIPED_ASSERT(offsetof(biped_Request, period) == 120, "layout");
BIPED_ASSERT(offsetof(biped_Request, speed) == 128, "layout");

/* Answer of the control service. */
typedef struct {
    biped_Stamp stamp; /* Stamp; `sim_ns` is the simulated time. */
    uint64_t verdict; /* Index into VERDICTS. */
    uint64_t state; /* Index into STATES: state of the plant. The controller sends 0. */
} biped_Reply;
BIPED_ASSERT(sizeof(biped_Reply) == 80, "layout");
BIPED_ASSERT(offsetof(biped_Reply, stamp) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Reply, verdict) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Reply, state) == 72, "layout");

/* A request with its answer, for recorders. */
typedef struct {
    biped_Stamp stamp; /* Stamp of the reply. From the plant: the request took effect between the sensors of this number and the next ones.  From the controller: the request took effect after its answer to the sensors `ack`. */
    biped_Request request; /* The request. */
    uint64_t verdict; /* Index into VERDICTS. */
} biped_Served;
BIPED_ASSERT(sizeof(biped_Served) == 208, "layout");
BIPED_ASSERT(offsetof(biped_Served, stamp) == 0, "layout");
BIPED_ASSERT(offsetof(biped_Served, request) == 64, "layout");
BIPED_ASSERT(offsetof(biped_Served, verdict) == 200, "layout");

#endif
