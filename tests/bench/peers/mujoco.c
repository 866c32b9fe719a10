/* MuJoCo on the states that the bench wrote: its step, and the stages of it.

       cc -O2 -I INCLUDE mujoco.c libmujoco.so && a.out biped8.xml states.txt

   Newton's method, elliptic cones, Euler, steps of 1 ms. Prints `situation stage nanoseconds`, medians over the states. Each state
   is set before it is stepped from; the solver starts from the accelerations of the step before, as it does in a run. */

#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { JOINTS = 8, STATES = 4096, STAGES = 8, REPEATS = 16 };
#define NEAR 1e-4 /* a contact point below this height touches; in these states the points lie exactly on the ground [m] */

typedef struct {
  double position[3], orientation[4], velocity[3], spin[3], angle[JOINTS], rate[JOINTS], torque[JOINTS];
} State;

static const char *names[STAGES] = {"step", "kinematics", "inertia", "factor", "bias", "constraint", "solve", "contacts"};
static double times[STAGES][STATES];
static State states[STATES];

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e9 * t.tv_sec + t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *list, int count) {
  qsort(list, count, sizeof *list, ascending);
  return list[count / 2];
}

static double reading(void) {
  for (int i = 0; i < 999; i++) {
    double begun = now();
    times[0][i] = now() - begun;
  }
  return median(times[0], 999);
}

static void put(const mjModel *model, mjData *data, const State *state) {
  memcpy(data->qpos, state->position, sizeof state->position);
  memcpy(data->qpos + 3, state->orientation, sizeof state->orientation);
  memcpy(data->qpos + 7, state->angle, sizeof state->angle);
  memcpy(data->qvel, state->velocity, sizeof state->velocity);
  memcpy(data->qvel + 3, state->spin, sizeof state->spin);
  memcpy(data->qvel + 6, state->rate, sizeof state->rate);
  memcpy(data->qfrc_applied + 6, state->torque, sizeof state->torque);
}

/* Time of a stage: of many calls, where it may be called again. */
#define TIME(stage, repeats, call)                                 \
  do {                                                             \
    double begun = now();                                          \
    for (int r = 0; r < (repeats); r++) { call; }                  \
    times[stage][i] = (now() - begun - clock_reading) / (repeats); \
  } while (0)

int main(int count, char **arguments) {
  char error[1000] = "", name[64];
  mjModel *model = count == 3 ? mj_loadXML(arguments[1], NULL, error, sizeof error) : NULL;
  FILE *file = model ? fopen(arguments[2], "r") : NULL;
  if (!file) return fprintf(stderr, "mujoco.c ROBOT.xml STATES %s\n", error), 2;
  printf("version %s\n", mj_versionString());
  double clock_reading = reading(), gravity, friction, armature, stiffness, damping;
  int n;
  while (fscanf(file, "%63s %d %lf %lf %lf %lf %lf", name, &n, &gravity, &friction, &armature, &stiffness, &damping) == 7) {
    if (n > STATES) return 2;
    for (int i = 0; i < n; i++)
      for (int k = 0; k < (int)(sizeof(State) / sizeof(double)); k++)
        if (fscanf(file, "%lf", (double *)&states[i] + k) != 1) return 2;
    model->opt.timestep = 1e-3, model->opt.gravity[2] = -gravity;
    model->opt.integrator = mjINT_EULER, model->opt.solver = mjSOL_NEWTON, model->opt.cone = mjCONE_ELLIPTIC;
    model->opt.disableflags |= mjDSBL_SENSOR | mjDSBL_ISLAND | mjDSBL_AUTORESET;
    for (int g = 0; g < model->ngeom; g++) model->geom_friction[3 * g] = friction, model->geom_margin[g] = NEAR / 2;
    for (int k = 0; k < JOINTS; k++) {
      model->dof_armature[6 + k] = armature, model->dof_damping[6 + k] = damping;
      model->jnt_stiffness[1 + k] = stiffness, model->qpos_spring[7 + k] = states[0].angle[k];
    }
    mjData *data = mj_makeData(model);
    double results[STAGES][9];
    for (int round = 0; round < 9; round++) {
      for (int i = 0; i < n; i++) {
        put(model, data, &states[i]);
        TIME(0, 1, mj_step(model, data));
      }
      for (int i = 0; i < n; i++) {
        put(model, data, &states[i]);
        TIME(1, REPEATS, (mj_kinematics(model, data), mj_comPos(model, data), mj_comVel(model, data)));
        TIME(2, REPEATS, mj_makeM(model, data));
        TIME(3, REPEATS, mj_factorM(model, data));
        TIME(4, REPEATS, mj_rne(model, data, 0, data->qfrc_bias));
        TIME(5, 1, (mj_collision(model, data), mj_makeConstraint(model, data), mj_projectConstraint(model, data)));
        mj_transmission(model, data), mj_fwdVelocity(model, data), mj_fwdActuation(model, data);
        mj_fwdAcceleration(model, data);
        TIME(6, 1, mj_fwdConstraint(model, data));
        memcpy(data->qacc_warmstart, data->qacc, sizeof(mjtNum) * model->nv);
        times[7][i] = data->ncon;
      }
      for (int s = 0; s < STAGES; s++) results[s][round] = median(times[s], n);
    }
    for (int s = 0; s < STAGES; s++) printf("%s %s %.1f\n", name, names[s], median(results[s], 9));
    mj_deleteData(data);
  }
  return 0;
}
