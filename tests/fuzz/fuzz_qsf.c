/* A .qsf, and what stands in its INFO. */
#include <qstereo.h>
#include <string.h>

#include "fuzz.h"
#include "text/json.h"

static void count_number(void *context, const char *name, size_t size, double number)
{
    (void)name;
    (void)number;
    *(size_t *)context += size;
}

/* What is read and written again is the same file, but for side chunks and their order. */
static void write_again(const qs_samples_view *view, size_t size)
{
    uint8_t *file = malloc(size + 1);
    qs_buffer buffer = {file, size, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    qs_record *records = malloc((view->count + (size_t)1) * sizeof *records);
    for (uint32_t s = 0; s < view->count; s++) {
        records[s] = qs_samples_record(view, s);
    }
    qs_samples samples = {.variables = view->variables,
                          .count = view->count,
                          .solver = view->solver,
                          .solver_size = view->solver_size,
                          .info = view->info,
                          .info_size = view->info_size,
                          .records = records,
                          .bits = view->bits};
    memcpy(samples.problem, view->problem, QS_DIGEST_SIZE);
    uint64_t written = 0;
    PROMISE(qs_samples_write(&samples, &sink, &written) == QS_OK && written <= size);
    free(records);
    free(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    qs_samples_view view;
    qs_fault fault = {0, NULL};
    qs_status status = qs_samples_open(data, size, &view, &fault);
    PROMISE((status == QS_OK) == (fault.what == NULL) && fault.offset <= size);
    if (status != QS_OK) {
        return 0;
    }
    uint32_t last = 0;
    for (uint32_t s = 0; s < view.count; s++) {
        const uint8_t *bits = qs_samples_bits(&view, s);
        last ^= view.variables > 0 ? bits[(view.variables - 1) / 8] : 0;
    }
    PROMISE(view.solver_size >= 1 && view.solver_size <= 255 && last <= UINT8_MAX);
    if (json_is_object(view.info, view.info_size)) {
        double number;
        size_t names = 0;
        json_find_number(view.info, view.info_size, "seconds", &number);
        json_each_number(view.info, view.info_size, "parameters", count_number, &names);
        PROMISE(names <= view.info_size);
    }
    write_again(&view, size);
    return 0;
}
