/* Prints where the robots of a run are, once for each frame.
 *
 *   cc -O2 -I clients/c/include clients/c/examples/frames.c -o frames \
 *      -L target/release -levswarm_client -Wl,-rpath,$PWD/target/release
 *   ./frames RUN_ID [MOST] */
#include <evswarm.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void see(const evswarm_frame_header *header, const evswarm_robot_state *robots, size_t count,
                void *context) {
    (void)context;
    printf("step %llu", (unsigned long long)header->arena_step);
    for (size_t robot = 0; robot < count; robot++) {
        printf("  %u at (%.3f, %.3f) m", robots[robot].number, robots[robot].x_m, robots[robot].y_m);
    }
    printf("\n");
}

int main(int count, char **arguments) {
    int helps = count > 1 && (strcmp(arguments[1], "--help") == 0 || strcmp(arguments[1], "-h") == 0);
    if (count < 2 || helps) {
        fputs("usage: frames RUN_ID [MOST]\nPrints where the robots of a run are, once for each of MOST frames (0: of all).\n", helps ? stdout : stderr);
        return helps ? 0 : 2;
    }
    unsigned long most = count > 2 ? strtoul(arguments[2], NULL, 10) : 0;
    evswarm_frames *frames = evswarm_frames_open(NULL, arguments[1], 0);
    if (frames == NULL) {
        fprintf(stderr, "%s\n", evswarm_error());
        return 1;
    }
    unsigned long seen = 0;
    while (evswarm_frames_next(frames, 5000, see, NULL) == 1) {
        if (++seen == most) {
            break;
        }
    }
    evswarm_frames_close(frames);
    return 0;
}
