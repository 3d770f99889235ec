/* Frames of a run and controllers of its robots, for programs in C on the same machine and of the
 * same user as the simulator. Link with evswarm_client (`cargo build --release -p evswarm-c`).
 *
 * Functions return NULL or -1 when they fail; evswarm_error() says why. An object is used by one
 * thread at a time. Structures are those that lie in shared memory, in the machine's byte order. */
#ifndef EVSWARM_H
#define EVSWARM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A robot in a frame. */
typedef struct {
    uint32_t number;       /* from 0 */
    float x_m, y_m;        /* from the arena's lower left corner */
    float heading_cos, heading_sin;
    float sensors[8];      /* ps0 to ps7, 0 to 4095 */
    float commands[2];     /* left, right: -1 to 1 of the top speed */
} evswarm_robot_state;

/* The moment of a frame. */
typedef struct {
    uint64_t sequence;     /* frames sent before this one */
    uint64_t arena_step;   /* steps of the arena since the run began */
    uint64_t robot_steps_done, robot_steps_total;
    double sim_time_s, step_s;
    uint32_t version;
    uint32_t phase;        /* babbling, evolution, repository, exploration, done */
    uint32_t epochs_done, epochs_total;
    uint32_t robots;
    uint32_t reserved;
} evswarm_frame_header;

/* What a run asks its controller about. */
typedef struct {
    uint64_t arena_step;
    double sim_time_s, step_s;
    double width_m, height_m;
    uint32_t epoch, epoch_step; /* at epoch_step 0 robots are back at their starts */
    uint32_t epochs, steps_per_epoch;
    uint32_t robots;       /* of the run */
    uint32_t first_robot;  /* number of the first that is asked about */
    uint32_t columns, rows;
    uint32_t asked_robots;
    uint32_t version;
} evswarm_asked;

/* What a robot reads. It knows its sensors alone; the rest is for rewards and displays. */
typedef struct {
    uint32_t number;
    float sensors[8];
    float x_m, y_m;
    float heading_cos, heading_sin;
    uint32_t first_entries;
} evswarm_robot_sense;

/* What a robot is to do: -1 to 1 of the top speed, rounded to thousandths. */
typedef struct {
    float left, right;
} evswarm_wheel_command;

/* Why the last function of this thread failed. */
const char *evswarm_error(void);

typedef struct evswarm_controller evswarm_controller;

/* Sets a command for each robot; they are 0 before. */
typedef void (*evswarm_act)(const evswarm_asked *asked, const evswarm_robot_sense *robots,
                            evswarm_wheel_command *commands, size_t count, void *context);

/* A controller of a run, the one of this number of those that share its robots. `root` is the folder
 * of the channels, NULL for the user's. The run need not have begun. */
evswarm_controller *evswarm_controller_open(const char *root, const char *run_id, size_t number);

/* Waits for a question and answers it: 1 when it did, 0 when none came in time. */
int evswarm_controller_answer(evswarm_controller *controller, uint64_t wait_ms, evswarm_act act,
                              void *context);

void evswarm_controller_close(evswarm_controller *controller);

typedef struct evswarm_frames evswarm_frames;

/* Sees a frame, which lies in shared memory until the function returns. */
typedef void (*evswarm_see)(const evswarm_frame_header *header, const evswarm_robot_state *robots,
                            size_t count, void *context);

/* A reader of a run's frames: the latest, or, where `lossless` is not 0, all. */
evswarm_frames *evswarm_frames_open(const char *root, const char *run_id, int lossless);

/* Waits for a frame: 1 when it came, 0 when none did in time or the channel is closed. */
int evswarm_frames_next(evswarm_frames *frames, uint64_t wait_ms, evswarm_see see, void *context);

void evswarm_frames_close(evswarm_frames *frames);

#ifdef __cplusplus
}
#endif

#endif
