#include "one_go.h"

#include <stdio.h>
#include <string.h>

#include "text/fail.h"
#include "text/json.h"
#include "text/plain.h"

int one_go_read(const job *at, one_go *run)
{
    memset(run, 0, sizeof *run);
    run->truth = at->values[ONE_GO_TRUTH];
    TRY(solver_read(at->values[ONE_GO_SOLVER], &run->by));
    return search_read(&at->values[ONE_GO_SEARCH], &run->how);
}

int one_go_open(job *at, const maker *by, void *state, one_go *run)
{
    TRY(by->read(at->given->operands, &at->values[ONE_GO_MAKER], state));
    return by->open(state, &at->limit, &run->made);
}

int one_go_solve(job *at, one_go *run)
{
    return made_solve(&run->made, run->by, &run->how, &at->limit, &run->laid, &run->found);
}

bool one_go_print(const job *at, const one_go *run)
{
    const char *path = at->values[ONE_GO_OUTPUT];
    if (output_is_standard(path)) {
        return false;
    }
    if (at->json) {
        json_begin();
        solved_json(&run->found, run->laid.scale);
        json_name("output", path);
        return true;
    }
    job_print_outputs(at, path);
    solved_print(&run->found, run->laid.scale);
    return true;
}

void one_go_end(const job *at)
{
    if (at->json) {
        json_end();
    }
}
