#include "../../include/qstereo/recode.h"

#include "../base/bytes.h"
#include "../base/saturate.h"
#include "recoding.h"

/* A lattice's head is as long as 4.5 pairs of a list. */
enum { WORTH_A_LATTICE = 5 };

/* ---- What is asked for. ---- */

static qs_encoding encoding_of(const qs_model *model, const qs_encode_options *options)
{
    bool chosen = options->encoding != QS_ENCODING_DEFAULT;
    return chosen ? options->encoding : qs_encoding_default(&model->pairwise);
}

static qs_status choose(qs_recoding *r, const qs_model *model, const qs_encode_options *options)
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

static qs_left_counts count(const qs_model *model, const qs_recode_options *options)
{
    return qs_left_count(model, kept_of(model, options),
                         encoding_of(model, &options->encode) <= QS_ONE_HOT_SPARSE);
}

/* The groups of the cuts are all alike: one run. */
static qs_draft_sizes sizes_of(qs_encoding encoding, const qs_left_counts *c, uint32_t labels)
{
    const qs_encoding_counts counts = {labels, c->open, c->labels, c->edges, c->thresholds};
    qs_encoding_size size = qs_encoding_measure(encoding, &counts);
    const qs_encoding_facts *facts = qs_encoding_facts_of(encoding);
    bool alike = facts && facts->code == QS_CODE_CHAIN && c->open > 0;
    return (qs_draft_sizes){size.variables, alike ? 1 : size.groups, size.couplings};
}

/* Sites and edges are sorted in turn. */
static uint64_t sorted(const qs_left_counts *c)
{
    return c->open > c->edges ? c->open : c->edges;
}

/* Blocks: one a pair of neighbours at most, and one a site. */
static uint64_t blocks_size(const qs_left_counts *c)
{
    return (sizeof(qs_block_of) * (c->edges + c->open + 1) + 7) / 8 * 8;
}

static uint64_t workspace_size_of(const qs_model *model, const qs_recode_options *options,
                                  const qs_left_counts *c)
{
    qs_draft_sizes sizes = sizes_of(encoding_of(model, &options->encode), c, model->labels);
    return qs_left_workspace(model, c, options->truncate) + qs_draft_workspace(sizes) +
           blocks_size(c) + 4 * (c->open + 2 * sorted(c));
}

size_t qs_recode_workspace(const qs_model *model, const qs_recode_options *options)
{
    qs_left_counts c = count(model, options);
    return qs_size(workspace_size_of(model, options, &c));
}

static void lay_out(qs_recoding *r, const qs_model *model, const qs_recode_options *options,
                    const qs_left_counts *c, void *workspace)
{
    qs_draft_sizes sizes = sizes_of(r->encoding, c, model->labels);
    char *at = workspace;
    r->left = qs_left_make(model, kept_of(model, options), c, options->truncate, at);
    at += (size_t)qs_left_workspace(model, c, options->truncate);
    r->draft = qs_draft_in(at, sizes);
    at += (size_t)qs_draft_workspace(sizes);
    r->blocks = (qs_block_of *)(void *)at;
    at += (size_t)blocks_size(c);
    r->set = (uint32_t *)(void *)at;
    r->order = r->set + c->open;
    r->scratch = r->order + sorted(c);
}

/* ---- The file. ---- */

typedef struct side_chunks {
    const qs_left *left;
    qs_labels labels;
    bool kept;
} side_chunks;

static void put_side_chunks(qs_writer *writer, const void *context)
{
    const side_chunks *side = context;
    qs_put_labl(writer, &side->labels);
    if (side->kept) {
        qs_put_kept(writer, side->left);
    }
    if (side->left->cut) {
        qs_put_trnc(writer, side->left);
    }
}

static qs_status write_file(const qs_recoding *r, const qs_labels *labels, const qs_sink *sink,
                            uint64_t *size)
{
    side_chunks side = {&r->left, *labels,
                        r->encoding > QS_ONE_HOT_SPARSE || !r->left.counts.whole};
    side.labels.encoding = r->encoding;
    side.labels.penalty = r->penalty;
    side.labels.gap = (uint32_t)r->gap;
    return qs_draft_write(&r->draft, 1u + side.kept + r->left.cut, put_side_chunks, &side, sink,
                          size);
}

static void fill(qs_recoding *r)
{
    r->draft.offset = r->left.constant;
    r->draft.lattice = WORTH_A_LATTICE;
    if (r->left.counts.open == 0 || r->left.overflow) {
        return;
    }
    switch (r->encoding) {
    case QS_DOMAIN_WALL: qs_recode_wall(r); break;
    case QS_MULTIWAY_CUT: qs_recode_multiway(r); break;
    case QS_ST_CUT:
    case QS_ST_CUT_ARCS: qs_recode_cut(r); break;
    default: qs_recode_one_hot(r); break;
    }
}

qs_status qs_recode(const qs_model *model, const qs_labels *labels,
                    const qs_recode_options *options, const qs_sink *sink, void *workspace,
                    size_t workspace_size, uint64_t *size)
{
    if (!model || !labels || !options || !workspace) {
        return QS_E_ARGUMENT;
    }
    qs_recoding r = {0};
    qs_status status = choose(&r, model, &options->encode);
    if (status != QS_OK) {
        return status;
    }
    qs_left_counts c = count(model, options);
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
    lay_out(&r, model, options, &c, workspace);
    if (r.left.overflow || (r.left.no_model && r.encoding <= QS_DOMAIN_WALL)) {
        return QS_E_OVERFLOW;
    }
    fill(&r);
    return write_file(&r, labels, sink, size);
}
