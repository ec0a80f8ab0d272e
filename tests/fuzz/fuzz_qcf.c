/* A .qcf and everything behind it: what it says, energies, repair, all solvers, reduction, and the
 * same problem in every encoding. */
#include <qstereo.h>
#include <string.h>

#include "fuzz.h"

enum { MEMORY = 4 << 20, STATES = 2048, STEPS = 2 };

static void *room(size_t size)
{
    void *memory = size <= MEMORY ? malloc(size + 1) : NULL;
    return memory;
}

/* Bits that depend on the file's, spare ones 0. */
static uint8_t *make_bits(const qs_qubo *qubo, uint32_t salt)
{
    size_t bytes = ((size_t)qubo->variables + 7) / 8;
    uint8_t *bits = malloc(bytes + 1);
    for (size_t i = 0; i < bytes; i++) {
        bits[i] = (uint8_t)(qubo->bytes[(i * 7 + salt) % qubo->size] * (salt + 1));
    }
    if (qubo->variables % 8 != 0) {
        bits[bytes - 1] &= (uint8_t)((1u << qubo->variables % 8) - 1);
    }
    return bits;
}

static void repair_samples(const qs_index *index)
{
    const qs_qubo *qubo = index->qubo;
    size_t size = qs_repair_workspace(index);
    void *workspace = room(size);
    uint16_t *labelling = qubo->has_labels ? room(2 * (size_t)qubo->labels.sites) : NULL;
    for (uint32_t salt = 0; workspace && salt < 2; salt++) {
        uint8_t *bits = make_bits(qubo, salt);
        uint32_t broken = qs_sample_infeasible(index, bits), repaired;
        qs_qubo_energy(index, bits);
        if (qs_sample_repair(index, bits, workspace, size, &repaired) == QS_OK) {
            PROMISE(repaired == broken && qs_sample_infeasible(index, bits) == 0);
            int64_t energy = qs_qubo_energy(index, bits);
            if (labelling && qs_sample_decode(index, bits, labelling) == QS_OK) {
                bool arcs = qubo->labels.encoding == QS_ST_CUT_ARCS;
                qs_sample_trimmed(qubo, labelling);
                PROMISE(qs_sample_encode(index, labelling, bits) == QS_OK);
                PROMISE(qs_sample_infeasible(index, bits) == 0);
                PROMISE(arcs || qs_qubo_energy(index, bits) == energy);
            }
        }
        free(bits);
    }
    free(labelling);
    free(workspace);
}

/* The least energy, if it can be had by trying all labellings of the labels left. */
static bool try_all(const qs_model *model, int64_t *least)
{
    uint16_t labelling[16] = {0};
    uint64_t states = 1;
    bool any = false;
    for (uint32_t p = 0; p < model->sites && states <= STATES; p++) {
        states *= model->labels;
    }
    if (states > STATES || model->sites > 16) {
        return false;
    }
    for (uint64_t state = 0; state < states; state++) {
        uint64_t rest = state;
        bool left = true;
        for (uint32_t p = 0; p < model->sites; p++) {
            labelling[p] = (uint16_t)(rest % model->labels);
            rest /= model->labels;
            left &= !model->kept || model->kept[(size_t)p * model->labels + labelling[p]] != 0;
        }
        int64_t energy = left ? qs_model_energy(model, labelling) : 0;
        *least = left && (!any || energy < *least) ? energy : *least;
        any |= left;
    }
    return any;
}

typedef struct solver {
    qs_solver *run;
    size_t (*workspace)(const qs_model *);
} solver;

static const solver solvers[] = {
    {qs_icm, qs_icm_workspace},
    {qs_anneal, qs_anneal_workspace},
    {qs_expansion, qs_expansion_workspace},
    {qs_swap, qs_swap_workspace},
    {qs_bp, qs_bp_workspace},
    {qs_trws, qs_trws_workspace},
    {qs_best, qs_best_workspace},
};

static void solve_all(const qs_model *model, uint16_t *labelling)
{
    int64_t least = 0;
    bool known = try_all(model, &least);
    for (size_t s = 0; s < sizeof solvers / sizeof *solvers; s++) {
        const qs_solve_options options = {.iterations = STEPS, .seed = s};
        size_t size = solvers[s].workspace(model);
        void *workspace = room(size);
        qs_solution found;
        qs_model_winner(model, labelling);
        if (workspace && (uint64_t)model->sites * model->labels < 20000 &&
            solvers[s].run(model, &options, workspace, size, labelling, &found) == QS_OK) {
            PROMISE(found.energy == qs_model_energy(model, labelling));
            PROMISE(found.lower_bound <= found.energy);
            PROMISE(!known || (found.lower_bound <= least && least <= found.energy));
        }
        free(workspace);
    }
}

typedef struct growing {
    uint8_t *bytes;
    size_t size;
} growing;

static bool grow(void *context, const void *bytes, size_t size)
{
    growing *file = context;
    if (size > MEMORY - file->size) {
        return false;
    }
    memcpy(file->bytes + file->size, bytes, size);
    file->size += size;
    return true;
}

/* The labelling that a file carries is one. */
static void check_known(const qs_index *index)
{
    uint8_t *bits = room((index->qubo->variables + 7) / 8);
    if (bits && index->qubo->known.bytes > 0) {
        qs_qubo_known_state(index->qubo, bits);
        PROMISE(qs_sample_infeasible(index, bits) == 0);
    }
    free(bits);
}

/* A file that qstereo wrote has the least energy of the problem that it was written from. */
static void check_least(const qs_qubo *again, int64_t expected)
{
    size_t index_size = qs_index_workspace(again), model_size = qs_model_workspace(again);
    void *memory = room(index_size), *workspace = room(model_size);
    qs_index index;
    qs_model model;
    int64_t least = 0;
    if (memory && workspace) {
        PROMISE(qs_index_build(again, memory, index_size, &index) == QS_OK);
        check_known(&index);
        if (qs_model_build(&index, workspace, model_size, &model) == QS_OK &&
            try_all(&model, &least)) {
            PROMISE(least == expected);
        }
    }
    free(workspace);
    free(memory);
}

/* Labels of the model's sites become those of the problem's: without the masked cells. */
static void leave_masked_out(const qs_model *model, uint16_t *labelling)
{
    uint32_t sites = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        bool masked = model->mask && (model->mask[p / 8] >> p % 8 & 1) == 0;
        labelling[sites] = labelling[p];
        sites += !masked;
    }
}

/* What qstereo writes it reads again, whatever the problem. */
static void write_again(const qs_model *model, const qs_qubo *qubo, const uint8_t *kept,
                        const int64_t *least, const uint16_t *best)
{
    for (uint32_t form = 0; form < 2 * QS_ST_CUT_ARCS; form++) {
        qs_recode_options options = {.encode = {.encoding = (qs_encoding)(1 + form / 2)},
                                     .truncate = form % 2 != 0,
                                     .kept = kept,
                                     .best = best,
                                     .lower_bound = QS_NO_BOUND};
        growing file = {malloc(MEMORY), 0};
        qs_sink sink = {grow, &file};
        size_t size = qs_recode_workspace(model, &options);
        void *workspace = room(size);
        uint64_t written = 0;
        if (workspace &&
            qs_recode(model, &qubo->labels, &options, &sink, workspace, size, &written) == QS_OK) {
            qs_qubo again;
            qs_status status = qs_qubo_open(file.bytes, file.size, UINT64_MAX, &again, NULL);
            PROMISE(written == file.size && status == QS_OK);
            if (least) {
                check_least(&again, *least);
            }
        }
        free(workspace);
        free(file.bytes);
    }
}

static void reduce_and_write(const qs_model *model, const qs_qubo *qubo, uint16_t *labelling)
{
    const qs_reduce_options options = {.iterations = STEPS};
    size_t cells = (size_t)model->sites * model->labels, size = qs_reduce_workspace(model);
    void *workspace = room(size);
    uint8_t *kept = room(cells);
    qs_reduction reduction;
    int64_t least = 0;
    if (workspace && kept && cells < 20000 &&
        qs_reduce(model, &options, workspace, size, kept, labelling, &reduction) == QS_OK) {
        bool known = try_all(model, &least);
        PROMISE(reduction.lower_bound <= reduction.upper_bound);
        PROMISE(reduction.upper_bound == qs_model_energy(model, labelling));
        PROMISE(!known || (reduction.lower_bound <= least && least <= reduction.upper_bound));
        leave_masked_out(model, labelling);
        write_again(model, qubo, kept, known ? &least : NULL, labelling);
    }
    free(kept);
    free(workspace);
}

static void lay_out(const qs_index *index)
{
    size_t size = qs_model_workspace(index->qubo);
    void *workspace = room(size);
    qs_model model;
    if (workspace && qs_model_build(index, workspace, size, &model) == QS_OK) {
        uint16_t *labelling = room(2 * (size_t)model.sites);
        if (labelling) {
            solve_all(&model, labelling);
            reduce_and_write(&model, index->qubo, labelling);
        }
        free(labelling);
    }
    free(workspace);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    qs_qubo qubo;
    qs_fault fault = {0, NULL};
    qs_status status = qs_qubo_open(data, size, MEMORY, &qubo, &fault);
    PROMISE((status == QS_OK) == (fault.what == NULL));
    if (status != QS_OK) {
        PROMISE(fault.offset <= size || status == QS_E_LIMIT);
        return 0;
    }
    qs_qubo_summary summary;
    qs_qubo_summarise(&qubo, &summary);
    size_t index_size = qs_index_workspace(&qubo), ising_size = qs_ising_workspace(&qubo);
    void *workspace = room(index_size), *sums = room(ising_size);
    qs_index index;
    qs_ising ising;
    if (workspace && qs_index_build(&qubo, workspace, index_size, &index) == QS_OK) {
        if (sums) {
            PROMISE(qs_qubo_ising(&index, sums, ising_size, &ising) == QS_OK);
        }
        check_known(&index);
        repair_samples(&index);
        lay_out(&index);
    }
    free(sums);
    free(workspace);
    return 0;
}
