#include "presets.h"

#include <string.h>

#include "text/fail.h"

#define ALIKE(lambda, truncation)                                                                  \
    {                                                                                              \
        {{lambda, truncation}, {lambda, truncation}},                                              \
        {                                                                                          \
            {lambda, truncation},                                                                  \
            {                                                                                      \
                lambda, truncation                                                                 \
            }                                                                                      \
        }                                                                                          \
    }
#define TUNED                                                                                      \
    {                                                                                              \
        {{"28", "2"}, {"14", "4"}},                                                                \
        {                                                                                          \
            {"6", "4"}, {"3", "8"}                                                                 \
        }                                                                                          \
    }

/* accurate and fast are tuned on the seven scenes of tests/bench/bench_stereo.py. */
const preset presets[PRESETS] = {
    {"paper", "1", "ad", NULL, "leave-out", "potts", ALIKE("20", NULL), "20", "best", NULL, "none"},
    {"accurate", "0.5", "bt:40+2*census:7x7", "10,3", "keep", "linear", TUNED, "20", "trws16", "8",
     "check,fill"},
    {"fast", "1", "bt:40+2*census:7x7", "10,3", "keep", "linear", TUNED, "28", "trws16", "1",
     "halves,check,fill"},
};

const char *preset_at(size_t index)
{
    return index < PRESETS ? presets[index].name : NULL;
}

int preset_read(const char *text, const preset **chosen)
{
    for (size_t i = 0; i < PRESETS; i++) {
        if (strcmp(presets[i].name, text) == 0) {
            *chosen = &presets[i];
            return DONE;
        }
    }
    return fail_usage("--preset %s: there are paper, accurate and fast", text);
}
