/* The Braitenberg vehicle that is also built in (`braitenberg`), from outside.
 *
 *   cargo build --release -p evswarm-c
 *   cc -O2 -ffp-contract=off -I clients/c/include clients/c/examples/braitenberg.c \
 *      -o braitenberg -L target/release -levswarm_client -Wl,-rpath,$PWD/target/release
 *   ./braitenberg RUN_ID [CONTROLLER]
 *
 * Without fused multiply-add it gives the bits of the one built in. */
#include <evswarm.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What ps0 to ps7 add to the left and to the right wheel. */
static const float WEIGHTS[8][2] = {
    {0.942f, -0.22f}, {0.63f, -0.1f}, {0.5f, -0.06f}, {-0.06f, -0.06f},
    {-0.06f, -0.06f}, {-0.06f, 0.5f}, {-0.19f, 0.63f}, {-0.13f, 0.942f},
};

static float clamped(float value) {
    return value < -1.0f ? -1.0f : value > 1.0f ? 1.0f : value;
}

static void act(const evswarm_asked *asked, const evswarm_robot_sense *robots,
                evswarm_wheel_command *commands, size_t count, void *context) {
    (void)asked;
    (void)context;
    for (size_t robot = 0; robot < count; robot++) {
        float left = 0.0f, right = 0.0f;
        for (int sensor = 0; sensor < 8; sensor++) {
            float part = 1.0f - robots[robot].sensors[sensor] / 512.0f;
            left += WEIGHTS[sensor][0] * part;
            right += WEIGHTS[sensor][1] * part;
        }
        commands[robot].left = clamped(0.5f * left);
        commands[robot].right = clamped(0.5f * right);
    }
}

int main(int count, char **arguments) {
    int helps = count > 1 && (strcmp(arguments[1], "--help") == 0 || strcmp(arguments[1], "-h") == 0);
    if (count < 2 || helps) {
        fputs("usage: braitenberg RUN_ID [CONTROLLER]\nSteers a run as the method braitenberg does.\n", helps ? stdout : stderr);
        return helps ? 0 : 2;
    }
    size_t number = count > 2 ? strtoul(arguments[2], NULL, 10) : 0;
    evswarm_controller *controller = evswarm_controller_open(NULL, arguments[1], number);
    while (controller != NULL && evswarm_controller_answer(controller, 1000, act, NULL) >= 0) {
    }
    fprintf(stderr, "%s\n", evswarm_error());
    return 1;
}
