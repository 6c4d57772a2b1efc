/* Step a batch of PufferLib's environment `target`, many steps in one call. The environment is in a header of
 * PufferLib's source package; the memory layout of the batch is that of PufferLib's Python class. */
#include "target.h"

#define OPEN __attribute__((visibility("default")))
#define TURNS 9
#define PUSHES 5

typedef struct {
    int envs;
    Target* all;
} Batch;

/* Return a new batch, or NULL if memory does not suffice. The batch is never freed: it lives as long as the process. */
OPEN Batch* make_batch(int envs, int agents, int goals) {
    size_t seats = (size_t)envs * agents, floats = 2 * (agents + goals) + 4;
    Batch* batch = malloc(sizeof(Batch));
    Target* all = calloc(envs, sizeof(Target));
    float* observations = calloc(seats * floats, sizeof(float));
    float* rewards = calloc(seats, sizeof(float));
    int* actions = calloc(seats * 2, sizeof(int));
    unsigned char* terminals = calloc(seats, 1);
    if (!batch || !all || !observations || !rewards || !actions || !terminals) return NULL;

    srand(1);
    for (size_t seat = 0; seat < seats; seat++) {
        actions[2 * seat] = rand() % TURNS;
        actions[2 * seat + 1] = rand() % PUSHES;
    }
    for (int e = 0; e < envs; e++) {
        size_t first = (size_t)e * agents;
        all[e].width = 1080;
        all[e].height = 720;
        all[e].num_agents = agents;
        all[e].num_goals = goals;
        all[e].observations = observations + first * floats;
        all[e].rewards = rewards + first;
        all[e].actions = actions + 2 * first;
        all[e].terminals = terminals + first;
        init(&all[e]);
        c_reset(&all[e]);
    }
    *batch = (Batch){envs, all};
    return batch;
}

OPEN void play(Batch* batch, int steps) {
    for (int step = 0; step < steps; step++)
        for (int e = 0; e < batch->envs; e++) c_step(&batch->all[e]);
}
