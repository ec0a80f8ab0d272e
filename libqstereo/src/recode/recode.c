#include "../../include/qstereo/recode.h"

#include "../base/minmax.h"
#include "../encode/labl_chunk.h"
#include "recoder.h"

/* A lattice's head is as long as 4.5 pairs of a list. */
enum { WORTH_A_LATTICE = 5 };

/* ---- What is asked for. ---- */

static qs_encoding encoding_of(const qs_model *model, const qs_encode_options *options)
{
    bool chosen = options->encoding != QS_ENCODING_DEFAULT;
    return chosen ? options->encoding : qs_encoding_default(&model->pairwise);
}

static qs_status choose(qs_recoder *r, const qs_model *model, const qs_encode_options *options)
{
    qs_encode_options own;
    qs_status status = qs_encode_settle(options, &model->pairwise, model->labels, &own);
    if (status == QS_OK) {
        r->encoding = own.encoding;
        r->penalty = own.penalty;
        r->gap = own.gap;
        r->alpha = (uint64_t)own.alpha;
    }
    return status;
}

/* ---- Workspace. ---- */

static const uint8_t *kept_of(const qs_model *model, const qs_recode_options *options)
{
    return options->kept ? options->kept : model->kept;
}

static qs_remaining_counts count(const qs_model *model, const qs_recode_options *options)
{
    const qs_encoding_facts *facts = qs_encoding_facts_of(encoding_of(model, &options->encode));
    return qs_remaining_count(model, kept_of(model, options), facts && facts->is_streamed);
}

/* The groups of the cuts are all alike: one run. */
static qs_draft_sizes sizes_of(qs_encoding encoding, const qs_remaining_counts *c, uint32_t labels)
{
    const qs_encoding_counts counts = {labels, c->undecided, c->labels, c->edges, c->thresholds};
    qs_encoding_size size = qs_encoding_measure(encoding, &counts);
    const qs_encoding_facts *facts = qs_encoding_facts_of(encoding);
    bool alike = facts && facts->code == QS_CODE_CHAIN && c->undecided > 0;
    return (qs_draft_sizes){size.variables, alike ? 1 : size.groups, size.couplings};
}

static void take_workspace(qs_arena *arena, qs_recoder *r, const qs_model *model,
                           const qs_recode_options *options, const qs_remaining_counts *c)
{
    uint64_t sorted = qs_max_u64(c->undecided, c->edges); /* sites and edges are sorted in turn */
    uint64_t blocks = c->edges + c->undecided + 1; /* at most one for each, and a single one */
    r->rest = qs_remaining_take(arena, model, c, options->truncate);
    r->draft =
        qs_draft_take(arena, sizes_of(encoding_of(model, &options->encode), c, model->labels));
    r->blocks = qs_arena_take(arena, blocks, sizeof *r->blocks);
    r->set = qs_arena_take(arena, c->undecided, sizeof *r->set);
    bool kappa = encoding_of(model, &options->encode) == QS_DOMAIN_WALL &&
                 qs_kappa_is_of_values(&model->pairwise);
    if (kappa) {
        r->first_choice = qs_arena_take(arena, c->undecided, sizeof *r->first_choice);
        r->last_choice = qs_arena_take(arena, c->undecided, sizeof *r->last_choice);
    }
    r->order = qs_arena_take(arena, sorted, sizeof *r->order);
    r->scratch = qs_arena_take(arena, sorted, sizeof *r->scratch);
}

static size_t workspace_size_of(const qs_model *model, const qs_recode_options *options,
                                const qs_remaining_counts *c)
{
    qs_arena arena = {0};
    qs_recoder r = {0};
    take_workspace(&arena, &r, model, options, c);
    return qs_arena_size(&arena);
}

size_t qs_recode_workspace(const qs_model *model, const qs_recode_options *options)
{
    qs_remaining_counts c = count(model, options);
    return workspace_size_of(model, options, &c);
}

/* ---- The file. ---- */

typedef struct side_chunks {
    const qs_remaining *rest;
    qs_labels labels;
    bool kept;
    const uint16_t *best; /* NULL = there is no such chunk */
    int64_t lower_bound;
} side_chunks;

static void put_side_chunks(qs_writer *writer, const void *context)
{
    const side_chunks *side = context;
    qs_put_labl(writer, &side->labels, NULL);
    if (side->kept) {
        qs_put_kept(writer, side->rest);
    }
    if (side->rest->trims) {
        qs_put_trnc(writer, side->rest);
    }
    if (side->best) {
        qs_put_best(writer, side->rest, side->best, side->lower_bound);
    }
}

static qs_status write_file(const qs_recoder *r, const qs_labels *labels,
                            const qs_recode_options *options, const qs_sink *sink, uint64_t *size)
{
    const qs_encoding_facts *facts = qs_encoding_facts_of(r->encoding);
    bool plain = facts->is_streamed && r->rest.counts.whole;
    bool knows = options->best && facts->has_model && r->rest.counts.undecided > 0;
    side_chunks side = {&r->rest, *labels, !plain, knows ? options->best : NULL,
                        options->lower_bound};
    side.labels.encoding = r->encoding;
    side.labels.penalty = r->penalty;
    side.labels.gap = (uint32_t)r->gap;
    if (r->encoding == QS_DOMAIN_WALL && side.labels.pairwise.smoothness == QS_TABLE) {
        /* Its blocks do not tell V, only what V adds to the costs of the sites. */
        side.labels.pairwise.smoothness = QS_TABLES;
    }
    uint32_t number = qs_labl_chunks(&labels->meaning) + side.kept + r->rest.trims + knows;
    return qs_draft_write(&r->draft, number, put_side_chunks, &side, sink, size);
}

static qs_recode_into *const encoders[QS_ENCODINGS + 1] = {
    [QS_ONE_HOT] = qs_recode_one_hot,  [QS_ONE_HOT_SPARSE] = qs_recode_one_hot,
    [QS_DOMAIN_WALL] = qs_recode_wall, [QS_MULTIWAY_CUT] = qs_recode_multiway,
    [QS_ST_CUT] = qs_recode_cut,       [QS_ST_CUT_ARCS] = qs_recode_cut,
};

/* Fills in what remains of the problem, and the draft of its QUBO. */
static qs_status fill(qs_recoder *r, const uint8_t *kept)
{
    qs_remaining_fill(&r->rest, kept);
    bool has_model = qs_encoding_facts_of(r->encoding)->has_model;
    if (r->rest.overflow || (r->rest.no_model && has_model)) {
        return QS_E_OVERFLOW;
    }
    r->draft.offset = r->rest.constant;
    r->draft.lattice = WORTH_A_LATTICE;
    if (r->rest.counts.undecided > 0) {
        encoders[r->encoding](r);
    }
    return QS_OK;
}

qs_status qs_recode(const qs_model *model, const qs_labels *labels,
                    const qs_recode_options *options, const qs_sink *sink, void *workspace,
                    size_t workspace_size, uint64_t *size)
{
    if (!model || !labels || !options || !workspace) {
        return QS_E_ARGUMENT;
    }
    qs_recoder r = {0};
    qs_status status = choose(&r, model, &options->encode);
    if (status != QS_OK) {
        return status;
    }
    qs_remaining_counts c = count(model, options);
    qs_draft_sizes sizes = sizes_of(r.encoding, &c, model->labels);
    if (c.empty) {
        return QS_E_ARGUMENT;
    }
    if (sizes.variables > QS_VARIABLES_MAX || sizes.pairs > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    if (workspace_size < workspace_size_of(model, options, &c)) {
        return QS_E_WORKSPACE;
    }
    qs_arena arena = {.base = workspace};
    take_workspace(&arena, &r, model, options, &c);
    status = fill(&r, kept_of(model, options));
    if (status == QS_OK && options->best && !qs_remaining_has(&r.rest, options->best)) {
        status = QS_E_ARGUMENT;
    }
    return status == QS_OK ? write_file(&r, labels, options, sink, size) : status;
}
