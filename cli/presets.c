#include "presets.h"

#include <string.h>

#include "text/fail.h"

#define PAPER {"1", {{"20", NULL}, {"20", NULL}}, "20", NULL, "none"}
#define FEW   {{"28", "2"}, {"14", "4"}}
#define MANY  {{"6", "4"}, {"3", "8"}}

/* accurate and fast are tuned on the seven scenes of tests/bench/bench_stereo.py. Few labels leave
 * fast the time for half pixels and for more iterations. */
const preset presets[PRESETS] = {
    {"paper", "ad", NULL, "leave-out", "potts", "best", {PAPER, PAPER}},
    {"accurate",
     "bt:40+2*census:7x7",
     "10,3",
     "keep",
     "linear",
     "trws16",
     {{"0.5", FEW, "20", "8", "check,fill"}, {"0.5", MANY, "20", "8", "check,fill"}}},
    {"fast",
     "bt:40+2*census:7x7",
     "10,3",
     "keep",
     "linear",
     "trws16",
     {{"0.5", FEW, "20", "5", "check,fill"}, {"1", MANY, "28", "1", "halves,check,fill"}}},
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
