#include "samples_output.h"

#include <string.h>

#include "text/fail.h"

int samples_output_write(const problem_file *problem, const one_sample *sample, output *out)
{
    const qs_record record = {sample->energy, 1, QS_NO_CHAINS};
    qs_samples samples = {
        .variables = problem->qubo.variables,
        .count = 1,
        .solver = sample->solver,
        .solver_size = strlen(sample->solver),
        .info = sample->info,
        .info_size = strlen(sample->info),
        .records = &record,
        .bits = sample->bits,
    };
    const qs_sink sink = {output_sink, out};
    qs_digest(problem->file.bytes, problem->file.size, samples.problem);
    qs_status written = qs_samples_write(&samples, &sink, NULL);
    return written == QS_OK || written == QS_E_IO ? DONE : fail_status(out->name, written);
}

int samples_output_labelling(const problem_file *problem, const uint16_t *labelling,
                             const char *solver, const char *info, budget *limit, output *out)
{
    uint8_t *bits = budget_take(limit, out->name, ((size_t)problem->qubo.variables + 7) / 8);
    if (bits == NULL) {
        return NO_RESOURCE;
    }
    qs_status encoded = qs_sample_encode(&problem->index, labelling, bits);
    if (encoded != QS_OK) {
        return fail_status(out->name, encoded);
    }
    const one_sample made = {bits, qs_qubo_energy(&problem->index, bits), solver, info};
    return samples_output_write(problem, &made, out);
}
